// A bicubic patch along one row of its parametric map, eight virtual vertices at a time: points and unit normals.
//
// Source    Concheiro 2013, section 1.2: Q(u, v) = sum B_ij J_{3,i}(u) J_{3,j}(v), normal Q_u x Q_v; where that vanishes
//           the normal is taken a little nearer to the patch's middle (reconstruction)
// Work      functions only. A row is a cubic of its own, walked by powers about its middle. On borders nothing is fused
//           and sums pair what lies opposite: a curve comes out alike from either end, and all control points off it
//           weigh nothing, so that neighbours agree to the bit
// Reads     map       float[8 * map_stride]   at i / n: planes J_{3,0..3}, J_{2,0..2}, t - 1/2; eight more than side
//           controls  float[64 * patches]     of each patch 16 points x y z _, v fastest; the first one's fourth number
//                                             is the power of two that brings the patch's size near 1
// Writes    nothing
// Needs     bezier/output.cl
// Plain     bezier/reference.py
// Defines   STREAMING (bezier/output.cl)

#pragma OPENCL FP_CONTRACT OFF

#define CONTROL_FLOATS 64
#define DEGENERATE 1e-11f // as in reference.py
#define INWARDS 0x1p-10f

typedef struct {
    float16 rows[4];
    float scale;
} bezier_patch;

typedef struct {
    float4 controls[4]; // its own
    float4 point[4];    // powers of v - 1/2
    float4 across[4];   // of Q_u, scaled
    float4 along[3];    // of Q_v, scaled
    float4 last_across, last_along; // Q_u and Q_v at v = 1
} bezier_row;

typedef struct {
    __global const float *weights;
    uint stride;
} bezier_map;

// sums that are the same from either end
#define BEZIER_CUBIC(w0, w1, w2, w3, a, b, c, d) (((w0) * (a) + (w3) * (d)) + ((w1) * (b) + (w2) * (c)))
#define BEZIER_QUADRATIC(w0, w1, w2, a, b, c) (((w0) * (a) + (w2) * (c)) + (w1) * (b))

static inline void bezier_patch_of(bezier_patch *patch, const float16 a, const float16 b, const float16 c, const float16 d)
{
    patch->rows[0] = a, patch->rows[1] = b, patch->rows[2] = c, patch->rows[3] = d;
    patch->scale = a.s3;
}

// a cubic's four control points as powers of t - 1/2; exact zeros where they are one
static inline void bezier_powers(float4 *powers, const float16 controls)
{
    const float4 a = controls.s0123, b = controls.s4567, c = controls.s89ab, d = controls.scdef;
    const float4 wide = d - a, narrow = c - b;
    powers[0] = 0.125f * (a + d) + 0.375f * (b + c);
    powers[1] = 0.75f * (wide + narrow);
    powers[2] = 1.5f * ((a - b) + (d - c));
    powers[3] = wide - 3.0f * narrow;
}

// the curve of row i; `normals` also asks for what makes them
static inline void bezier_row_of(
    bezier_row *row, const bezier_patch *patch, const bezier_map map, const uint i, const bool normals)
{
    __global const float *w = map.weights + i;
    const uint s = map.stride;
    const float16 a = patch->rows[0], b = patch->rows[1], c = patch->rows[2], d = patch->rows[3];
    const float16 r = BEZIER_CUBIC(w[0], w[s], w[2 * s], w[3 * s], a, b, c, d);
    row->controls[0] = r.s0123, row->controls[1] = r.s4567, row->controls[2] = r.s89ab, row->controls[3] = r.scdef;
    bezier_powers(row->point, r);
    if (!normals) return;
    const float16 scale = (float16)(patch->scale);
    const float16 sa = a * scale, sb = b * scale, sc = c * scale, sd = d * scale;
    const float16 q = BEZIER_QUADRATIC(w[4 * s], w[5 * s], w[6 * s], sb - sa, sc - sb, sd - sc);
    bezier_powers(row->across, q);
    const float16 sr = r * scale;
    float4 powers[4];
    bezier_powers(powers, sr);
    row->along[0] = powers[1] * (1.0f / 3.0f), row->along[1] = powers[2] * (2.0f / 3.0f), row->along[2] = powers[3];
    row->last_across = q.scdef, row->last_along = sr.scdef - sr.s89ab;
}

// by powers of t
#define BEZIER_POWERS1(t, m, axis) fma(t, (float8)((m)[1].axis), (float8)((m)[0].axis))
#define BEZIER_POWERS2(t, m, axis) fma(t, BEZIER_POWERS1(t, (m) + 1, axis), (float8)((m)[0].axis))
#define BEZIER_POWERS3(t, m, axis) fma(t, BEZIER_POWERS2(t, (m) + 1, axis), (float8)((m)[0].axis))
#define BEZIER_BASIS(m, axis) BEZIER_CUBIC(w0, w1, w2, w3, m[0].axis, m[1].axis, m[2].axis, m[3].axis)

// a row that is a border, exact: `count` points from column j on; up to `room` may be written
static inline void bezier_border(
    BEZIER_OUT float *out, const bezier_row *row, const bezier_map map, const uint j, const uint count, const uint room)
{
    const float4 *c = row->controls;
    const uint s = map.stride;
    for (uint k = 0; k < count; k += 8) {
        __global const float *w = map.weights + j + k;
        const float8 w0 = vload8(0, w), w1 = vload8(0, w + s), w2 = vload8(0, w + 2 * s), w3 = vload8(0, w + 3 * s);
        const planes8 p = {BEZIER_BASIS(c, x), BEZIER_BASIS(c, y), BEZIER_BASIS(c, z)};
        bezier_put(out + 3 * k, p, room - k);
    }
}

// points of row i: `count` from column j on; up to `room` may be written
static inline void bezier_points(BEZIER_OUT float *out, const bezier_row *row, const bezier_map map, const uint i,
    const uint j, const uint count, const uint room, const uint side)
{
    if (i == 0 || i == side - 1) {
        bezier_border(out, row, map, j, count, room);
        return;
    }
    const float4 *m = row->point;
    __global const float *t = map.weights + 7 * map.stride + j;
    const bool is_last = j + count == side;
    const uint whole = is_last ? count - 1 : count;
    for (uint k = 0; k < whole; k += 8) {
        const float8 v = vload8(0, t + k);
        const planes8 p = {BEZIER_POWERS3(v, m, x), BEZIER_POWERS3(v, m, y), BEZIER_POWERS3(v, m, z)};
        bezier_put(out + 3 * k, p, room - k);
    }
    // where the row crosses a border its own control points are the border's
    if (j == 0) vstore3(row->controls[0].xyz, 0, out);
    if (is_last) vstore3(row->controls[3].xyz, count - 1, out);
}

static inline float3 bezier_cross(const float3 a, const float3 b)
{
    return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// Q_u x Q_v at one place, scaled
static inline float3 bezier_cross_at(const bezier_patch *patch, const float u, const float v)
{
    const float s = 1.0f - u, t = 1.0f - v;
    const float16 a = patch->rows[0] * patch->scale, b = patch->rows[1] * patch->scale;
    const float16 c = patch->rows[2] * patch->scale, d = patch->rows[3] * patch->scale;
    const float16 r = BEZIER_CUBIC(s * s * s, 3.0f * s * s * u, 3.0f * s * u * u, u * u * u, a, b, c, d);
    const float16 q = BEZIER_QUADRATIC(s * s, 2.0f * s * u, u * u, b - a, c - b, d - c);
    const float4 along_u = BEZIER_CUBIC(
        t * t * t, 3.0f * t * t * v, 3.0f * t * v * v, v * v * v, q.s0123, q.s4567, q.s89ab, q.scdef);
    const float4 along_v = BEZIER_QUADRATIC(
        t * t, 2.0f * t * v, v * v, r.s4567 - r.s0123, r.s89ab - r.s4567, r.scdef - r.s89ab);
    return bezier_cross(along_u.xyz, along_v.xyz);
}

static inline float bezier_square(const float3 a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

// `n` as a unit; where it is none, that of a place nearer to the middle
static inline float3 bezier_unit(float3 n, const bezier_patch *patch, const float u, const float v)
{
    float square = bezier_square(n);
    if (square <= DEGENERATE) {
        n = bezier_cross_at(patch, u + INWARDS * (0.5f - u), v + INWARDS * (0.5f - v));
        square = bezier_square(n);
    }
    return square > 1e-30f ? n * (1.0f / sqrt(square)) : (float3)(0.0f, 0.0f, 1.0f);
}

// lanes that have no normal of their own
static inline void bezier_mend(BEZIER_OUT float *out, const int8 is_bad, const bezier_patch *patch, const float u,
    const uint j, const float step, const uint room)
{
    int bad[8];
    vstore8(is_bad, 0, bad);
    for (uint k = 0; k < 8 && k < room; ++k)
        if (bad[k]) vstore3(bezier_unit((float3)(0.0f), patch, u, (float)(j + k) * step), k, out);
}

#define BEZIER_ANY(mask) (as_ulong4(mask).x | as_ulong4(mask).y | as_ulong4(mask).z | as_ulong4(mask).w)

// unit normals of row i: `count` from column j on; up to `room` may be written
static inline void bezier_normals(BEZIER_OUT float *out, const bezier_row *row, const bezier_patch *patch,
    const bezier_map map, const uint i, const uint j, const uint count, const uint room, const uint side)
{
    const float4 *a = row->across, *b = row->along;
    const float step = 1.0f / (float)(side - 1);
    __global const float *t = map.weights + 7 * map.stride + j;
    const bool is_last = j + count == side;
    const uint whole = is_last ? count - 1 : count;
    for (uint k = 0; k < whole; k += 8) {
        const float8 v = vload8(0, t + k);
        const planes8 q = {BEZIER_POWERS3(v, a, x), BEZIER_POWERS3(v, a, y), BEZIER_POWERS3(v, a, z)};
        const planes8 r = {BEZIER_POWERS2(v, b, x), BEZIER_POWERS2(v, b, y), BEZIER_POWERS2(v, b, z)};
        const planes8 n = {fma(q.y, r.z, -(q.z * r.y)), fma(q.z, r.x, -(q.x * r.z)), fma(q.x, r.y, -(q.y * r.x))};
        const float8 square = fma(n.z, n.z, fma(n.y, n.y, n.x * n.x)), scale = float8_rsqrt(square);
        const planes8 unit = {n.x * scale, n.y * scale, n.z * scale};
        bezier_put(out + 3 * k, unit, room - k);
        const int8 is_bad = square <= DEGENERATE;
        if (BEZIER_ANY(is_bad)) bezier_mend(out + 3 * k, is_bad, patch, (float)i * step, j + k, step, room - k);
    }
    if (is_last) {
        const float3 n = bezier_cross(row->last_across.xyz, row->last_along.xyz);
        vstore3(bezier_unit(n, patch, (float)i * step, 1.0f), count - 1, out);
    }
}
