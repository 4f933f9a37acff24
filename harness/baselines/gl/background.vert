#version 330
// A triangle that covers the image, from no vertex data.
out float down;

void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    down = 0.5 - 0.5 * corner.y;
    gl_Position = vec4(corner, 1.0, 1.0);
}
