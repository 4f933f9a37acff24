// Edge collapse in rounds, between rounds: vertices that are left, numbered in their order, with their rings.
//
// Source    none; a scan over vertices, two counts at once
// Work      1-D, one item per chunk of vertices
// Reads     degrees       uint[vertices]       triangles now
//           absorbed      uint[vertices]
//           touched       uchar[vertices]
//           rims          uint[vertices]
//           rim_costs     float[vertices]
//           places, ids, starts, ring, costs   of the generation before
// Writes    chunk_sums    uint2[chunk_count]   vertices and corners of each chunk
//           numbers       uint[vertices]       in the next generation; where a vertex went, that one's
//           new_places, new_ids, new_starts, new_ring, new_costs, new_rim_costs
//           cursors       uint[vertices]       where the rings begin
//           state         uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl
// Plain     cluster/edge_collapse/rounds_reference.py

__kernel void edge_collapse_rounds_compact_sum(
    __global const uint *restrict degrees,
    __global uint2 *restrict chunk_sums,
    __global uint *restrict state,
    const uint target,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;
    if (chunk == 0 && !ring_most(state, target, PASSES)) state[MET] = 1; // read by no other here

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    uint2 sum = (uint2)(0, 0);
    for (uint v = range.x; v < range.y; ++v) sum += (uint2)(degrees[v] > 0, degrees[v]);
    chunk_sums[chunk] = sum;
}

__kernel void edge_collapse_rounds_compact_number(
    __global const float4 *restrict places,
    __global const uint *restrict ids,
    __global const uint *restrict degrees,
    __global const uint *restrict absorbed,
    __global const uchar *restrict touched,
    __global const uint *restrict rims,
    __global const float *restrict rim_costs,
    __global const uint2 *restrict chunk_sums,
    __global uint *restrict numbers,
    __global float4 *restrict new_places,
    __global uint *restrict new_ids,
    __global uint *restrict new_starts,
    __global float *restrict new_rim_costs,
    __global uint *restrict cursors,
    __global uint *restrict state,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    uint2 at = (uint2)(0, 0);
    for (uint c = 0; c < chunk; ++c) at += chunk_sums[c];
    for (uint v = range.x; v < range.y; ++v) {
        const uint degree = degrees[v], gone = absorbed[v], rim = rims[v];
        if (degree == 0) continue;
        numbers[v] = at.x;
        if (gone != NONE) numbers[gone] = at.x;
        new_places[at.x] = places[v];
        new_ids[at.x] = ids[v];
        new_starts[at.x] = at.y;
        cursors[at.x] = at.y;
        float cost = STALE;
        if (rim != NONE) {
            const bool joined = gone != NONE || absorbed[rim] != NONE || degrees[rim] == 0;
            cost = ring_cost(rim_costs[v], (touched[v] | touched[rim]) & CHANGED, joined);
        }
        new_rim_costs[at.x] = cost;
        at += (uint2)(1, degree);
    }
    if (chunk < chunk_count - 1) return;
    new_starts[at.x] = at.y;
    state[VERTICES + 1 - generation] = at.x;
    state[LIVE] = at.y / 3;
}

// rings after a round; an edge both of whose ends' rings are as they were keeps its cost
__kernel void edge_collapse_rounds_compact_rings(
    __global const uint *restrict degrees,
    __global const uint *restrict absorbed,
    __global const uchar *restrict touched,
    __global const uint *restrict numbers,
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const float *restrict costs,
    __global const uint *restrict new_starts,
    __global uint2 *restrict new_ring,
    __global float *restrict new_costs,
    __global const uint *restrict state,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    for (uint v = range.x; v < range.y; ++v) {
        if (degrees[v] == 0) continue;
        const uint own = numbers[v], past = new_starts[own + 1];
        uint at = new_starts[own];
        for (uint w = v; w != NONE; w = w == v ? absorbed[v] : NONE)
            for (uint e = starts[w]; e < starts[w + 1]; ++e) {
                const uint2 old = ring[e], pair = (uint2)(numbers[old.x], numbers[old.y]);
                if (pair.x == pair.y || pair.x == own || pair.y == own || at >= past) continue;
                const bool joined = absorbed[v] != NONE || absorbed[old.x] != NONE || degrees[old.x] == 0;
                new_costs[at] = ring_cost(costs[e], (touched[v] | touched[old.x]) & CHANGED, joined);
                new_ring[at++] = pair;
            }
        for (; at < past; ++at) { // none is missing in a manifold
            new_ring[at] = (uint2)(own);
            new_costs[at] = STALE;
        }
    }
}
