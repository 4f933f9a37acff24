// A row of a surface's grid, eight or sixteen samples at a time: points and unit normals, out of basis functions at samples.
//
// Source    Concheiro 2013, section 6.2; a row is a curve of its own, whose control points are summed once for each span
// Work      functions only; what is fused says so with fma
// Reads     weights   float[15 * stride]     as nurbs/basis.cl writes them
//           scales    float[quads]           as nurbs/surface.cl has them
// Writes    nothing
// Needs     nurbs/surface.cl
// Plain     nurbs/reference.py
// Defines   CHUNK, STREAMING (common/output.cl), RATIONAL (0: all weights are 1), NORMALS

#pragma OPENCL FP_CONTRACT OFF

#define LONG_RUN 24 // vertices: shorter ones go where they may, aligned or not

#define NURBS_ADD(sum, T, w, point)                                                                                    \
    (sum)->x = fma(w, (T)((point).x), (sum)->x), (sum)->y = fma(w, (T)((point).y), (sum)->y),                          \
    (sum)->z = fma(w, (T)((point).z), (sum)->z)

typedef struct {
    float16 x, y, z;
} planes16;

// `T` lanes of the curve's points, from its origin; 1 / w of each, where RATIONAL
#define NURBS_POINT(name, T, PLANES, LOAD)                                                                             \
    static inline __attribute__((always_inline)) T name(                                                               \
        PLANES *point, const float4 *curve, __global const float *w, const uint stride, const uint q)                  \
    {                                                                                                                  \
        const T zero = (T)(0.0f);                                                                                      \
        T weight = zero;                                                                                               \
        point->x = point->y = point->z = zero;                                                                         \
        for (uint l = 0; l <= q; ++l) {                                                                                \
            const T n = LOAD(0, w + l * stride);                                                                       \
            NURBS_ADD(point, T, n, curve[l]);                                                                          \
            if (RATIONAL) weight = fma(n, (T)(curve[l].w), weight);                                                    \
        }                                                                                                              \
        if (!RATIONAL) return zero;                                                                                    \
        const T inverse = 1.0f / weight;                                                                               \
        point->x *= inverse, point->y *= inverse, point->z *= inverse;                                                 \
        return inverse;                                                                                                \
    }
NURBS_POINT(nurbs_point8, float8, planes8, vload8)
NURBS_POINT(nurbs_point16, float16, planes16, vload16)

// The points of a run: see nurbs_run. Sixteen at a time share the control points; `lead` vertices come before those that
// fill whole vectors of the output, since a store across two lines takes as long as two.
static inline __attribute__((always_inline)) void nurbs_points(OUTPUT float *points, const float4 *curve,
    __global const float *weights, const uint stride, const uint q, const float3 o, const uint count, const uint room,
    const uint lead)
{
    for (uint k = 0; k < count; k = k ? k + 8 : lead) {
        for (; k && k + 16 <= count; k += 16) {
            planes16 p;
            nurbs_point16(&p, curve, weights + k, stride, q);
            const planes8 low = {p.x.lo + o.x, p.y.lo + o.y, p.z.lo + o.z};
            const planes8 high = {p.x.hi + o.x, p.y.hi + o.y, p.z.hi + o.z};
            output_put(points + 3 * k, low, 8);
            output_put(points + 3 * k + 24, high, 8);
        }
        if (k == count) return;
        planes8 p;
        nurbs_point8(&p, curve, weights + k, stride, q);
        const planes8 placed = {p.x + o.x, p.y + o.y, p.z + o.z};
        output_put(points + 3 * k, placed, room - k);
    }
}

// `count` samples of one span from `sample_v` on, the first of which is the chunk's vertex `done`; up to `room` may be
// written
static inline void nurbs_run(OUTPUT float *points, OUTPUT float *normals, nurbs_curve *curve,
    const nurbs_surface *surface, const nurbs_tables *tables, const uint sample_u, const uint sample_v, const uint count,
    const uint room, const uint done)
{
    const uint4 at_u = vload4(sample_u, tables->samples), at_v = vload4(sample_v, tables->samples);
    const uint q = surface->q, stride = tables->stride;
    const uint lead = count < LONG_RUN ? 8 : 8 - done % 8;
    __global const float *weights = tables->weights + sample_v;
    nurbs_curve_to(curve, surface, tables, sample_u, at_u.x, at_v.x);
    if (q == 3) nurbs_points(points, curve->points, weights, stride, 3, surface->origin, count, room, lead);
    else nurbs_points(points, curve->points, weights, stride, q, surface->origin, count, room, lead);
#if NORMALS
    const float scale = tables->scales[surface->quad + at_u.z * surface->quad_columns + at_v.z];
    float4 across[8], along[8];
    for (uint l = 0; l <= q; ++l) across[l] = curve->across[l] * scale;
    for (uint l = 0; l < q; ++l) along[l] = (curve->points[l + 1] - curve->points[l]) * scale;
    for (uint k = 0; k < count; k = k ? k + 8 : lead) {
        __global const float *w = weights + k;
        const float8 zero = (float8)(0.0f);
        planes8 a = {zero, zero, zero}, b = {zero, zero, zero}, unit;
        float8 aw = zero, bw = zero;
        for (uint l = 0; l <= q; ++l) {
            const float8 n = vload8(0, w + l * stride);
            NURBS_ADD(&a, float8, n, across[l]);
            if (RATIONAL) aw = fma(n, (float8)(across[l].w), aw);
        }
        for (uint l = 0; l < q; ++l) {
            const float8 n = vload8(0, w + (SLOPES + l) * stride);
            NURBS_ADD(&b, float8, n, along[l]);
            if (RATIONAL) bw = fma(n, (float8)(along[l].w), bw);
        }
#if RATIONAL
        planes8 p;
        const float8 inverse = nurbs_point8(&p, curve->points, w, stride, q);
        a.x = (a.x - aw * p.x) * inverse, a.y = (a.y - aw * p.y) * inverse, a.z = (a.z - aw * p.z) * inverse;
        b.x = (b.x - bw * p.x) * inverse, b.y = (b.y - bw * p.y) * inverse, b.z = (b.z - bw * p.z) * inverse;
#endif
        const int8 is_bad = normals_cross8(&unit, a, b);
        output_put(normals + 3 * k, unit, room - k);
        if (normals_any(is_bad)) {
            int bad[8];
            vstore8(is_bad, 0, bad);
            for (uint j = 0; j < 8 && k + j < count; ++j)
                if (bad[j]) {
                    const uint sample = sample_v + k + j;
                    const float3 mended = nurbs_unit_near(surface, tables, vload4(sample_u, tables->samples),
                        vload4(sample, tables->samples), tables->places[sample_u], tables->places[sample], scale);
                    vstore3(mended, k + j, normals);
                }
        }
    }
#endif
}
