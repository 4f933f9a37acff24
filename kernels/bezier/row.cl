// A row of a patch's parametric map, eight virtual vertices at a time: points and unit normals.
//
// Source    Concheiro 2013, section 1.2 and chapter 2
// Work      functions only. A row is a cubic of its own, walked by powers about its middle; what lies on a border is
//           summed as bezier/patch.cl says, where all control points off it weigh nothing
// Reads     map  float[8 * map_stride]  at i / n: planes J_{3,0..3}, J_{2,0..2}, t - 1/2; eight more than side
// Writes    nothing
// Needs     bezier/normal.cl
// Plain     bezier/reference.py
// Defines   NORMALS (1: normals too), STREAMING (bezier/output.cl)

#pragma OPENCL FP_CONTRACT OFF

typedef struct {
    float4 controls[4]; // its own
    float4 point[4];    // powers of v - 1/2
    float4 across[4];   // of Q_u over 3, scaled
    float4 along[3];    // of Q_v over 3, scaled
    float4 last_across, last_along; // both at v = 1
} bezier_row;

typedef struct {
    __global const float *weights;
    uint stride;
} bezier_map;

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

// lanes that have no normal of their own
static inline void bezier_mend(BEZIER_OUT float *out, const int8 is_bad, const bezier_patch *patch, const float u,
    const uint j, const float step, const uint room)
{
    int bad[8];
    vstore8(is_bad, 0, bad);
    for (uint k = 0; k < 8 && k < room; ++k)
        if (bad[k]) vstore3(bezier_unit((float3)(0.0f), patch, u, (float)(j + k) * step), k, out);
}

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
        planes8 n;
        const int8 is_bad = bezier_unit8(&n, q, r);
        bezier_put(out + 3 * k, n, room - k);
        if (bezier_any(is_bad)) bezier_mend(out + 3 * k, is_bad, patch, (float)i * step, j + k, step, room - k);
    }
    if (is_last) {
        const float3 n = bezier_cross(row->last_across.xyz, row->last_along.xyz);
        vstore3(bezier_unit(n, patch, (float)i * step, 1.0f), count - 1, out);
    }
}

// the patch's vertices from number `vertex` on, `most` of them or all that are left; returns how many
static inline uint bezier_rows(BEZIER_OUT float *points, BEZIER_OUT float *normals, const bezier_patch *patch,
    const bezier_map map, const uint vertex, const uint most, const uint side)
{
    uint i = vertex / side, j = vertex % side, done = 0;
    for (; i < side && done < most; ++i, j = 0) {
        const uint here = min(side - j, most - done);
        bezier_row row;
        bezier_row_of(&row, patch, map, i, NORMALS);
        bezier_points(points + 3 * done, &row, map, i, j, here, most - done, side);
        if (NORMALS) bezier_normals(normals + 3 * done, &row, patch, map, i, j, here, most - done, side);
        done += here;
    }
    return done;
}
