// Edge collapse, set-up: working copies of the mesh, which the sweeps change.
//
// Source    none
// Work      points: 1-D, one item per chunk of vertices; rows: one item per chunk of blocks
// Reads     positions   float[3 * vertex_count]   model units
//           triangles   uint[3 * triangle_count]
//           locked      uint[vertex_count]        not 0: the vertex stays; one word where none is
// Writes    points      float4[vertex_count]      x y z brought near 1, triangles at the vertex (0 so far)
//           loss        uint[vertex_count]        to be taken from the triangles at the vertex, modulo 2^32
//           parents     uint[vertex_count]        the vertex that it went to: itself
//           rows        uint4[triangle_count]     a b c, row of the input; a = b where the triangle names a vertex twice
//           block_live  uint[blocks]              rows of each block
// Needs     common/chunk.cl
// Plain     cluster/edge_collapse/reference.py

#define LOCKED 4194304.0f  // added to the number of triangles, so that no block has them all

__kernel void edge_collapse_setup_points(
    __global const float *restrict positions,
    __global const uint *restrict locked,
    __global float4 *restrict points,
    __global uint *restrict loss,
    __global uint *restrict parents,
    const float prescale,
    const uint locks,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        points[v] = (float4)(vload3(v, positions) * prescale, locks && locked[v] ? LOCKED : 0.0f);
        loss[v] = 0;
        parents[v] = v;
    }
}

__kernel void edge_collapse_setup_rows(
    __global const uint *restrict triangles,
    __global uint4 *restrict rows,
    __global uint *restrict loss,
    __global uint *restrict block_live,
    const uint block,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint blocks = (triangle_count + block - 1) / block;
    const uint begin = (ulong)chunk * blocks / chunk_count, end = (ulong)(chunk + 1) * blocks / chunk_count;
    for (uint b = begin; b < end; ++b) {
        const uint first = b * block, past = min(first + block, triangle_count);
        block_live[b] = past - first;
        for (uint t = first; t < past; ++t) {
            const uint3 corners = vload3(t, triangles);
            const bool whole = corners.x != corners.y && corners.y != corners.z && corners.z != corners.x;
            rows[t] = whole ? (uint4)(corners, t) : (uint4)(0, 0, 0, t);
            if (!whole) continue;
            atomic_dec(loss + corners.x);
            atomic_dec(loss + corners.y);
            atomic_dec(loss + corners.z);
        }
    }
}
