// Edge collapse, vertex stage: what the blocks of a sweep took from the vertices that they share.
//
// Source    none
// Work      1-D, one item per chunk of vertices
// Reads     loss        uint[vertex_count]     modulo 2^32; 0 afterwards
//           block_live  uint[blocks]
// Writes    points      float4[vertex_count]   w: triangles at the vertex
//           state       uint[16]               the blocks are those before; are we done?
// Needs     common/chunk.cl cluster/edge_collapse/state.cl
// Plain     cluster/edge_collapse/reference.py

__kernel void edge_collapse_vertex_fold(
    __global const uint *restrict block_live,
    __global float4 *restrict points,
    __global uint *restrict loss,
    __global uint *restrict state,
    const uint target,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    if (chunk == 0 && state[SWEEPS] && !state[DONE]) {
        uint live = 0;
        for (uint b = 0; b < state[BLOCKS]; ++b) live += block_live[b];
        state[BLOCKS_BEFORE] = state[BLOCKS];
        state[EACH_BEFORE] = state[EACH];
        state[LIVE] = live;
        state[DONE] = live <= target;
    }
    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        if (v + 8 <= range.y) { // most have lost nothing
            const ulong4 eight = as_ulong4(vload8(0, loss + v));
            if (!(eight.x | eight.y | eight.z | eight.w)) {
                v += 7;
                continue;
            }
        }
        if (loss[v] == 0) continue;
        points[v].w -= (float)(int)loss[v];
        loss[v] = 0;
    }
}
