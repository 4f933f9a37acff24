// Level chain: all stages of a level in one launch, for levels so small that a launch costs more than its walk.
//
// Source    none: the same kernels, one after the other
// Work      1-D, one item
// Reads     fine_words     ulong2[fine_word_count]     of the level before, as in fragment.cl
//           fine_maps      float[16 * fine_capacity * fine_map_count]
//           fine_ranks     uint[fine_capacity]         output vertex of its cells
//           triangles      uint[3 * triangle_capacity] its output
//           fine_counts    uint[2]                     [1]: how many
// Writes    words          ulong2[word_count]
//           maps           float[16 * capacity]
//           parents        uint[fine_capacity]
//           state          uint[4]                     [0]: occupied cells
//           solved         float4[capacity]            as in quadric_clustering/fragment.cl
//           new_ranks      uint[capacity]
//           vertices       float[3 * capacity]         model units
//           survivors      uint[3 * triangle_capacity]
//           counts         uint[2]                     output vertices, output triangles
//           chunk_sums     uint[1]
//           pieces         uint[3 * triangle_capacity]
//           piece_counts   uint[1]
// Needs     cluster/compact.cl cluster/quadric_clustering/fragment.cl cluster/level_chain/fragment.cl cluster/level_chain/geometry.cl
// Plain     cluster/level_chain/reference.py

__kernel void level_chain_serial(
    __global const ulong2 *fine_words,
    __global const float *fine_maps,
    __global const uint *fine_ranks,
    __global const uint *triangles,
    __global const uint *fine_counts,
    __global ulong2 *words,
    __global float *maps,
    __global uint *parents,
    __global uint *state,
    __global float4 *solved,
    __global uint *new_ranks,
    __global float *vertices,
    __global uint *survivors,
    __global uint *counts,
    __global uint *chunk_sums,
    __global uint *pieces,
    __global uint *piece_counts,
    const uint4 fine_cells,
    const uint4 cells,
    const float4 low,
    const float2 to_model,
    const float per_box,
    const uint placement,
    const uint fine_map_count,
    const uint fine_word_count,
    const uint word_count,
    const uint fine_capacity,
    const uint capacity,
    const uint triangle_capacity)
{
    if (get_global_id(0) > 0) return;

    level_chain_fragment_bits(fine_words, words, chunk_sums, fine_cells, cells, fine_word_count, word_count, 1);
    level_chain_fragment_downsample(fine_words, (__global const float16 *)fine_maps, fine_ranks, chunk_sums, words,
        (__global float16 *)maps, parents, state, fine_cells, cells, fine_map_count, fine_capacity, capacity, word_count, 1);
    level_chain_geometry_decimate(
        triangles, fine_counts, parents, pieces, piece_counts, maps, triangle_capacity, 1);
    // the limits of a warped grid's cells are not read: a chain has none
    quadric_clustering_fragment_solve(
        (__global const float16 *)maps, state, maps, solved, chunk_sums, per_box, placement, 1, capacity, 1);
    cluster_compact(solved, state, chunk_sums, new_ranks, vertices, counts, low, to_model, capacity, 1);
    level_chain_geometry_join(
        fine_counts, pieces, piece_counts, new_ranks, survivors, counts, triangle_capacity, 1);
}
