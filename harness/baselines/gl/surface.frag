#version 330
// Fragment stage: the lights of kernels/stages/fragment.cl, written as a shader.
uniform vec4 key_light, fill_light, sky_light, highlight; // xyz direction, w strength
uniform vec3 surface_colour;
in vec3 shaded_normal;
out vec4 colour;

void main()
{
    vec3 n = normalize(shaded_normal) * (gl_FrontFacing ? 1.0 : -1.0);
    float lit = max(dot(n, key_light.xyz), 0.0) * key_light.w + max(dot(n, fill_light.xyz), 0.0) * fill_light.w +
                (dot(n, sky_light.xyz) * 0.33 + 0.67) * sky_light.w;
    float shine = max(dot(n, highlight.xyz), 0.0);
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine;
    colour = vec4(sqrt(max(surface_colour * lit + shine * highlight.w, 0.0)), 1.0);
}
