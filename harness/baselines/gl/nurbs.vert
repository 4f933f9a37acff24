#version 330
// Vertex stage of NURBS surfaces, each KSQuad an instance: basis functions are made here, control points are fetched.
// Concheiro 2013, section 6.2; Piegl & Tiller, The NURBS Book, 1997, algorithms A2.2 and A2.3.
uniform mat4 world_to_clip;
uniform sampler2D table; // 1024 texels wide: control points w x, w y, w z, w; then twelve texels for each span
in vec2 place; // on the KSQuad, 0..1 each way
in ivec4 quad; // its first control point, control points along v, its spans' texels along u and along v
in ivec2 degrees;
in vec4 origin; // of control points; w brings the KSQuad's size near 1
out vec3 surface_position;
out vec3 shaded_normal;
out vec2 weights; // for transform feedback
flat out int patch_number;

#ifndef DEGREE_U // given where all surfaces have one: loops are unrolled and arrays are registers
#define DEGREE_U degrees.x
#define DEGREE_V degrees.y
#endif

const float DEGENERATE = 1e-11, INWARDS = 1.0 / 1024.0;

vec4 at(int i) { return texelFetch(table, ivec2(i & 1023, i >> 10), 0); }

float number(int span, int k) { return at(span + k / 4)[k & 3]; }

// N by steps down, and the weights of differences of control points, by the triangular table
void basis(int span, int p, float t, out float values[8], out float slopes[8])
{
    float s = 1.0 - t;
    values[0] = 1.0;
    for (int d = 1; d <= p; ++d) {
        float carried = 0.0;
        for (int r = 0; r < d; ++r) {
            float share = values[r] * number(span, 16 + d * (d - 1) / 2 + r);
            if (d == p) slopes[r] = share * float(p);
            values[r] = carried + share * (t + number(span, r));
            carried = share * (s + number(span, 7 + d - r));
        }
        values[d] = carried;
    }
}

vec3 crossed(float u, float v, out vec3 point)
{
    int p = DEGREE_U, q = DEGREE_V;
    float nu[8], su[8], nv[8], sv[8];
    basis(quad.z, p, u, nu, su);
    basis(quad.w, q, v, nv, sv);
    vec4 sum = vec4(0.0), along_u = vec4(0.0), along_v = vec4(0.0), before = vec4(0.0);
    for (int k = 0; k <= p; ++k) {
        vec4 row = vec4(0.0), slope = vec4(0.0), last = vec4(0.0);
        for (int l = 0; l <= q; ++l) {
            vec4 here = at(quad.x + k * quad.y + l);
            row += nv[q - l] * here;
            if (l > 0) slope += sv[q - l] * (here - last);
            last = here;
        }
        sum += nu[p - k] * row;
        along_v += nu[p - k] * slope;
        if (k > 0) along_u += su[p - k] * (row - before);
        before = row;
    }
    point = sum.xyz / sum.w;
    float scale = origin.w / sum.w;
    return cross(scale * (along_u.xyz - along_u.w * point), scale * (along_v.xyz - along_v.w * point));
}

void main()
{
    vec3 point, nearby;
    vec3 n = crossed(place.x, place.y, point);
    if (dot(n, n) <= DEGENERATE) {
        vec2 inner = place + INWARDS * (0.5 - place);
        n = crossed(inner.x, inner.y, nearby);
    }
    surface_position = origin.xyz + point;
    shaded_normal = dot(n, n) > 1e-30 ? normalize(n) : vec3(0.0, 0.0, 1.0);
    weights = place;
    patch_number = gl_InstanceID;
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
