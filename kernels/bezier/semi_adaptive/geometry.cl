// Semi-adaptive tessellation: the pattern of each coarse triangle by tests on its edges, then its vertices and triangles.
//
// Source    Concheiro 2013, chapter 4; Concheiro et al., GRAPP 2014
// Work      1-D, one item per cell: two coarse triangles
// Reads     map              float[8 * map_stride]  as bezier/row.cl has it, of the finest level
//           controls         float[64 * patches]    as bezier/patch.cl has it
//           sources          uint [8 * patches]     as bezier/cell.cl has it
//           candidates       ulong[17]              the last: nodes on edges
//           shapes           ulong[patterns]        nodes of each pattern
//           lists            uint [48 * patterns]   its triangles, as bezier/semi_adaptive/setup.cl has them
//           vertex_offsets   uint [cell_count]      where a cell's vertices begin
//           triangle_offsets uint [cell_count]      where its triangles do
//           vertex_total, triangle_total  uint [1]
// Writes    masks            ulong[2 * cell_count]  nodes of each coarse triangle, bits as bezier/cell.cl has them
//           numbers          uint [2 * cell_count]  its pattern
//           vertex_counts    uint [cell_count]
//           triangle_counts  uint [cell_count]
//           positions        float[3 * vertex_room]    packed
//           normals          float[3 * vertex_room]    packed, unit length; nothing where NORMALS is 0
//           triangles        uint [3 * triangle_room]
//           counts           uint [2]  live vertices and triangles: none where the room does not suffice
// Needs     bezier/candidates.cl, bezier/emission.cl, bezier/semi_adaptive/edges.cl
// Plain     bezier/semi_adaptive/reference.py
// Defines   TEST (bezier/measures.cl), NORMALS (1: normals too), STREAMING (common/output.cl, 1), HALVES
//           (bezier/semi_adaptive/edges.cl)

__kernel void semi_adaptive_geometry_test(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global const ulong *restrict candidates,
    __global const ulong *restrict shapes,
    __global ulong *restrict masks,
    __global uint *restrict numbers,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const float16 screen,
    const float2 measure, // 1 / diagonal; least measure that inserts, squared but for normals
    const uint map_stride,
    const uint side,
    const uint depth,
    const uint cell_count)
{
    const uint at = get_global_id(0);
    if (at >= cell_count) return;

    const bezier_map weights = {map, map_stride};
    bezier_measures m;
    bezier_measures_of(&m, controls, weights, at, side, measure, screen, true);
    bezier_coarse both[2];
    bezier_coarse_both(both, &m, depth);
    uint vertices = 0, faces = 0;
    for (uint t = 0; t < 2; ++t) {
        const uint left = semi_edge_number(both[t].left), right = semi_edge_number(both[t].right);
        const uint number = (left * EDGE_KINDS + right) * EDGE_KINDS + semi_edge_number(both[t].base);
        const ulong mask = shapes[number];
        masks[2 * at + t] = mask | (ulong)both[t].way << 60, numbers[2 * at + t] = number;
        const uint count = (uint)popcount(mask);
        vertices += count;
        faces += bezier_faces(count, mask, candidates[16]);
    }
    vertex_counts[at] = vertices;
    triangle_counts[at] = faces;
}

__kernel void semi_adaptive_geometry_emit(
    __global const float *restrict controls,
    __global const uint *restrict sources,
    __global const ulong *restrict candidates,
    __global const uint *restrict lists,
    __global const ulong *restrict masks,
    __global const uint *restrict numbers,
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
    const uint at = get_global_id(0);
    if (at >= cell_count) return;

    if (!bezier_fits(counts, vertex_total[0], triangle_total[0], vertex_room, triangle_room, at)) return;

    const ulong2 both = vload2(at, masks);
    uint first = vertex_offsets[at];
    bezier_emit(positions, normals, controls, sources, at, both, first, side);
    __global uint *to = triangles + 3 * (size_t)triangle_offsets[at];
    for (uint t = 0; t < 2; ++t) {
        __global const uint *list = lists + (size_t)numbers[2 * at + t] * LIST_WORDS;
        const ulong mask = bezier_nodes(t ? both.y : both.x);
        const uint vertices = (uint)popcount(mask), count = 3 * bezier_faces(vertices, mask, candidates[16]);
        uint k = 0;
        for (; k + 8 <= count; k += 8) {
            const uint2 words = vload2(k / 8, list);
            const uint8 corners = (uint8)(words.x, words.x, words.x, words.x, words.y, words.y, words.y, words.y);
            vstore8((corners >> (uint8)(0, 8, 16, 24, 0, 8, 16, 24) & 0xff) + first, 0, to + k);
        }
        for (; k < count; ++k) to[k] = (list[k / 4] >> 8 * (k % 4) & 0xff) + first;
        to += count;
        first += vertices;
    }
}
