// The vertices of a KSQuad's grid, a row of eight at a time: points and unit normals.
//
// Source    Concheiro 2013, section 6.3; a row is a curve of its own, whose control points are summed once
// Work      functions only; what is fused says so with fma
// Reads     spans     float[48 * records]    as nurbs/basis.cl has them
//           controls  float[4 * controls]    as nurbs/surface.cl has them
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

// where S_u x S_v vanishes: the normal a little nearer to the KSQuad's middle
static inline float3 rpns_unit_near(const nurbs_surface *surface, const nurbs_tables *tables, const uint4 at_u,
    const uint4 at_v, const float tu, const float tv, const float scale)
{
    const float3 n = nurbs_normal_near(
        surface, tables, at_u, at_v, tu + INWARDS * (0.5f - tu), tv + INWARDS * (0.5f - tv), scale);
    const float square = n.x * n.x + n.y * n.y + n.z * n.z;
    return square > 1e-30f ? n * (1.0f / sqrt(square)) : (float3)(0.0f, 0.0f, 1.0f);
}

// row `lane` of eight along u; `along` for eight along v. Returns the lanes that have no normal
static inline int8 rpns_row(planes8 *point, planes8 *unit, __global const float *net, const float *across,
    const float *slope, const rpns_basis *along, const uint p, const uint q, const uint step, const float3 origin, const float scale)
{
    float4 curve[8], turned[8];
    for (uint l = 0; l <= q; ++l) {
        float4 here = vload4(l, net), sum = here * across[0];
#if NORMALS
        float4 difference = (float4)(0.0f);
#endif
        for (uint k = 1; k <= p; ++k) {
            const float4 next = vload4((size_t)k * step + l, net);
            sum = fma(next, (float4)(across[8 * k]), sum);
#if NORMALS
            difference = fma(next - here, (float4)(slope[8 * (k - 1)]), difference);
            here = next;
#endif
        }
        curve[l] = sum;
#if NORMALS
        turned[l] = difference * scale;
#endif
    }
    const float8 zero = (float8)(0.0f);
    planes8 sum = {zero, zero, zero};
    float8 weight = zero;
    for (uint l = 0; l <= q; ++l) {
        RPNS_ADD(sum, along->values[l], curve[l]);
        if (RATIONAL) weight = fma(along->values[l], (float8)(curve[l].w), weight);
    }
#if RATIONAL
    const float8 inverse = 1.0f / weight;
    sum.x *= inverse, sum.y *= inverse, sum.z *= inverse;
#endif
    point->x = sum.x + origin.x, point->y = sum.y + origin.y, point->z = sum.z + origin.z;
    int8 bad = (int8)(0);
#if NORMALS
    planes8 a = {zero, zero, zero}, b = {zero, zero, zero};
    float8 aw = zero, bw = zero;
    for (uint l = 0; l <= q; ++l) {
        RPNS_ADD(a, along->values[l], turned[l]);
        if (RATIONAL) aw = fma(along->values[l], (float8)(turned[l].w), aw);
    }
    for (uint l = 0; l < q; ++l) {
        const float4 difference = (curve[l + 1] - curve[l]) * scale;
        RPNS_ADD(b, along->slopes[l], difference);
        if (RATIONAL) bw = fma(along->slopes[l], (float8)(difference.w), bw);
    }
#if RATIONAL
    a.x = (a.x - aw * sum.x) * inverse, a.y = (a.y - aw * sum.y) * inverse, a.z = (a.z - aw * sum.z) * inverse;
    b.x = (b.x - bw * sum.x) * inverse, b.y = (b.y - bw * sum.y) * inverse, b.z = (b.z - bw * sum.z) * inverse;
#endif
    bad = bezier_unit8(unit, a, b);
#endif
    return bad;
}

// rows of `columns` vertices, eight by eight; the degrees are arguments, so that the common ones can be constants
static inline __attribute__((always_inline)) void rpns_grid(__global float *positions, __global float *normals,
    const nurbs_surface *surface, const nurbs_tables *tables, __global const float *net, const uint4 at_u,
    const uint4 at_v, const float8 size, const float scale, const uint p, const uint q)
{
    const int8 lane = (int8)(0, 1, 2, 3, 4, 5, 6, 7);
    const uint rows = (uint)size.s0 + 1, columns = (uint)size.s1 + 1;
    for (uint j = 0; j < columns; j += 8) {
        rpns_basis along, across;
        const float8 tv = rpns_place(lane + (int)j, size.s1, size.s567);
        rpns_basis_at(&along, tables->spans + SPAN_FLOATS * (size_t)at_v.w, tv, q);
        const uint count = min(columns - j, 8u);
        for (uint i = 0; i < rows; ++i) {
            float tu[8];
            if (i % 8 == 0) {
                const float8 t = rpns_place(lane + (int)i, size.s0, size.s234);
                rpns_basis_at(&across, tables->spans + SPAN_FLOATS * (size_t)at_u.w, t, p);
            }
            planes8 point, unit;
            const uint at = i * columns + j;
            const int8 bad = rpns_row(&point, &unit, net, (const float *)across.values + i % 8,
                (const float *)across.slopes + i % 8, &along, p, q, surface->control_columns, surface->origin, scale);
            // what comes after a row's end is the next row's, unless that was begun before
            const uint room = j ? count : rows * columns - at;
            bezier_put(positions + 3 * at, point, room);
#if NORMALS
            bezier_put(normals + 3 * at, unit, room);
            if (bezier_any(bad)) {
                int lanes[8];
                float t[8];
                vstore8(bad, 0, lanes), vstore8(tv, 0, t);
                vstore8(rpns_place((int8)((int)i), size.s0, size.s234), 0, tu);
                for (uint k = 0; k < count; ++k)
                    if (lanes[k])
                        vstore3(rpns_unit_near(surface, tables, at_u, at_v, tu[0], t[k], scale), at + k, normals);
            }
#endif
        }
    }
}
