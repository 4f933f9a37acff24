#version 330
// Vertex stage of curved PN triangles under a pattern: the control net is the instance, its weights are made here.
// Vlachos et al. 2001, sections 3.1 and 3.3; Boubekeur & Schlick 2005, appendix A.
uniform mat4 world_to_clip;
in vec2 weights; // of corners 1 and 2
// a column per axis; points b300 b030 b003 b210 | b120 b021 b012 b102 | b201 b111, then normals n011 n101 | n200 n020
// n002 n110: sixteen vectors in twelve of the sixteen attributes that every driver has
in mat3x4 controls_0, controls_1, controls_2, controls_3;
out vec3 surface_position;
out vec3 shaded_normal;

void main()
{
    float u = weights.x, v = weights.y, w = 1.0 - u - v;
    float uu = u * u, vv = v * v, ww = w * w;
    surface_position = vec4(w * ww, u * uu, v * vv, 3.0 * ww * u) * controls_0 +
                       vec4(3.0 * w * uu, 3.0 * uu * v, 3.0 * u * vv, 3.0 * w * vv) * controls_1 +
                       vec4(3.0 * ww * v, 6.0 * w * u * v, 0.0, 0.0) * controls_2;
    shaded_normal = normalize(vec4(ww, uu, vv, w * u) * controls_3 + vec4(0.0, 0.0, u * v, w * v) * controls_2);
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
