// Vertex clustering with means: each vertex added to its cell, then each cell's mean.
//
// Source    Rossignac & Borrel 1993, section 3 (representatives), all weights equal
// Work      1-D; `sum` one item per map, each over its share of the vertices, `batch` one over a part of a map's share,
//           `place` one per chunk of occupied cells
// Reads     points      float4[vertex_count]              x y z in units of the largest cell edge, w: bits of the cell's rank
//           used        uchar[capacity]                   1 where a surviving triangle has a corner
//           state       uint[4]                           [0]: occupied cells
// Writes    maps        float[8 * capacity * map_count]   per cell: sums of x y z, vertices, what rounding left out of each
//           solved      float4[capacity]                  the mean, kind; kind 0: not used by any triangle
//           chunk_sums  uint[chunk_count]                 used cells
// Needs     common/chunk.cl
// Plain     cluster/vertex_average/reference.py

static inline void mean_add(__global const float4 *restrict points, __global float8 *restrict map, const uint2 rows)
{
    for (uint v = rows.x; v < rows.y; ++v) {
        const float4 p = points[v];
        const float8 cell = map[as_uint(p.w)];
        // Kahan 1965: what a sum loses is added to the next term
        const float4 term = (float4)(p.xyz, 1.0f) - cell.hi, sum = cell.lo + term;
        map[as_uint(p.w)] = (float8)(sum, (sum - cell.lo) - term);
    }
}

__kernel void vertex_average_mean_sum(
    __global const float4 *restrict points,
    __global float8 *restrict maps,
    const uint vertex_count,
    const uint capacity,
    const uint map_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    __global float8 *own = maps + (size_t)map * capacity;
    for (uint cell = 0; cell < capacity; ++cell) own[cell] = 0.0f;
    mean_add(points, own, chunk_rows(map, map_count, vertex_count));
}

// the map goes on from the batch before
__kernel void vertex_average_mean_batch(
    __global const float4 *restrict points,
    __global float8 *restrict maps,
    const uint map,
    const uint vertex_count,
    const uint capacity)
{
    if (get_global_id(0) > 0) return;

    mean_add(points, maps + (size_t)map * capacity, (uint2)(0, vertex_count));
}

__kernel void vertex_average_mean_place(
    __global const float8 *restrict maps,
    __global const uchar *restrict used,
    __global const uint *restrict state,
    __global float4 *restrict solved,
    __global uint *restrict chunk_sums,
    const uint map_count,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(state[0], capacity));
    uint count = 0;
    for (uint cell = rows.x; cell < rows.y; ++cell) {
        float4 sum = 0.0f;
        for (uint map = 0; map < map_count; ++map) sum += maps[(size_t)map * capacity + cell].lo;
        solved[cell] = (float4)(sum.xyz / max(sum.w, 1.0f), used[cell] ? 1.0f : 0.0f);
        count += used[cell];
    }
    chunk_sums[chunk] = count;
}
