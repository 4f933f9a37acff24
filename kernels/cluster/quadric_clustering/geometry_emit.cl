// Quadric vertex clustering, geometry stage: the surviving triangles that the walk of pass 1 noted, as output vertices.
//
// Source    DeCoro & Tatarchuk 2007, slides 16-17 (final clustering); input order is kept
// Work      1-D, one item per chunk of triangles
// Reads     pieces        uint[3 * triangle_count + 4 * map_count]  ranks of surviving triangles, one piece per map
//           piece_counts  uint[map_count]            triangles in each piece
//           new_ranks     uint[capacity]             output vertex of a cell
// Writes    survivors     uint[3 * triangle_count]   output triangles
//           counts        uint[2]                    [1]: output triangles
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py

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
