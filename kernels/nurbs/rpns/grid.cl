// The vertices of a KSQuad's grid, a row of eight at a time: points and unit normals.
//
// Source    Concheiro 2013, section 6.3; columns are curves of their own, whose control points are summed once
// Work      functions only; what is fused says so with fma
// Reads     spans     float[48 * records]    as nurbs/basis.cl has them
//           controls  float[4 * controls]    as nurbs/surface.cl has them
//           fives     float[64 * records]    as nurbs/rpns/curves.cl has them
// Writes    nothing
// Needs     nurbs/rpns/curves.cl
// Plain     nurbs/reference.py
// Defines   RATIONAL, NORMALS, STREAMING (nurbs/surface.cl)

#pragma OPENCL FP_CONTRACT OFF

#define RPNS_ADD(sum, w, point)                                                                                        \
    (sum).x = fma(w, (float8)((point).x), (sum).x), (sum).y = fma(w, (float8)((point).y), (sum).y),                    \
    (sum).z = fma(w, (float8)((point).z), (sum).z)

typedef struct {
    float8 values[8], slopes[8]; // by control point, and by difference of two
} rpns_basis;

static inline void rpns_basis_at(rpns_basis *basis, __global const float *span, const float8 t, const uint p)
{
    float8 values[8], slopes[8];
    nurbs_basis8(values, slopes, span, t, 1.0f - t, p);
    for (uint k = 0; k <= p; ++k) basis->values[p - k] = values[k];
#if NORMALS
    for (uint r = 0; r < p; ++r) basis->slopes[p - 1 - r] = slopes[r];
#endif
}

// the basis functions at a span's ends are tables, the same to the bit for both spans that meet there
static inline void rpns_ends(rpns_basis *basis, __global const float *five, const int8 k, const int n, const uint p)
{
    const int8 first = k == 0, last = k == n;
    for (uint l = 0; l <= p; ++l)
        basis->values[l] = as_float8((first & as_int(five[8 * l + LOW])) | (last & as_int(five[8 * l + HIGH]))
            | (~(first | last) & as_int8(basis->values[l])));
}

typedef struct {
    float8 x, y, z, w;
} rpns_points;

static inline void rpns_sum(rpns_points *sum, const float8 share, const rpns_points a)
{
    RPNS_ADD(*sum, share, a);
    if (RATIONAL) sum->w = fma(share, a.w, sum->w);
}

#define RPNS_NONE {(float8)(0.0f), (float8)(0.0f), (float8)(0.0f), (float8)(0.0f)}

// control points of eight curves along u, one for each place along v; their differences, and slopes along v, times scale
static inline __attribute__((always_inline)) void rpns_curves(rpns_points *curve, rpns_points *across, rpns_points *along,
    __global const float *net, const rpns_basis *basis, const uint p, const uint q, const uint step, const float scale)
{
    for (uint k = 0; k <= p; ++k) {
        rpns_points sum = RPNS_NONE, slope = RPNS_NONE;
        float4 here = vload4((size_t)k * step, net);
        for (uint l = 0; l <= q; ++l) {
            RPNS_ADD(sum, basis->values[l], here);
            if (RATIONAL) sum.w = fma(basis->values[l], (float8)(here.w), sum.w);
#if NORMALS
            if (l == q) break;
            const float4 next = vload4((size_t)k * step + l + 1, net), difference = (next - here) * scale;
            RPNS_ADD(slope, basis->slopes[l], difference);
            if (RATIONAL) slope.w = fma(basis->slopes[l], (float8)(difference.w), slope.w);
            here = next;
#else
            if (l < q) here = vload4((size_t)k * step + l + 1, net);
#endif
        }
        curve[k] = sum;
#if NORMALS
        along[k] = slope;
        if (k == 0) continue;
        const rpns_points before = curve[k - 1];
        const rpns_points d = {(sum.x - before.x) * scale, (sum.y - before.y) * scale, (sum.z - before.z) * scale,
            (sum.w - before.w) * scale};
        across[k - 1] = d;
#endif
    }
}

// a row of eight vertices; `values` and `slopes` of its place along u, eight apart. Returns the lanes that have no normal
static inline __attribute__((always_inline)) int8 rpns_row(planes8 *point, planes8 *unit, const rpns_points *curve,
    const rpns_points *across, const rpns_points *along, const float *values, const float *slopes, const uint p, const float3 origin)
{
    rpns_points sum = RPNS_NONE;
    for (uint k = 0; k <= p; ++k) rpns_sum(&sum, (float8)(values[8 * k]), curve[k]);
#if RATIONAL
    const float8 inverse = 1.0f / sum.w;
    sum.x *= inverse, sum.y *= inverse, sum.z *= inverse;
#endif
    point->x = sum.x + origin.x, point->y = sum.y + origin.y, point->z = sum.z + origin.z;
    int8 bad = (int8)(0);
#if NORMALS
    rpns_points c = RPNS_NONE, d = RPNS_NONE;
    for (uint k = 0; k <= p; ++k) rpns_sum(&d, (float8)(values[8 * k]), along[k]);
    for (uint k = 0; k < p; ++k) rpns_sum(&c, (float8)(slopes[8 * k]), across[k]);
    planes8 a = {c.x, c.y, c.z}, b = {d.x, d.y, d.z};
#if RATIONAL
    a.x = (a.x - c.w * sum.x) * inverse, a.y = (a.y - c.w * sum.y) * inverse, a.z = (a.z - c.w * sum.z) * inverse;
    b.x = (b.x - d.w * sum.x) * inverse, b.y = (b.y - d.w * sum.y) * inverse, b.z = (b.z - d.w * sum.z) * inverse;
#endif
    bad = normals_cross8(unit, a, b);
#endif
    return bad;
}

// rows of `columns` vertices, eight columns at a time; the degrees are arguments, so that the common ones can be constants
static inline __attribute__((always_inline)) void rpns_grid(__global float *positions, __global float *normals,
    const nurbs_surface *surface, const nurbs_tables *tables, __global const float *net, __global const float *fives,
    const uint4 at_u, const uint4 at_v, const float8 size, const float scale, const uint p, const uint q)
{
    const int8 lane = (int8)(0, 1, 2, 3, 4, 5, 6, 7);
    const uint rows = (uint)size.s0 + 1, columns = (uint)size.s1 + 1;
    rpns_basis across;
    for (uint j = 0; j < columns; j += 8) {
        rpns_basis basis;
        const float8 tv = rpns_place(lane + (int)j, size.s1, size.s567);
        rpns_basis_at(&basis, tables->spans + SPAN_FLOATS * (size_t)at_v.w, tv, q);
        rpns_ends(&basis, fives + 64 * (size_t)at_v.w, lane + (int)j, (int)columns - 1, q);
        rpns_points curve[8], steps[8], along[8];
        rpns_curves(curve, steps, along, net, &basis, p, q, surface->control_columns, scale);
        const uint count = min(columns - j, 8u);
        for (uint i = 0; i < rows; ++i) {
            if (i % 8 == 0 && (j == 0 || rows > 8)) {
                const float8 t = rpns_place(lane + (int)i, size.s0, size.s234);
                rpns_basis_at(&across, tables->spans + SPAN_FLOATS * (size_t)at_u.w, t, p);
                rpns_ends(&across, fives + 64 * (size_t)at_u.w, lane + (int)i, (int)rows - 1, p);
            }
            planes8 point, unit;
            const uint at = i * columns + j;
            const int8 bad = rpns_row(&point, &unit, curve, steps, along, (const float *)across.values + i % 8,
                (const float *)across.slopes + i % 8, p, surface->origin);
            // what comes after a row's end is the next row's, unless that was begun before
            const uint room = j ? count : rows * columns - at;
            output_put(positions + 3 * at, point, room);
#if NORMALS
            output_put(normals + 3 * at, unit, room);
            if (normals_any(bad)) {
                int lanes[8];
                float t[8], tu[8];
                vstore8(bad, 0, lanes), vstore8(tv, 0, t);
                vstore8(rpns_place((int8)((int)i), size.s0, size.s234), 0, tu);
                for (uint k = 0; k < count; ++k)
                    if (lanes[k])
                        vstore3(nurbs_unit_near(surface, tables, at_u, at_v, tu[0], t[k], scale), at + k, normals);
            }
#endif
        }
    }
}
