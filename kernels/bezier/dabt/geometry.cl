// Dynamic and adaptive tessellation: which candidates each coarse triangle inserts, then its vertices and triangles.
//
// Source    Concheiro 2013, chapter 3 (DABT on the geometry shader); Concheiro et al., GRAPP 2011
// Work      1-D, one item per cell: two coarse triangles
// Reads     map              float[8 * map_stride]  as bezier/row.cl has it, of the finest level
//           controls         float[64 * patches]    as bezier/patch.cl has it
//           sources          uint [8 * patches]     as bezier/cell.cl has it
//           candidates       ulong[17]              inside, by edge (left, right, base) and level, 0 to 3; in columns of a
//                                                   base of level 0 to 3; nodes on edges
//           vertex_offsets   uint [cell_count]      where a cell's vertices begin
//           triangle_offsets uint [cell_count]      where its triangles do
//           vertex_total, triangle_total  uint [1]
// Writes    masks            ulong[2 * cell_count]  inserted nodes of each coarse triangle, bits as bezier/cell.cl has them
//           vertex_counts    uint [cell_count]
//           triangle_counts  uint [cell_count]
//           positions        float[3 * vertex_room]    packed
//           normals          float[3 * vertex_room]    packed, unit length; nothing where NORMALS is 0
//           triangles        uint [3 * triangle_room]
//           counts           uint [2]  live vertices and triangles: none where the room does not suffice
// Needs     bezier/candidates.cl, bezier/emission.cl, bezier/strips.cl
// Plain     bezier/dabt/reference.py
// Defines   TEST (bezier/measures.cl), NORMALS (1: normals too), STREAMING (common/output.cl, 1)

__kernel void dabt_geometry_test(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global const ulong *restrict candidates,
    __global ulong *restrict masks,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const float16 screen,
    const float2 measure, // 1 / diagonal; least measure that inserts, squared but for normals
    const uint map_stride,
    const uint side,
    const uint depth,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    const bezier_map weights = {map, map_stride};
    bezier_measures m;
    bezier_measures_of(&m, controls, weights, number, side, measure, screen, false);
    bezier_coarse both[2];
    bezier_coarse_both(both, &m, depth);
    uint vertices = 0, faces = 0;
    for (uint t = 0; t < 2; ++t) {
        const bezier_coarse own = both[t];
        const uint4 corners = bezier_corners(own.way);
        ulong mask = bezier_edge_mask(own.left, own.right, own.base);
        ulong inside = candidates[bezier_edge_level(own.left)] | candidates[4 + bezier_edge_level(own.right)] |
            candidates[8 + bezier_edge_level(own.base)];
        const ulong columns = candidates[12 + bezier_edge_level(own.base)];
        for (uint r = 2; r < CELL; ++r)
            if ((own.left | own.right) >> r & 1) inside |= columns & ((2ul << r) - 1) << bezier_node(r, 0);
        for (uint r = 2; inside; ++r) {
            const uint first = bezier_node(r, 0);
            for (uint left = bezier_row_bits(inside, r); left; left &= left - 1) {
                const uint c = bezier_lowest(left);
                mask |= (ulong)bezier_inserts(&m, corners, r, c) << (first + c);
            }
            inside &= ~0ul << (first + r);
        }
        masks[2 * number + t] = mask | (ulong)own.way << 60;
        const uint count = (uint)popcount(mask);
        vertices += count;
        faces += bezier_faces(count, mask, candidates[16]);
    }
    vertex_counts[number] = vertices;
    triangle_counts[number] = faces;
}

__kernel void dabt_geometry_emit(
    __global const float *restrict controls,
    __global const uint *restrict sources,
    __global const ulong *restrict masks,
    __global const uint *restrict vertex_offsets,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict vertex_total,
    __global const uint *restrict triangle_total,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict triangles,
    __global uint *restrict counts,
    const uint side,
    const uint vertex_room,
    const uint triangle_room,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    if (!bezier_fits(counts, vertex_total[0], triangle_total[0], vertex_room, triangle_room, number)) return;

    const ulong2 both = vload2(number, masks);
    uint first = vertex_offsets[number];
    bezier_emit(positions, normals, controls, sources, number, both, first, side);
    __global uint *to = triangles + 3 * (size_t)triangle_offsets[number];
    for (uint t = 0; t < 2; ++t) {
        const ulong mask = bezier_nodes(t ? both.y : both.x);
        uchar list[3 * STRIP_TRIANGLES];
        to = bezier_put_triangles(to, list, bezier_strips(list, mask), first);
        first += (uint)popcount(mask);
    }
}
