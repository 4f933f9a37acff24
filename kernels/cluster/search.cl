// Vertex clustering, search: how many triangles a grid leaves.
//
// Source    none
// Work      1-D, one item per chunk of vertices or triangles
// Reads     positions  float[3 * vertex_count]       model units
//           triangles  uint[3 * triangle_count]
// Writes    cell_ids   uint[vertex_count]            linear cell number, x fastest
//           slots      uint[slot_mask + 1]           all 0xFFFFFFFF before; a triangle's number after
//           survivors  uint[chunk_count]             per chunk: triangles with corners in three cells; in `distinct`
//                                                    those of them that were the first to take a slot
// Needs     common/chunk.cl common/grid.cl common/corners.cl

__kernel void cluster_search_cells(
    __global const float *restrict positions,
    __global uint *restrict cell_ids,
    const float4 low,
    const float4 per_axis, // w: units per model unit
    const uint4 cells,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; v += 8) {
        const uint8 cell = as_uint8(grid_cell8(
            grid_scale8(grid_load8(positions, v, vertex_count), low, per_axis.w), per_axis, cells));
        if (v + 8 <= vertex_count) {
            vstore8(cell, 0, cell_ids + v);
        } else {
            uint last[8];
            vstore8(cell, 0, last);
            for (uint j = 0; j < vertex_count - v; ++j) cell_ids[v + j] = last[j];
        }
    }
}

// every `stride`-th triangle
__kernel void cluster_search_survivors(
    __global const uint *restrict cell_ids,
    __global const uint *restrict triangles,
    __global uint *restrict survivors,
    const uint stride,
    const uint sample_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, sample_count);
    uint count = 0;
    for (uint i = rows.x; i < rows.y; ++i) {
        const uint3 v = vload3(i * (size_t)stride, triangles);
        const uint a = cell_ids[v.x], b = cell_ids[v.y], c = cell_ids[v.z];
        count += (a != b) & (b != c) & (c != a);
    }
    survivors[chunk] = count;
}

// each set of three cells counts once: whichever of its triangles comes first takes the slot, and the sum over all
// chunks is the same for any order
__kernel void cluster_search_distinct(
    __global const uint *restrict cell_ids,
    __global const uint *restrict triangles,
    __global uint *restrict slots,
    __global uint *restrict survivors,
    const uint slot_mask,
    const uint stride,
    const uint sample_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, sample_count);
    uint count = 0;
    for (uint i = rows.x; i < rows.y; ++i) {
        const uint3 v = vload3(i * (size_t)stride, triangles);
        const uint3 key = corners_sorted((uint3)(cell_ids[v.x], cell_ids[v.y], cell_ids[v.z]));
        if (key.x == key.y || key.y == key.z) continue;
        // at least half of the slots are free, so the walk ends
        for (uint slot = corners_slot(key, slot_mask);; slot = (slot + 1) & slot_mask) {
            const uint found = atomic_cmpxchg(slots + slot, NO_TRIANGLE, i);
            if (found == NO_TRIANGLE) {
                ++count;
                break;
            }
            const uint3 w = vload3(found * (size_t)stride, triangles);
            if (corners_same(corners_sorted((uint3)(cell_ids[w.x], cell_ids[w.y], cell_ids[w.z])), key)) break;
        }
    }
    survivors[chunk] = count;
}
