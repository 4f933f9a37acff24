// Vertex clustering, geometry stage: the triangles whose corners lie in three cells, as output vertices.
//
// Source    DeCoro & Tatarchuk 2007, slides 16-17 (final clustering); input order is kept
// Work      1-D, one item per chunk of triangles
// Reads     points        float4[vertex_count]       w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
//           new_ranks     uint[capacity]             output vertex of a cell
// Writes    chunk_sums    uint[chunk_count]
//           survivors     uint[3 * triangle_count]   output triangles
//           counts        uint[2]                    [1]: output triangles
//           used          uchar[capacity]            1 where a surviving triangle has a corner; several items may write
//                                                    the same 1
// Needs     common/chunk.cl

static inline uint3 emit_cells(
    __global const float4 *restrict points, __global const uint *restrict triangles, const uint t)
{
    const uint3 v = vload3(t, triangles);
    return (uint3)(as_uint(points[v.x].w), as_uint(points[v.y].w), as_uint(points[v.z].w));
}

static inline bool emit_survives(const uint3 c) { return c.x != c.y && c.y != c.z && c.z != c.x; }

__kernel void cluster_emit_count(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict chunk_sums,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) count += emit_survives(emit_cells(points, triangles, t));
    chunk_sums[chunk] = count;
}

__kernel void cluster_emit_write(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global const uint *restrict new_ranks,
    __global const uint *restrict chunk_sums,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint place = chunk_sum_before(chunk, chunk_sums);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 c = emit_cells(points, triangles, t);
        if (emit_survives(c)) vstore3((uint3)(new_ranks[c.x], new_ranks[c.y], new_ranks[c.z]), place++, survivors);
    }
    if (chunk == chunk_count - 1) counts[1] = place;
}

__kernel void cluster_emit_mark(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global uchar *restrict used,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 c = emit_cells(points, triangles, t);
        if (emit_survives(c)) used[c.x] = used[c.y] = used[c.z] = 1;
    }
}
