// Vertex clustering: border vertices that stay as they are, each with a rank of its own past those of cells
//
// Source    none
// Work      1-D, one item per chunk of kept vertices
// Reads     kept        uint[kept_count]           vertices that stay as they are
//           positions   float[3 * vertex_count]    model units
//           new_ranks   uint[capacity]             output vertex of a rank
// Writes    points      float4[vertex_count]       w: a kept vertex gets the bits of its rank
//           state       uint[4]                    [0]: the kept ones counted too
//           cell_ids    uint[vertex_count]         of a kept vertex a number past those of cells
//           vertices    float[3 * capacity]        a kept vertex where it was, model units
// Needs     common/chunk.cl

#define NO_CELL 0x80000000u // cells are fewer

__kernel void cluster_borders_keep(
    __global const uint *restrict kept,
    __global float4 *restrict points,
    __global uint *restrict state,
    const uint occupied,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) points[kept[i]].w = as_float(occupied + i);
    if (chunk == 0) state[0] += kept_count;
}

__kernel void cluster_borders_keep_ids(
    __global const uint *restrict kept,
    __global uint *restrict cell_ids,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) cell_ids[kept[i]] = NO_CELL + i;
}

__kernel void cluster_borders_keep_return(
    __global const uint *restrict kept,
    __global const float *restrict positions,
    __global const uint *restrict new_ranks,
    __global float *restrict vertices,
    const uint occupied,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) {
        const uint v = new_ranks[occupied + i];
        if (v != 0xFFFFFFFFu) vstore3(vload3(kept[i], positions), v, vertices);
    }
}
