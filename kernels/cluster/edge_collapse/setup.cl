// Edge collapse, set-up: working copies of the mesh, which the sweeps change.
//
// Source    none
// Work      rows: 1-D, one item per chunk of blocks; with a map for each, there are no atomics, which take four times as
//           long on a CPU; points, after it: one item per chunk of vertices
// Reads     positions   float[3 * vertex_count]   model units
//           triangles   uint[3 * triangle_count]
//           locked      uint[vertex_count]        not 0: the vertex stays; one word where none is
// Writes    degrees     uint[map_count * vertex_count]   zero before; triangles at each vertex, in parts
//           points      float4[vertex_count]      x y z brought near 1, triangles at the vertex
//           loss        uint[vertex_count]        to be taken from these: nothing so far
//           parents     uint[vertex_count]        the vertex that it went to: itself
//           rows        uint4[triangle_count]     a b c, row of the input; a = b where the triangle names a vertex twice
//           block_live  uint[blocks]              rows of each block
// Needs     common/chunk.cl
// Plain     cluster/edge_collapse/reference.py

#define LOCKED 4194304.0f  // added to the number of triangles, so that no block has them all

__kernel void edge_collapse_setup_rows(
    __global const uint *restrict triangles,
    __global uint4 *restrict rows,
    __global uint *restrict degrees,
    __global uint *restrict block_live,
    const uint block,
    const uint triangle_count,
    const uint vertex_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const bool alone = chunk_count == map_count;
    __global uint *own = degrees + (alone ? (size_t)chunk * vertex_count : 0);
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
            if (alone) {
                ++own[corners.x];
                ++own[corners.y];
                ++own[corners.z];
            } else {
                atomic_inc(own + corners.x);
                atomic_inc(own + corners.y);
                atomic_inc(own + corners.z);
            }
        }
    }
}

__kernel void edge_collapse_setup_points(
    __global const float *restrict positions,
    __global const uint *restrict locked,
    __global const uint *restrict degrees,
    __global float4 *restrict points,
    __global uint *restrict loss,
    __global uint *restrict parents,
    const float prescale,
    const uint locks,
    const uint vertex_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        uint degree = 0;
        for (uint map = 0; map < map_count; ++map) degree += degrees[(size_t)map * vertex_count + v];
        points[v] = (float4)(vload3(v, positions) * prescale, degree + (locks && locked[v] ? LOCKED : 0.0f));
        loss[v] = 0;
        parents[v] = v;
    }
}
