// The sampler's first half: how many KSDices each KSQuad gets, by the lengths of curves across it on the screen.
//
// Source    Concheiro 2013, section 6.3 (a KSDice covers so many pixels); lengths by five points are a reconstruction
// Work      edges: 1-D over edges, those of KSQuads that are culled return at once; sizes: 1-D over KSQuads that stay
// Reads     edges     uint [8 * edge_count]   surface, first control point, span record across and along, 1: it runs along u,
//                                             lane of `fives` that it lies at, and two KSQuads; the second's number alone
//                                             may be past all, the first's then says: always, or collapsed to a point
//           quads     uint [16 * quad_count]  surface, first control point, span records of u and v, four edges: twice the
//                                             edge's number, 1: it runs the other way; first corner, and corners of a row,
//                                             1: on a surface's border
//           surfaces  uint [16 * surfaces]    as nurbs/surface.cl has them
//           controls  float[4 * controls]     as nurbs/surface.cl has them
//           fives     float[64 * records]     as nurbs/rpns/curves.cl has them
//           flags     uchar[quads]            1: the KSQuad stays
//           kept      uint [quads]            KSQuads that stay, in order
//           total     uint [1]                how many
// Writes    factors   float[4 * edge_count]   segments, and breaks as nurbs/rpns/curves.cl has them
//           sizes     float[8 * quads]        of those that stay: segments along u and v, breaks of u and of v
//           vertex_counts, triangle_counts  uint [quads]
// Needs     nurbs/rpns/curves.cl
// Plain     nurbs/rpns/sampling.py
// Defines   ADAPTIVE (1: by the screen), TOLERANT (1: KSQuads on borders get twice as many), UNIFORM (1: places are even)

#define ALWAYS 0xFFFFFFFFu
#define COLLAPSED 0xFFFFFFFEu

__kernel void rpns_sampler_edges(
    __global const uint *restrict edges,
    __global const uint *restrict surfaces,
    __global const float *restrict controls,
    __global const float *restrict fives,
    __global const uchar *restrict flags,
    __global float *restrict factors,
    const float4 screen_x, // from a point to pixels times w
    const float4 screen_y,
    const float4 screen_w,
    const float side, // of a dice, pixels
    const float finest,
    const uint edge_count)
{
    const uint edge = get_global_id(0);
    if (edge >= edge_count) return;

    const uint8 row = vload8(edge, edges);
    if (row.s6 == COLLAPSED) {
        vstore4((float4)(1.0f, 0.25f, 0.5f, 0.75f), edge, factors);
        return;
    }
    if (row.s6 != ALWAYS && !flags[row.s6] && !flags[row.s7]) return;

    nurbs_surface surface;
    nurbs_surface_of(&surface, surfaces + SURFACE_WORDS * row.s0);
    const bool by_u = row.s4;
    const uint p = surface.p + 1, q = surface.q + 1, columns = surface.control_columns;
    float4 curve[8];
    rpns_curve(curve, controls + 4 * (size_t)row.s1, fives + 64 * (size_t)row.s2, row.s5, by_u ? q : p, by_u ? 1 : columns,
        by_u ? p : q, by_u ? columns : 1);
    const float4 found = rpns_length(
        curve, fives + 64 * (size_t)row.s3, by_u ? p : q, surface.origin, screen_x, screen_y, screen_w);
    vstore4((float4)(rpns_segments(found.x, side, finest), found.yzw), edge, factors);
}

__kernel void rpns_sampler_sizes(
    __global const uint *restrict quads,
    __global const uint *restrict surfaces,
    __global const float *restrict controls,
    __global const float *restrict fives,
    __global const float *restrict factors,
    __global const uint *restrict kept,
    __global const uint *restrict total,
    __global float *restrict sizes,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const float4 screen_x,
    const float4 screen_y,
    const float4 screen_w,
    const float side,
    const float finest,
    const uint quad_count)
{
    const uint slot = get_global_id(0);
    if (slot >= min(total[0], quad_count)) return;

    const uint16 quad = vload16(kept[slot], quads);
    float4 u = (float4)(1.0f, 0.25f, 0.5f, 0.75f), v = u;
#if ADAPTIVE
    nurbs_surface surface;
    nurbs_surface_of(&surface, surfaces + SURFACE_WORDS * quad.s0);
    const uint p = surface.p + 1, q = surface.q + 1, columns = surface.control_columns;
    __global const float *net = controls + 4 * (size_t)quad.s1;
    __global const float *five_u = fives + 64 * (size_t)quad.s2, *five_v = fives + 64 * (size_t)quad.s3;
    float4 curve[8];
    rpns_curve(curve, net, five_v, MIDDLE, q, 1, p, columns);
    u = rpns_length(curve, five_u, p, surface.origin, screen_x, screen_y, screen_w);
    u.x = rpns_segments(u.x, side, finest);
    rpns_curve(curve, net, five_u, MIDDLE, p, columns, q, 1);
    v = rpns_length(curve, five_v, q, surface.origin, screen_x, screen_y, screen_w);
    v.x = rpns_segments(v.x, side, finest);
#endif
    v.x = fmax(v.x, fmax(factors[4 * (quad.s4 >> 1)], factors[4 * (quad.s5 >> 1)]));
    u.x = fmax(u.x, fmax(factors[4 * (quad.s6 >> 1)], factors[4 * (quad.s7 >> 1)]));
#if TOLERANT && ADAPTIVE
    if (quad.sa) u.x *= 2.0f, v.x *= 2.0f;
#endif
    vstore8((float8)(u.x, v.x, u.yzw, v.yzw), slot, sizes);
    vertex_counts[slot] = ((uint)u.x + 1) * ((uint)v.x + 1);
    triangle_counts[slot] = 2 * (uint)u.x * (uint)v.x;
}
