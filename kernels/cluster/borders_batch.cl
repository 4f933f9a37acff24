// Vertex clustering out of core: which edges of a file that comes in batches have a triangle on one side only?
//
// Source    as borders.cl; vertices whose keys differ may share a slot, since both ends of an edge add hashes of their own
// Work      1-D, one item per chunk of triangles, or of kept vertices; a `mark` that is alone needs no atomics, which
//           take longer on a CPU than they save
// Reads     keys        uint[3 * triangle_count]   one for each vertex, at its triangles' corners
//           ranks       uint[kept_count]           of kept vertices, past those of cells
//           kept_rows   uint[kept_count]           where those stand in the batch
// Writes    marks       int[slot_mask + 1]         sums of all batches: other than zero where an edge does not cancel
//           chunk_sums  uint[chunk_count]          edges of the chunk between marked slots
//           edges       uint[edges]                those edges, three times the triangle and 0, 1 or 2, in order
//           points      float4[vertex_count]       w: a kept vertex gets the bits of its rank
//           cell_ids    uint[vertex_count]         of a kept vertex a number past those of cells
// Needs     common/chunk.cl

static inline uint8 borders_batch_hash8(const uint8 low, const uint8 high)
{
    uint8 x = low * 0x9e3779b1u + 0x85ebca6bu;
    x = ((x ^ (x >> 15)) + high) * 0x2c1b3c6du;
    x = (x ^ (x >> 12)) * 0x297a2d39u;
    return x ^ (x >> 15);
}

// what the edges from a to b add to a and to b; nothing where a is b
static inline void borders_batch_edge8(const uint8 a, const uint8 b, uint8 *at_a, uint8 *at_b)
{
    const uint8 turned = as_uint8(a > b), real = as_uint8(a != b);
    const uint8 hash = borders_batch_hash8(turned ? b : a, turned ? a : b);
    const uint8 x = ((hash ^ turned) - turned) & real;
    const uint8 y = x * 0x7feb352du; // so that the two ends do not cancel in one slot
    *at_a += turned ? y : x;
    *at_b += turned ? x : y;
}

__kernel void cluster_borders_batch_mark(
    __global const uint *restrict keys,
    __global int *restrict marks,
    const uint slot_mask,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; t += 8) {
        // what fills up the last eight is a triangle of one vertex
        uint index[24];
        for (uint j = 0; j < 24; ++j) index[j] = 3 * (ulong)t + j < 3 * (ulong)rows.y ? keys[3 * (size_t)t + j] : 0;
        const uint8 a = (uint8)(index[0], index[3], index[6], index[9], index[12], index[15], index[18], index[21]);
        const uint8 b = (uint8)(index[1], index[4], index[7], index[10], index[13], index[16], index[19], index[22]);
        const uint8 c = (uint8)(index[2], index[5], index[8], index[11], index[14], index[17], index[20], index[23]);
        uint8 sum[3] = {0, 0, 0};
        borders_batch_edge8(a, b, &sum[0], &sum[1]);
        borders_batch_edge8(b, c, &sum[1], &sum[2]);
        borders_batch_edge8(c, a, &sum[2], &sum[0]);
        uint added[24];
        vstore8(sum[0], 0, added);
        vstore8(sum[1], 1, added);
        vstore8(sum[2], 2, added);
        for (uint j = 0; j < 24; ++j) {
            __global int *mark = marks + (index[j] & slot_mask);
            const int own = (int)added[8 * (j % 3) + j / 3];
            if (chunk_count == 1) *mark += own;
            else atomic_add((__global volatile int *)mark, own);
        }
    }
}

__kernel void cluster_borders_batch_count(
    __global const uint *restrict keys,
    __global const int *restrict marks,
    __global uint *restrict chunk_sums,
    const uint slot_mask,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, keys) & slot_mask;
        const uint a = marks[v.x] != 0, b = marks[v.y] != 0, c = marks[v.z] != 0;
        count += (a & b) + (b & c) + (c & a);
    }
    chunk_sums[chunk] = count;
}

__kernel void cluster_borders_batch_write(
    __global const uint *restrict keys,
    __global const int *restrict marks,
    __global const uint *restrict chunk_sums,
    __global uint *restrict edges,
    const uint slot_mask,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint place = chunk_sum_before(chunk, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, keys) & slot_mask;
        const bool a = marks[v.x] != 0, b = marks[v.y] != 0, c = marks[v.z] != 0;
        if (a & b) edges[place++] = 3 * t;
        if (b & c) edges[place++] = 3 * t + 1;
        if (c & a) edges[place++] = 3 * t + 2;
    }
}

__kernel void cluster_borders_batch_keep(
    __global const uint *restrict kept_rows,
    __global const uint *restrict ranks,
    __global float4 *restrict points,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 own = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = own.x; i < own.y; ++i) points[kept_rows[i]].w = as_float(ranks[i]);
}

__kernel void cluster_borders_batch_keep_ids(
    __global const uint *restrict kept_rows,
    __global const uint *restrict ranks,
    __global uint *restrict cell_ids,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 own = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = own.x; i < own.y; ++i) cell_ids[kept_rows[i]] = ranks[i];
}
