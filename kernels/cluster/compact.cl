// Vertex clustering, fragment stage: the representatives of the used cells, moved together, in model units.
//
// Source    DeCoro & Tatarchuk 2007, slide 15; cells that no surviving triangle uses give no vertex
// Work      1-D, one item per chunk of occupied cells
// Reads     solved      float4[capacity]     x y z in units of the largest cell edge, kind; kind 0: not used by any triangle
//           state       uint[4]              [0]: occupied cells
//           chunk_sums  uint[chunk_count]    used cells
// Writes    new_ranks   uint[capacity]       the cell's output vertex, 0xFFFFFFFF where not used
//           vertices    float[3 * capacity]  model units
//           counts      uint[2]              [0]: output vertices
// Needs     common/chunk.cl

__kernel void cluster_compact(
    __global const float4 *restrict solved,
    __global const uint *restrict state,
    __global const uint *restrict chunk_sums,
    __global uint *restrict new_ranks,
    __global float *restrict vertices,
    __global uint *restrict counts,
    const float4 low,
    const float2 to_model, // x: low.w model units per unit, y: 1 / low.w
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint rank = chunk_sum_before(chunk, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, min(state[0], capacity));
    for (uint s = rows.x; s < rows.y; ++s) {
        const float4 p = solved[s];
        if (p.w > 0.0f) {
            // a box as wide as float32 itself: a step past it stays finite
            vstore3(clamp((p.xyz * to_model.x + low.xyz) * to_model.y, -3.4e38f, 3.4e38f), rank, vertices);
            new_ranks[s] = rank++;
        } else {
            new_ranks[s] = 0xFFFFFFFFu;
        }
    }
    if (chunk == chunk_count - 1) counts[0] = rank;
}
