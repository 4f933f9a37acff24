// Edge collapse, set-up of a sweep: triangles in the order of a curve through the cells of a grid, those that are gone left out.
//
// Source    none; a counting sort, stable, so that the number of chunks changes nothing
// Work      keys, scatter: 1-D, one item per chunk of blocks; scan: one item
// Reads     rows        uint4[triangle_count]     a b c, row of the input; blocks as the sweep before left them
//           block_live  uint[blocks]              rows of each block that count
//           points      float4[vertex_count]
//           orders      uint[...]                 place of each cell along the curve, a curve after the other
//           schedule    uint[16 * sweeps]
// Writes    keys        uint[triangle_count]      place of the row's cell
//           offsets     uint[chunk_count * cells] rows of each cell in each chunk, then where they go
//           state       uint[16]
//           sorted      uint4[triangle_count]     without gaps
// Needs     cluster/edge_collapse/state.cl
// Plain     cluster/edge_collapse/reference.py

static inline uint2 sort_blocks(const uint chunk, const uint chunk_count, const uint blocks)
{
    return (uint2)((uint)((ulong)chunk * blocks / chunk_count), (uint)((ulong)(chunk + 1) * blocks / chunk_count));
}

__kernel void edge_collapse_sort_keys(
    __global const uint4 *restrict rows,
    __global const uint *restrict block_live,
    __global const float4 *restrict points,
    __global const uint *restrict orders,
    __global const uint *restrict schedule,
    __global const uint *restrict state,
    __global uint *restrict keys,
    __global uint *restrict offsets,
    const float4 low,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    __global const uint *sweep = schedule + SWEEP_WORDS * state[SWEEPS];
    const uint bits = sweep[BITS], cells = 1u << 3 * bits;
    __global const uint *order = orders + sweep[ORDER];
    const float4 shift = (float4)(as_float(sweep[SHIFT]), as_float(sweep[SHIFT + 1]), as_float(sweep[SHIFT + 2]), 0.0f);
    const float per_unit = as_float(sweep[CELLS]);
    __global uint *own = offsets + (size_t)chunk * cells;
    for (uint c = 0; c < cells; ++c) own[c] = 0;
    const float4 most = (float)((1u << bits) - 1);
    const uint2 blocks = sort_blocks(chunk, chunk_count, state[BLOCKS_BEFORE]);
    for (uint b = blocks.x; b < blocks.y; ++b) {
        const uint first = b * state[EACH_BEFORE], past = first + block_live[b];
        for (uint t = first; t < past; ++t) {
            const uint4 row = rows[t];
            prefetch(points + rows[min(t + 32, past - 1)].x, 1);
            if (row.x == row.y) continue;
            const int4 cell = convert_int4(clamp((points[row.x] - low) * per_unit + shift, (float4)(0.0f), most));
            const uint key = order[(uint)cell.x << 2 * bits | (uint)cell.y << bits | (uint)cell.z];
            keys[t] = key;
            ++own[key];
        }
    }
}

__kernel void edge_collapse_sort_scan(
    __global const uint *restrict schedule,
    __global uint *restrict offsets,
    __global uint *restrict state,
    const uint chunk_count)
{
    if (get_global_id(0) > 0 || state[DONE]) return;

    __global const uint *sweep = schedule + SWEEP_WORDS * state[SWEEPS];
    const uint cells = 1u << 3 * sweep[BITS], block = sweep[BLOCK_MOST];
    uint sum = 0;
    for (uint c = 0; c < cells; ++c)
        for (uint chunk = 0; chunk < chunk_count; ++chunk) {
            __global uint *own = offsets + (size_t)chunk * cells + c;
            const uint count = *own;
            *own = sum;
            sum += count;
        }
    state[LIVE] = sum;
    state[BLOCKS] = sum <= sweep[WHOLE_MOST] ? (sum > 0) : (sum + block - 1) / block;
    state[EACH] = sum ? (sum + state[BLOCKS] - 1) / state[BLOCKS] : 1;
    state[SAMPLED] = state[TAKEN] = 0;
    state[STRIDE] = clamp(state[BLOCKS] / sweep[ASKED], 1u, sweep[APART]);
    ++state[SWEEPS];
}

__kernel void edge_collapse_sort_scatter(
    __global const uint4 *restrict rows,
    __global const uint *restrict block_live,
    __global const uint *restrict keys,
    __global const uint *restrict schedule,
    __global const uint *restrict state,
    __global uint *restrict offsets,
    __global uint4 *restrict sorted,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    const uint bits = schedule[SWEEP_WORDS * (state[SWEEPS] - 1) + BITS];
    __global uint *own = offsets + ((size_t)chunk << 3 * bits);
    const uint2 blocks = sort_blocks(chunk, chunk_count, state[BLOCKS_BEFORE]);
    for (uint b = blocks.x; b < blocks.y; ++b) {
        const uint first = b * state[EACH_BEFORE], past = first + block_live[b];
        for (uint t = first; t < past; ++t) {
            const uint4 row = rows[t];
            if (row.x != row.y) sorted[own[keys[t]]++] = row;
        }
    }
}
