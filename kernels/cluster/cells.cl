// Vertex clustering, vertex stage: which grid cell does each vertex fall in, and what is the cell's rank?
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (cluster id); the linear address of a cell is replaced by its rank
//           among the occupied cells, so that the cluster map holds occupied cells alone
// Work      1-D, one item per chunk of vertices or of 64-cell words, eight vertices at a time
// Reads     positions    float[3 * vertex_count]     model units
// Writes    marks        uchar[64 * word_count]      1 where a vertex lies; several items may write the same 1
//           words        ulong2[word_count]          x: the cells' bits, y: occupied cells before these 64
//           chunk_sums   uint[chunk_count]
//           state        uint[4]                     [0]: occupied cells
//           points       float4[vertex_count]        x y z in units of the largest cell edge from the box corner, rank's bits
//           vertex_map   uint[vertex_count]          the output vertex, or 0xFFFFFFFF
// Needs     common/chunk.cl common/grid.cl

__kernel void cluster_cells_mark(
    __global const float *restrict positions,
    __global uchar *restrict marks,
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
        const int8 cell = grid_cell8(
            grid_scale8(grid_load8(positions, v, vertex_count), low, per_axis.w), per_axis, cells);
        marks[cell.s0] = 1;
        marks[cell.s1] = 1;
        marks[cell.s2] = 1;
        marks[cell.s3] = 1;
        marks[cell.s4] = 1;
        marks[cell.s5] = 1;
        marks[cell.s6] = 1;
        marks[cell.s7] = 1;
    }
}

__kernel void cluster_cells_count(
    __global const ulong8 *restrict marks,
    __global ulong2 *restrict words,
    __global uint *restrict chunk_sums,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);
    uint sum = 0;
    for (uint w = rows.x; w < rows.y; ++w) {
        // eight bytes of 0 or 1 to eight bits: the product gathers them, lowest byte first, in its top byte
        const ulong8 top = (marks[w] * 0x0102040810204080ul) >> 56;
        const ulong4 four = top.s0246 | (top.s1357 << 8);
        const ulong2 two = four.even | (four.odd << 16);
        const ulong bits = two.x | (two.y << 32);
        words[w] = (ulong2)(bits, 0);
        sum += (uint)popcount(bits);
    }
    chunk_sums[chunk] = sum;
}

__kernel void cluster_cells_rank(
    __global const uint *restrict chunk_sums,
    __global ulong2 *restrict words,
    __global uint *restrict state,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint rank = chunk_sum_before(chunk, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);
    for (uint w = rows.x; w < rows.y; ++w) {
        words[w].y = rank;
        rank += (uint)popcount(words[w].x);
    }
    if (chunk == chunk_count - 1) state[0] = rank;
}

// both by one item, where the words are few: a launch takes longer than these
__kernel void cluster_cells_number(
    __global const ulong8 *restrict marks,
    __global ulong2 *restrict words,
    __global uint *restrict chunk_sums,
    __global uint *restrict state,
    const uint word_count)
{
    if (get_global_id(0) > 0) return;
    cluster_cells_count(marks, words, chunk_sums, word_count, 1);
    cluster_cells_rank(chunk_sums, words, state, word_count, 1);
}

static inline float cell_rank(__global const ulong2 *restrict words, const uint cell, const uint capacity)
{
    const ulong2 word = words[cell / 64];
    const uint rank = (uint)word.y + (uint)popcount(word.x & ((1ul << (cell % 64)) - 1));
    // the maps hold `capacity` cells; a rank past them is told to the host by state[0]
    return as_float(rank < capacity ? rank : capacity - 1);
}

__kernel void cluster_cells_place(
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
        const int8 cell = grid_cell8(q, per_axis, cells);
        const float8 rank = (float8)(
            cell_rank(words, cell.s0, capacity), cell_rank(words, cell.s1, capacity),
            cell_rank(words, cell.s2, capacity), cell_rank(words, cell.s3, capacity),
            cell_rank(words, cell.s4, capacity), cell_rank(words, cell.s5, capacity),
            cell_rank(words, cell.s6, capacity), cell_rank(words, cell.s7, capacity));
        grid_store8(points, q, rank, v, vertex_count);
    }
}

__kernel void cluster_cells_map(
    __global const float4 *restrict points,
    __global const uint *restrict new_ranks,
    __global uint *restrict vertex_map,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) vertex_map[v] = new_ranks[as_uint(points[v].w)];
}
