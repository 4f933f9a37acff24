// A surface's tables, the curve of a row of its grid, and its normal where S_u x S_v vanishes.
//
// Source    Concheiro 2013, section 6.2; a row is a curve of its own, whose control points are summed once for each span
// Work      functions only; what is fused says so with fma
// Reads     surfaces  uint [16 * surfaces]   as nurbs_surface has them
//           samples   uint [4 * samples]     of each: first control row, end of its span's samples, span, span record
//           weights   float[15 * stride]     as nurbs/basis.cl writes them
//           controls  float[4 * controls]    w x, w y, w z, w from its origin; v fastest, surface after surface
//           scales    float[quads]           the power of two that brings a KSQuad's size near 1; v fastest
// Writes    nothing
// Needs     nurbs/triangle.cl, common/normals.cl, common/output.cl
// Plain     nurbs/reference.py
// Defines   CHUNK, STREAMING (common/output.cl), RATIONAL (0: all weights are 1), NORMALS

#pragma OPENCL FP_CONTRACT OFF

#define SURFACE_WORDS 16
#define SLOPES 8 // first plane of them, as in basis.cl

typedef struct {
    uint first_vertex, rows, columns;     // of its grid
    uint sample_u, sample_v;              // the first of each side
    uint control, control_columns;        // the first, and how many along v
    uint p, q;                            // degrees along u and v
    uint quad, quad_columns;              // the first KSQuad, and how many along v
    float3 origin;                        // of its control points
} nurbs_surface;

typedef struct {
    __global const uint *samples;
    __global const float *weights, *controls, *scales, *spans, *places;
    uint stride;
} nurbs_tables;

static inline void nurbs_surface_of(nurbs_surface *surface, __global const uint *row)
{
    const uint16 w = vload16(0, row);
    surface->first_vertex = w.s0, surface->rows = w.s1, surface->columns = w.s2;
    surface->sample_u = w.s3, surface->sample_v = w.s4;
    surface->control = w.s5, surface->control_columns = w.s6;
    surface->p = w.s7, surface->q = w.s8;
    surface->quad = w.s9, surface->quad_columns = w.sa;
    surface->origin = as_float3(w.sbcd);
}

// control points of a row's curve over one span of v, and of S_u along it
typedef struct {
    float4 points[8], across[8];
    uint row, first; // whose: the sample along u, and the first control point along v
} nurbs_curve;

// neighbouring spans share control points, which are kept
static inline void nurbs_curve_to(nurbs_curve *curve, const nurbs_surface *surface, const nurbs_tables *tables,
    const uint sample_u, const uint first_u, const uint first_v)
{
    const uint q = surface->q, step = surface->control_columns, stride = tables->stride;
    const uint moved = first_v - curve->first;
    uint l = 0;
    if (curve->row == sample_u && moved <= q)
        for (; l + moved <= q; ++l) {
            curve->points[l] = curve->points[l + moved];
            if (NORMALS) curve->across[l] = curve->across[l + moved];
        }
    curve->row = sample_u, curve->first = first_v;
    __global const float *w = tables->weights + sample_u;
    __global const float *c = tables->controls + 4 * (surface->control + first_u * step + first_v + l);
    for (; l <= q; ++l, c += 4) {
        float4 here = vload4(0, c), sum = here * w[0];
#if NORMALS
        float4 slope = (float4)(0.0f);
#endif
        for (uint k = 1; k <= surface->p; ++k) {
            const float4 next = vload4(0, c + 4 * k * step);
            sum = fma(next, (float4)(w[k * stride]), sum);
#if NORMALS
            slope = fma(next - here, (float4)(w[(SLOPES + k - 1) * stride]), slope);
            here = next;
#endif
        }
        curve->points[l] = sum;
#if NORMALS
        curve->across[l] = slope;
#endif
    }
}

// the unit normal a little nearer to the middle of the KSQuad than t of both spans, where S_u x S_v vanishes; by the
// triangular table, one at a time
static inline float3 nurbs_unit_near(const nurbs_surface *surface, const nurbs_tables *tables, const uint4 at_u,
    const uint4 at_v, float tu, float tv, const float scale)
{
    tu += INWARDS * (0.5f - tu), tv += INWARDS * (0.5f - tv);
    float nu[8], su[8], nv[8], sv[8];
    nurbs_triangle(nu, su, tables->spans + SPAN_FLOATS * at_u.w, tu, 1.0f - tu, surface->p);
    nurbs_triangle(nv, sv, tables->spans + SPAN_FLOATS * at_v.w, tv, 1.0f - tv, surface->q);
    const uint p = surface->p, q = surface->q, step = surface->control_columns;
    __global const float *c = tables->controls + 4 * (surface->control + at_u.x * step + at_v.x);
    float4 sum = (float4)(0.0f), along_u = (float4)(0.0f), along_v = (float4)(0.0f);
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            const float4 here = vload4(k * step + l, c);
            sum += here * (nu[p - k] * nv[q - l]);
            if (k < p) along_u += (vload4((k + 1) * step + l, c) - here) * (su[p - 1 - k] * nv[q - l]);
            if (l < q) along_v += (vload4(k * step + l + 1, c) - here) * (nu[p - k] * sv[q - 1 - l]);
        }
    const float3 point = sum.xyz / sum.w;
    const float3 a = (along_u.xyz - along_u.w * point) * scale, b = (along_v.xyz - along_v.w * point) * scale;
    return normals_unit(normals_cross(a, b));
}
