// Level chain, geometry stage: of the triangles that the level before streamed out, those with corners in three cells.
//
// Source    DeCoro & Tatarchuk 2007, slides 16-17 (final clustering), from the mesh streamed out before; its vertices
//           carry their cells, for a representative may lie outside of its own
// Work      1-D, one item per chunk of the level before's triangles
// Reads     triangles      uint[3 * triangle_capacity]  of the level before
//           fine_counts    uint[2]                      [1]: how many
//           parents        uint[fine_capacity]          the cell, by rank, of each vertex of the level before
//           new_ranks      uint[capacity]               output vertex of a cell
// Writes    maps           float[16 * capacity]         the surviving corners: 1 where there are any; several items may
//                                                       write the same 1
//           sums           long[14 * capacity]          the same in fixed point
//           triangle_sums  uint[chunk_count]            surviving triangles of each chunk
//           survivors      uint[3 * triangle_capacity]  output triangles, in the order of the input
//           counts         uint[2]                      [1]: output triangles
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl
// Plain     cluster/level_chain/reference.py

static inline uint3 geometry_cells(
    __global const uint *restrict triangles, __global const uint *restrict parents, const uint t)
{
    const uint3 v = vload3(t, triangles);
    return (uint3)(parents[v.x], parents[v.y], parents[v.z]);
}

static inline bool geometry_survives(const uint3 c) { return c.x != c.y && c.y != c.z && c.z != c.x; }

// MARK is said for each corner, a `cell`, of the triangles that survive
#define COUNT(MARK)                                                                                                    \
    const uint2 rows = chunk_rows(chunk, chunk_count, min(fine_counts[1], triangle_capacity));                         \
    uint count = 0;                                                                                                    \
    for (uint t = rows.x; t < rows.y; ++t) {                                                                           \
        const uint3 c = geometry_cells(triangles, parents, t);                                                         \
        if (!geometry_survives(c)) continue;                                                                           \
        MARK(c.x);                                                                                                     \
        MARK(c.y);                                                                                                     \
        MARK(c.z);                                                                                                     \
        ++count;                                                                                                       \
    }                                                                                                                  \
    triangle_sums[chunk] = count;

__kernel void level_chain_geometry_count(
    __global const uint *restrict triangles,
    __global const uint *restrict fine_counts,
    __global const uint *restrict parents,
    __global float *restrict maps,
    __global uint *restrict triangle_sums,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

#define MARK(cell) maps[LANES * (size_t)(cell) + LANE_SURVIVING] = 1.0f
    COUNT(MARK)
#undef MARK
}

__kernel void level_chain_geometry_count_fixed_point(
    __global const uint *restrict triangles,
    __global const uint *restrict fine_counts,
    __global const uint *restrict parents,
    __global long *restrict sums,
    __global uint *restrict triangle_sums,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

#define MARK(cell) sums[WORDS * (size_t)(cell) + WORD_SURVIVING] = 1l
    COUNT(MARK)
#undef MARK
}

__kernel void level_chain_geometry_write(
    __global const uint *restrict triangles,
    __global const uint *restrict fine_counts,
    __global const uint *restrict parents,
    __global const uint *restrict new_ranks,
    __global const uint *restrict triangle_sums,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint triangle_capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(fine_counts[1], triangle_capacity));
    uint place = chunk_sum_before(chunk, triangle_sums);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 c = geometry_cells(triangles, parents, t);
        if (geometry_survives(c)) vstore3((uint3)(new_ranks[c.x], new_ranks[c.y], new_ranks[c.z]), place++, survivors);
    }
    if (chunk == chunk_count - 1) counts[1] = place;
}
