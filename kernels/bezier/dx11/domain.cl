// Fixed-function tessellation: the tessellator's domain points, and the domain shader that evaluates each by itself.
//
// Source    Direct3D 11 functional specification, tessellation stages; OpenGL 4.0 specification, section 2.12
// Work      1-D, one item per row of a patch's grid, eight vertices at a time
// Reads     controls   float[64 * patches]  as bezier/patch.cl has it
//           factors    float[4 * patches]   of the edges u = 0, u = 1, v = 0, v = 1
//           cuts       uint [4 * patches]   segments of each, at most `segments`
// Writes    positions  float[3 * vertices]  packed; patch after patch, row after row
//           normals    float[3 * vertices]  packed, unit length; nothing where NORMALS is 0
// Needs     bezier/block.cl
// Plain     bezier/dx11/reference.py
// Defines   NORMALS (1: normals too), STREAMING (0)

#pragma OPENCL FP_CONTRACT OFF

// how far segment end m lies from the nearer end of a side
static inline float dx11_place(const uint m, const float factor, const uint segments)
{
    if (2 * m == segments) return 0.5f;
    return m ? ((float)m + 0.5f * (factor - (float)segments)) / factor : 0.0f;
}

static inline float dx11_along(const uint k, const float factor, const uint segments)
{
    const uint m = min(k, segments - k);
    const float t = dx11_place(m, factor, segments);
    return m == k ? t : 1.0f - t;
}

// vertex k of a border, which has its own cuts: the same sum from either end
static inline float3 dx11_border(const float4 a, const float4 b, const float4 c, const float4 d, const uint k,
    const float factor, const uint segments)
{
    const uint m = min(k, segments - k);
    const bool turned = m != k;
    const float t = dx11_place(m, factor, segments), s = 1.0f - t;
    const float4 p = turned ? d : a, q = turned ? c : b, x = turned ? b : c, y = turned ? a : d;
    return BEZIER_CUBIC(s * s * s, 3.0f * s * s * t, 3.0f * s * t * t, t * t * t, p, q, x, y).xyz;
}

static inline void dx11_eight(planes8 *point, planes8 *normal, const bezier_patch *patch, const float8 u, const float8 v)
{
    const float8 s = 1.0f - u, t = 1.0f - v;
    const float8 u0 = s * s * s, u1 = 3.0f * s * s * u, u2 = 3.0f * s * u * u, u3 = u * u * u;
    const float8 v0 = t * t * t, v1 = 3.0f * t * t * v, v2 = 3.0f * t * v * v, v3 = v * v * v;
    planes8 along_u, along_v;
    float8 *p = &point->x, *q = &along_u.x, *r = &along_v.x;
    for (uint axis = 0; axis < 3; ++axis) {
        const float *P = (const float *)patch->rows + axis;
        float8 curve[4];
        for (uint j = 0; j < 4; ++j)
            curve[j] = BEZIER_CUBIC(u0, u1, u2, u3, P[4 * j], P[16 + 4 * j], P[32 + 4 * j], P[48 + 4 * j]);
        p[axis] = BEZIER_CUBIC(v0, v1, v2, v3, curve[0], curve[1], curve[2], curve[3]);
#if NORMALS
        const float scale = patch->scale;
        float8 across[4];
        for (uint j = 0; j < 4; ++j)
            across[j] = BEZIER_QUADRATIC(s * s, 2.0f * s * u, u * u, (P[16 + 4 * j] - P[4 * j]) * scale,
                (P[32 + 4 * j] - P[16 + 4 * j]) * scale, (P[48 + 4 * j] - P[32 + 4 * j]) * scale);
        q[axis] = BEZIER_CUBIC(v0, v1, v2, v3, across[0], across[1], across[2], across[3]);
        r[axis] = scale * BEZIER_QUADRATIC(t * t, 2.0f * t * v, v * v, curve[1] - curve[0], curve[2] - curve[1],
                              curve[3] - curve[2]);
#endif
    }
#if NORMALS
    const int8 is_bad = normals_cross8(normal, along_u, along_v);
    if (normals_any(is_bad)) bezier_mend8(normal, is_bad, patch, u, v);
#endif
}

__kernel void dx11_domain(
    __global const float *restrict controls,
    __global const float *restrict factors,
    __global const uint *restrict cuts,
    __global float *restrict positions,
    __global float *restrict normals,
    const float factor, // of the inside
    const uint segments,
    const uint row_count)
{
    const uint row = get_global_id(0);
    if (row >= row_count) return;

    const uint side = segments + 1, p = row / side, i = row % side;
    bezier_patch patch;
    bezier_patch_at(&patch, controls, p);
    __global float *points = positions + 3 * (size_t)row * side;
    __global float *directions = normals + (NORMALS ? 3 * (size_t)row * side : 0);
    __global const float *own = factors + 4 * p;
    __global const uint *cut = cuts + 4 * p;
    const bool is_border = i == 0 || i == segments;
    const uint edge = i ? 1 : 0; // of a row that is a border

    for (uint j = 0; j < side; j += 8) {
        float us[8], vs[8];
        for (uint k = 0; k < 8; ++k) {
            const uint column = min(j + k, segments);
            us[k] = dx11_along(i, factor, segments);
            vs[k] = dx11_along(column, factor, segments);
            if (is_border)
                vs[k] = dx11_along((column * cut[edge] + segments / 2) / segments, own[edge], cut[edge]);
            else if (column == 0 || column == segments) {
                const uint across = column ? 3 : 2;
                us[k] = dx11_along((i * cut[across] + segments / 2) / segments, own[across], cut[across]);
            }
        }
        planes8 point, normal;
        dx11_eight(&point, &normal, &patch, vload8(0, us), vload8(0, vs));
        output_put(points + 3 * j, point, side - j);
#if NORMALS
        output_put(directions + 3 * j, normal, side - j);
#endif
    }
    const float16 b = patch.rows[i ? 3 : 0];
    if (is_border)
        for (uint j = 0; j < side; ++j) {
            const uint k = (j * cut[edge] + segments / 2) / segments;
            vstore3(dx11_border(b.s0123, b.s4567, b.s89ab, b.scdef, k, own[edge], cut[edge]), j, points);
        }
    else
        for (uint end = 0; end < 2; ++end) {
            float4 q[4];
            for (uint k = 0; k < 4; ++k) q[k] = end ? patch.rows[k].scdef : patch.rows[k].s0123;
            const uint k = (i * cut[2 + end] + segments / 2) / segments;
            const float3 at = dx11_border(q[0], q[1], q[2], q[3], k, own[2 + end], cut[2 + end]);
            vstore3(at, end ? segments : 0, points);
        }
}
