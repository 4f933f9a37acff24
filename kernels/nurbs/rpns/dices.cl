// The sampler's second half: vertices of the KSQuads that stay, what their borders share, and KSDices as triangles.
//
// Source    Concheiro 2013, sections 6.3 and 6.4.1 (dice culling); how borders of unlike numbers meet is a reconstruction:
//           a grid has no fewer segments than its borders, and vertices on a border move to the nearest of its own
// Work      1-D, each item as many of the KSQuads that stay, one after the other
// Reads     quads, edges, surfaces, spans, controls, scales, fives, factors, sizes, kept, total: see nurbs/rpns/sampler.cl
//           corners   float[3 * corners]     points at all corners of KSQuads, the same to the bit where surfaces share them
//           vertex_offsets, triangle_offsets, vertex_total, triangle_total  uint: where each KSQuad's begin, and how many
// Writes    positions, normals  float[3 * vertices]  KSQuad after KSQuad, v fastest
//           facing    uchar[vertices]        1: the dice that begins at this vertex stays; nothing where DICES is 0
//           triangle_counts  uint [quads]    where DICES is 1
//           triangles uint [3 * triangles]
//           counts    uint [2]               vertices and triangles
// Needs     nurbs/rpns/borders.cl
// Plain     nurbs/rpns/sampling.py
// Defines   WATERTIGHT (1: borders are shared), DICES (1: dices that face away are left out), UNIFORM, NORMALS, RATIONAL

#define COLLAPSED 0xFFFFFFFEu

__kernel void rpns_dices_vertices(
    __global const uint *restrict quads,
    __global const uint *restrict edges,
    __global const uint *restrict surfaces,
    __global const float *restrict spans,
    __global const float *restrict controls,
    __global const float *restrict scales,
    __global const float *restrict fives,
    __global const float *restrict factors,
    __global const float *restrict sizes,
    __global const float *restrict corners,
    __global const uint *restrict kept,
    __global const uint *restrict total,
    __global const uint *restrict vertex_offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uchar *restrict facing,
    __global uint *restrict triangle_counts,
    const float4 eye, // w = 0: there is none
    const uint quad_count,
    const uint vertex_room,
    const uint item_count)
{
    const uint item = get_global_id(0), live = min(total[0], quad_count);
    if (item >= item_count) return;
    const uint end = (uint)((ulong)live * (item + 1) / item_count);
    for (uint slot = (uint)((ulong)live * item / item_count); slot < end; ++slot) {
        const float8 size = vload8(slot, sizes);
        const uint u = (uint)size.s0, v = (uint)size.s1, first = vertex_offsets[slot], number = kept[slot];
        if ((ulong)first + (ulong)(u + 1) * (v + 1) > vertex_room) continue;

        const uint16 quad = vload16(number, quads);
        nurbs_surface surface;
        nurbs_surface_of(&surface, surfaces + SURFACE_WORDS * quad.s0);
        const nurbs_tables tables = {0, 0, controls, scales, spans, 0, 0};
        const uint p = surface.p, q = surface.q, from = quad.s1 - surface.control;
        const uint4 at_u = (uint4)(from / surface.control_columns, 0, 0, quad.s2);
        const uint4 at_v = (uint4)(from % surface.control_columns, 0, 0, quad.s3);
        __global float *points = positions + 3 * (size_t)first, *directions = normals + (NORMALS ? 3 * (size_t)first : 0);
        __global const float *net = controls + 4 * (size_t)quad.s1;
        const float scale = scales[number];
        if (p == 3 && q == 3)
            rpns_grid(points, directions, &surface, &tables, net, fives, at_u, at_v, size, scale, 3, 3);
        else
            rpns_grid(points, directions, &surface, &tables, net, fives, at_u, at_v, size, scale, p, q);
#if WATERTIGHT
        const uint names[4] = {quad.s4, quad.s5, quad.s6, quad.s7};
        for (uint e = 0; e < 4; ++e) {
            const uint8 edge = vload8(names[e] >> 1, edges);
            const float4 factor = vload4(names[e] >> 1, factors);
            const uint n = e < 2 ? v : u;
            // within a surface the vertices are the border's own where it has as many
            if (UNIFORM && edge.s6 < COLLAPSED && n == (uint)factor.x) continue;
            nurbs_surface owner;
            nurbs_surface_of(&owner, surfaces + SURFACE_WORDS * edge.s0);
            const bool by_u = edge.s4;
            const uint columns = owner.control_columns, degree = by_u ? owner.p : owner.q;
            const float3 low = vload3(quad.s8 + (e == 1 ? quad.s9 : e == 3), corners);
            const float3 high = vload3(quad.s8 + (e == 0 ? 1 : e == 2 ? quad.s9 : quad.s9 + 1), corners);
            const uint across = by_u ? owner.q : owner.p, place = e == 1 ? u * (v + 1) : e == 3 ? v : 0;
            __global const float *own = controls + 4 * (size_t)edge.s1, *five = fives + 64 * (size_t)edge.s2 + edge.s5;
            __global const float *span = spans + SPAN_FLOATS * (size_t)edge.s3;
            const uint step = by_u ? 1 : columns, stride = by_u ? columns : 1, apart = e < 2 ? 1 : v + 1, turned = names[e] & 1;
            if (across == 3 && degree == 3)
                rpns_border(points, directions, &owner, own, five, span, 3, 3, by_u, step, stride, place, apart, n, factor,
                    turned, low, high);
            else
                rpns_border(points, directions, &owner, own, five, span, across, degree, by_u, step, stride, place, apart, n,
                    factor, turned, low, high);
        }
        for (uint c = 0; c < 4; ++c)
            vstore3(vload3(quad.s8 + (c & 1) + (c >> 1) * quad.s9, corners), (c & 1) * v + (c >> 1) * u * (v + 1), points);
#endif
#if DICES
        triangle_counts[slot] = 2 * rpns_facing(points, facing + first, u, v, eye);
#endif
    }
}

__kernel void rpns_dices_triangles(
    __global const float *restrict sizes,
    __global const uint *restrict total,
    __global const uint *restrict vertex_offsets,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict vertex_total,
    __global const uint *restrict triangle_total,
    __global const uchar *restrict facing,
    __global uint *restrict triangles,
    __global uint *restrict counts,
    const uint quad_count,
    const uint vertex_room,
    const uint triangle_room,
    const uint item_count)
{
    const uint item = get_global_id(0), live = min(total[0], quad_count);
    if (item >= item_count) return;
    const bool fits = vertex_total[0] <= vertex_room && triangle_total[0] <= triangle_room;
    if (item == 0) counts[0] = fits ? vertex_total[0] : 0, counts[1] = fits ? triangle_total[0] : 0;
    if (!fits) return;
    const uint end = (uint)((ulong)live * (item + 1) / item_count);
    for (uint slot = (uint)((ulong)live * item / item_count); slot < end; ++slot) {
        const uint u = (uint)sizes[8 * slot], v = (uint)sizes[8 * slot + 1], first = vertex_offsets[slot];
        __global uint *out = triangles + 3 * (size_t)triangle_offsets[slot];
        for (uint i = 0; i < u; ++i)
            for (uint j = 0; j < v; ++j) {
                const uint a = first + i * (v + 1) + j, b = a + v + 1;
#if DICES
                if (!facing[a]) continue;
#endif
                out[0] = a, out[1] = b, out[2] = b + 1, out[3] = a, out[4] = b + 1, out[5] = a + 1;
                out += 6;
            }
    }
}
