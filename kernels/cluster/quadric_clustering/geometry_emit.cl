// Quadric vertex clustering, geometry stage: the triangles whose corners lie in three cells, as output vertices.
//
// Source    DeCoro & Tatarchuk 2007, slides 16-17 (final clustering); input order is kept
// Work      1-D, one item per chunk of triangles
// Reads     points        float4[vertex_count]       w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
//           new_ranks     uint[capacity]             output vertex of a cell
//           pieces        uint[3 * triangle_count + 4 * map_count]  ranks of surviving triangles, one piece per map
//           piece_counts  uint[map_count]            triangles in each piece
// Writes    chunk_sums    uint[chunk_count]
//           survivors     uint[3 * triangle_count]   output triangles
//           counts        uint[2]                    [1]: output triangles
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl

__kernel void quadric_clustering_geometry_emit_join(
    __global const uint *restrict pieces,
    __global const uint *restrict piece_counts,
    __global const uint *restrict new_ranks,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint map_count,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint total = 0;
    for (uint map = 0; map < map_count; ++map) total += piece_counts[map];
    const uint2 rows = chunk_rows(chunk, chunk_count, total);
    uint start = 0;
    for (uint map = 0; map < map_count; ++map) {
        const uint end = start + piece_counts[map];
        const uint first = max(rows.x, start), last = min(rows.y, end);
        __global const uint *piece = pieces + 3 * (size_t)geometry_share(map, map_count, triangle_count).x + 4 * map;
        for (size_t i = 3 * (size_t)first; i < 3 * (size_t)last; ++i)
            survivors[i] = new_ranks[piece[i - 3 * (size_t)start]];
        start = end;
    }
    if (chunk == 0) counts[1] = total;
}

static inline uint3 geometry_cells(
    __global const float4 *restrict points, __global const uint *restrict triangles, const uint t)
{
    const uint3 v = vload3(t, triangles);
    return (uint3)(as_uint(points[v.x].w), as_uint(points[v.y].w), as_uint(points[v.z].w));
}

static inline bool geometry_survives(const uint3 c) { return c.x != c.y && c.y != c.z && c.z != c.x; }

__kernel void quadric_clustering_geometry_emit_count(
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
    for (uint t = rows.x; t < rows.y; ++t) count += geometry_survives(geometry_cells(points, triangles, t));
    chunk_sums[chunk] = count;
}

__kernel void quadric_clustering_geometry_emit_write(
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
        const uint3 c = geometry_cells(points, triangles, t);
        if (geometry_survives(c)) vstore3((uint3)(new_ranks[c.x], new_ranks[c.y], new_ranks[c.z]), place++, survivors);
    }
    if (chunk == chunk_count - 1) counts[1] = place;
}
