#version 330
// Vertex stage of vertex shader tessellation: the virtual vertex is the vertex, the patch is the instance.
// Concheiro 2013, chapter 2 (VST) and section 1.2.
uniform mat4 world_to_clip;
in vec2 place; // u, v
in mat4 controls_x, controls_y, controls_z; // a column along v for each of four along u
in float scale; // brings the patch's size near 1
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

// Q, Q_u and Q_v along one axis, the latter two over 3 and scaled
vec3 axis(mat4 P, vec4 u, vec3 du, vec4 v, vec3 dv)
{
    vec4 row = P * u;
    vec4 across = du.x * (P[1] - P[0]) + du.y * (P[2] - P[1]) + du.z * (P[3] - P[2]);
    return vec3(dot(row, v), scale * dot(across, v), scale * dot(row.yzw - row.xyz, dv));
}

vec3 crossed(float u, float v, out vec3 point)
{
    vec4 bu = cubic(u), bv = cubic(v);
    vec3 du = quadratic(u), dv = quadratic(v);
    vec3 x = axis(controls_x, bu, du, bv, dv);
    vec3 y = axis(controls_y, bu, du, bv, dv);
    vec3 z = axis(controls_z, bu, du, bv, dv);
    point = vec3(x.x, y.x, z.x);
    return cross(vec3(x.y, y.y, z.y), vec3(x.z, y.z, z.z));
}

void main()
{
    vec3 n = crossed(place.x, place.y, surface_position), nearby;
    if (dot(n, n) <= DEGENERATE) {
        vec2 inner = place + INWARDS * (0.5 - place);
        n = crossed(inner.x, inner.y, nearby);
    }
    shaded_normal = dot(n, n) > 1e-30 ? normalize(n) : vec3(0.0, 0.0, 1.0);
    weights = place;
    patch_number = gl_InstanceID;
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
