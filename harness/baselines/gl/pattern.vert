#version 330
// Vertex stage of generic mesh refinement: the pattern's weights are the vertex, the coarse triangle is the instance.
// Boubekeur & Schlick 2005, section 3.2.
uniform mat4 world_to_clip;
in vec2 weights; // of corners 1 and 2
in vec3 p0, p1, p2, n0, n1, n2;
out vec3 surface_position;
out vec3 shaded_normal;

void main()
{
    surface_position = p0 + weights.x * (p1 - p0) + weights.y * (p2 - p0);
    shaded_normal = normalize(n0 + weights.x * (n1 - n0) + weights.y * (n2 - n0));
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
