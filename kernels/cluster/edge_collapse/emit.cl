// Edge collapse, the end of a frame: vertices that triangles still have, numbered in the input's order, and these triangles.
//
// Source    none
// Work      1-D, one item per chunk of vertices or of blocks
// Reads     points      float4[vertex_count]      w: triangles at the vertex
//           parents     uint[vertex_count]        where a vertex went
//           rows        uint4[triangle_count]
//           block_live  uint[blocks]
//           state       uint[16]
//           chunk_sums  uint[chunk_count]         vertices of each chunk
// Writes    numbers     uint[vertex_count]        of the output, 0xFFFFFFFF where none
//           vertices    float[3 * vertex_count]   model units
//           survivors   uint[3 * triangle_count]
//           sources     uint[triangle_count]      row of the input
//           counts      uint[2]                   vertices, triangles
//           vertex_map  uint[vertex_count]        output vertex of each input vertex
// Needs     common/chunk.cl cluster/edge_collapse/state.cl
// Plain     cluster/edge_collapse/reference.py

static inline bool emit_used(const float4 p) { return p.w > 0.0f && p.w != 4194304.0f; }

__kernel void edge_collapse_emit_count(
    __global const float4 *restrict points,
    __global uint *restrict chunk_sums,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    uint sum = 0;
    for (uint v = range.x; v < range.y; ++v) sum += emit_used(points[v]);
    chunk_sums[chunk] = sum;
}

__kernel void edge_collapse_emit_vertices(
    __global const float4 *restrict points,
    __global const uint *restrict chunk_sums,
    __global uint *restrict numbers,
    __global float *restrict vertices,
    __global uint *restrict counts,
    const float unscale,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    uint at = chunk_sum_before(chunk, chunk_sums);
    for (uint v = range.x; v < range.y; ++v) {
        const float4 p = points[v];
        const bool used = emit_used(p);
        if (used) vstore3(clamp(p.xyz * unscale, -3.4e38f, 3.4e38f), at, vertices);
        numbers[v] = used ? at++ : 0xFFFFFFFFu;
    }
    if (chunk == chunk_count - 1) counts[0] = at;
}

__kernel void edge_collapse_emit_triangles(
    __global const uint4 *restrict rows,
    __global const uint *restrict block_live,
    __global const uint *restrict numbers,
    __global const uint *restrict state,
    __global uint *restrict survivors,
    __global uint *restrict sources,
    __global uint *restrict counts,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint blocks = state[BLOCKS_BEFORE], each = state[EACH_BEFORE];
    const uint begin = (ulong)chunk * blocks / chunk_count, end = (ulong)(chunk + 1) * blocks / chunk_count;
    uint at = 0;
    for (uint b = 0; b < begin; ++b) at += block_live[b];
    for (uint b = begin; b < end; ++b)
        for (uint t = b * each; t < b * each + block_live[b]; ++t) {
            const uint4 row = rows[t];
            vstore3((uint3)(numbers[row.x], numbers[row.y], numbers[row.z]), at, survivors);
            sources[at++] = row.w;
        }
    if (chunk == chunk_count - 1) counts[1] = at;
}

__kernel void edge_collapse_emit_map(
    __global const uint *restrict parents,
    __global const uint *restrict numbers,
    __global uint *restrict vertex_map,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        uint root = v;
        while (parents[root] != root) root = parents[root];
        vertex_map[v] = numbers[root];
    }
}
