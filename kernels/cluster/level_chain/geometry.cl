// Level chain, geometry stage: of the triangles that the level before streamed out, those with corners in three cells.
//
// Source    DeCoro & Tatarchuk 2007, slides 16-17 (final clustering), from the mesh streamed out before; its vertices
//           carry their cells, for a representative may lie outside of its own
// Work      1-D, one item per chunk of the level before's triangles, the same chunks for both kernels
// Reads     triangles      uint[3 * triangle_capacity]  of the level before
//           fine_counts    uint[2]                      [1]: how many
//           parents        uint[fine_capacity]          the cell, by rank, of each vertex of the level before
//           new_ranks      uint[capacity]               output vertex of a cell
// Writes    pieces         uint[3 * triangle_capacity]  ranks of surviving triangles, from the start of each chunk
//           piece_counts   uint[chunk_count]            how many there are
//           maps           float[16 * capacity]         the surviving corners: 1 where there are any; several items may
//                                                       write the same 1
//           sums           long[14 * capacity]          the same in fixed point
//           survivors      uint[3 * triangle_capacity]  output triangles, in the order of the input
//           counts         uint[2]                      [1]: output triangles
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl
// Plain     cluster/level_chain/reference.py

// Triangles of a chunk to its piece, whose length it returns. No branch: a quarter survives, which no one can predict,
// so that each is written, and the next one over those that do not
static inline uint geometry_piece(
    __global const uint *restrict triangles, __global const uint *restrict parents, __global uint *restrict piece, const uint2 rows)
{
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) {
        __global const uint *corners = triangles + 3 * (size_t)t;
        const uint a = parents[corners[0]], b = parents[corners[1]], c = parents[corners[2]];
        __global uint *out = piece + 3 * (size_t)count;
        out[0] = a;
        out[1] = b;
        out[2] = c;
        count += (a != b) & (b != c) & (c != a);
    }
    return count;
}

__kernel void level_chain_geometry_decimate(
    __global const uint *restrict triangles,
    __global const uint *restrict fine_counts,
    __global const uint *restrict parents,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    __global float *restrict maps,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(fine_counts[1], triangle_capacity));
    __global uint *piece = pieces + 3 * (size_t)rows.x;
    const uint count = geometry_piece(triangles, parents, piece, rows);
    for (size_t i = 0; i < 3 * (size_t)count; ++i) maps[LANES * (size_t)piece[i] + LANE_SURVIVING] = 1.0f;
    piece_counts[chunk] = count;
}

__kernel void level_chain_geometry_decimate_fixed_point(
    __global const uint *restrict triangles,
    __global const uint *restrict fine_counts,
    __global const uint *restrict parents,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    __global long *restrict sums,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(fine_counts[1], triangle_capacity));
    __global uint *piece = pieces + 3 * (size_t)rows.x;
    const uint count = geometry_piece(triangles, parents, piece, rows);
    for (size_t i = 0; i < 3 * (size_t)count; ++i) sums[WORDS * (size_t)piece[i] + WORD_SURVIVING] = 1;
    piece_counts[chunk] = count;
}

__kernel void level_chain_geometry_join(
    __global const uint *restrict fine_counts,
    __global const uint *restrict pieces,
    __global const uint *restrict piece_counts,
    __global const uint *restrict new_ranks,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint start = chunk_rows(chunk, chunk_count, min(fine_counts[1], triangle_capacity)).x;
    const uint place = chunk_sum_before(chunk, piece_counts), count = piece_counts[chunk];
    __global const uint *piece = pieces + 3 * (size_t)start;
    __global uint *out = survivors + 3 * (size_t)place;
    for (size_t i = 0; i < 3 * (size_t)count; ++i) out[i] = new_ranks[piece[i]];
    if (chunk == chunk_count - 1) counts[1] = place + count;
}
