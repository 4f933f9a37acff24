#version 400
// Evaluation stage of Bezier patches: the point and the unit normal at the (u, v) that the fixed-function tessellator made.
// Concheiro 2013, section 1.2.
layout(quads, equal_spacing, ccw) in;
uniform mat4 world_to_clip;
in vec4 patch_control[]; // v fastest; the first one's w brings the patch's size near 1
patch in int patch_index;
out vec3 surface_position;
out vec3 shaded_normal;
out vec2 weights; // for transform feedback
flat out int patch_number;

const float DEGENERATE = 1e-11, INWARDS = 1.0 / 1024.0;

vec4 cubic(float t)
{
    float s = 1.0 - t;
    return vec4(s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t);
}

vec3 quadratic(float t)
{
    float s = 1.0 - t;
    return vec3(s * s, 2.0 * s * t, t * t);
}

vec3 crossed(vec2 at, out vec3 point)
{
    vec4 b = cubic(at.x), v = cubic(at.y);
    vec3 d = quadratic(at.x), dv = quadratic(at.y);
    float scale = patch_control[0].w;
    vec3 curve[4], across = vec3(0.0);
    for (int j = 0; j < 4; ++j) {
        vec3 p = patch_control[j].xyz, q = patch_control[4 + j].xyz, r = patch_control[8 + j].xyz,
             s = patch_control[12 + j].xyz;
        curve[j] = b.x * p + b.y * q + b.z * r + b.w * s;
        across += v[j] * (d.x * (q - p) + d.y * (r - q) + d.z * (s - r));
    }
    point = v.x * curve[0] + v.y * curve[1] + v.z * curve[2] + v.w * curve[3];
    vec3 along = dv.x * (curve[1] - curve[0]) + dv.y * (curve[2] - curve[1]) + dv.z * (curve[3] - curve[2]);
    return cross(scale * across, scale * along);
}

void main()
{
    weights = gl_TessCoord.xy;
    patch_number = patch_index;
    vec3 n = crossed(weights, surface_position), nearby;
    if (dot(n, n) <= DEGENERATE) n = crossed(weights + INWARDS * (0.5 - weights), nearby);
    shaded_normal = dot(n, n) > 1e-30 ? normalize(n) : vec3(0.0, 0.0, 1.0);
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
