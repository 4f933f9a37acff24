// Octree, vertex stage: which finest cell does each vertex fall in, and what is the cell's rank along the Morton curve?
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (cluster id) and 29-31 (octree)
// Work      1-D, one item per chunk of vertices, eight at a time
// Reads     positions  float[3 * vertex_count]     model units
//           words      ulong2[]                    x: the cells' bits, y: occupied cells before these 64
// Writes    bits       uint[4 * word_count]        the same words as halves: 1 where a vertex lies; in any order
//           points     float[4 * vertex_count]     x y z in units of the finest cell edge from the box corner, rank's bits
// Needs     common/chunk.cl common/grid.cl cluster/cells.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

__kernel void octree_vertex_mark(
    __global const float *restrict positions,
    volatile __global uint *restrict bits,
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
        uint code[8];
        vstore8(octree_code8(grid_scale8(grid_load8(positions, v, vertex_count), low, per_axis.w), per_axis, cells), 0, code);
        for (uint j = 0; j < 8; ++j) {
            volatile __global uint *half_word = bits + 4 * (size_t)(code[j] / 64) + code[j] / 32 % 2;
            const uint bit = 1u << (code[j] % 32);
            if (!(*half_word & bit)) atomic_or(half_word, bit); // most are there already
        }
    }
}

__kernel void octree_vertex_place(
    __global const float *restrict positions,
    __global const ulong2 *restrict words,
    __global float *restrict points,
    const float4 low,
    const float4 per_axis,
    const uint4 cells,
    const uint capacity,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; v += 8) {
        const grid_points8 q = grid_scale8(grid_load8(positions, v, vertex_count), low, per_axis.w);
        uint code[8];
        float ranks[8];
        vstore8(octree_code8(q, per_axis, cells), 0, code);
        for (uint j = 0; j < 8; ++j) ranks[j] = cell_rank(words, code[j], capacity);
        grid_store8(points, q, vload8(0, ranks), v, vertex_count);
    }
}
