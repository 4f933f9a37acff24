// Vertex clustering out of core: which edges of a file that comes in batches have a triangle on one side only?
//
// Source    as borders.cl; vertices whose keys differ may share a slot, since both ends of an edge add hashes of their own
// Work      1-D, one item per chunk of triangles, or of kept vertices
// Reads     keys        uint[3 * triangle_count]   one for each vertex, at its triangles' corners
//           ranks       uint[kept_count]           of kept vertices, past those of cells
//           kept_rows   uint[kept_count]           where those stand in the batch
// Writes    marks       int[slot_mask + 1]         sums of all batches: other than zero where an edge does not cancel
//           chunk_sums  uint[chunk_count]          edges of the chunk between marked slots
//           edges       uint[edges]                those edges, three times the triangle and 0, 1 or 2, in order
//           points      float4[vertex_count]       w: a kept vertex gets the bits of its rank
//           cell_ids    uint[vertex_count]         of a kept vertex a number past those of cells
// Needs     common/chunk.cl

static inline uint borders_batch_hash(const uint low, const uint high)
{
    uint x = low * 0x9e3779b1u + 0x85ebca6bu;
    x = ((x ^ (x >> 15)) + high) * 0x2c1b3c6du;
    x = (x ^ (x >> 12)) * 0x297a2d39u;
    return x ^ (x >> 15);
}

// what the edge from a to b adds to a and to b; none where a is b
static inline uint2 borders_batch_edge(const uint a, const uint b)
{
    const bool turned = a > b;
    const uint x = a == b ? 0 : turned ? -borders_batch_hash(b, a) : borders_batch_hash(a, b);
    const uint y = x * 0x7feb352du; // so that the two ends do not cancel in one slot
    return turned ? (uint2)(y, x) : (uint2)(x, y);
}

__kernel void cluster_borders_batch_mark(
    __global const uint *restrict keys,
    __global volatile int *restrict marks,
    const uint slot_mask,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, keys);
        const uint2 a = borders_batch_edge(v.x, v.y), b = borders_batch_edge(v.y, v.z), c = borders_batch_edge(v.z, v.x);
        atomic_add(marks + (v.x & slot_mask), (int)(a.x + c.y));
        atomic_add(marks + (v.y & slot_mask), (int)(b.x + a.y));
        atomic_add(marks + (v.z & slot_mask), (int)(c.x + b.y));
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
