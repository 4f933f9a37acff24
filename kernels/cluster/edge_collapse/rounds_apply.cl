// Edge collapse in rounds, geometry stage: winners go, each where it is alone; in the last round the cheapest of them.
//
// Source    none, ours
// Work      1-D, one item per chunk of vertices
// Reads     starts        uint[vertices + 1]
//           ring          uint2[corners]
//           ids           uint[vertices]            the vertex of the mesh
//           winners       uint4[vertices]           of each chunk at the front of its room: both ends, triangles, cost
//           spots         float4[vertices]          where the vertex then lies
//           winner_count  uint[chunk_count]
//           cuts          uint[BINS * PASSES]       triangles that would go, by cost
// Writes    places        float4[vertices]
//           degrees       uint[vertices]
//           absorbed      uint[vertices]
//           touched       uchar[vertices]           CHANGED
//           points        float4[vertex_count]      as the blocks leave them
//           parents       uint[vertex_count]
//           sequence      uint4[vertex_count]       round, pass, cost, vertex
//           moves         float4[vertex_count]
//           limits        float[vertex_count]       where limited: the least of all that went to a vertex
//           held          float8[vertex_count]      where attributes count: the sum of these
//           state         uint[16]
// Needs     cluster/edge_collapse/rounds_link.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// how many of the winners go: in the last round the cheapest alone. The bin from which on they stay, and the triangles of
// that bin which go
INLINE uint2 apply_cut(__global const uint *restrict cuts, const uint most)
{
    uint bin = 0, sum = 0;
    for (; bin < BINS && sum + cuts[bin] <= most; ++bin) sum += cuts[bin];
    return (uint2)(bin, most - sum);
}

INLINE void apply_touch(__global const uint2 *restrict ring, const uint2 range, const uint other,
    __global uchar *restrict touched, __global uint *restrict degrees, const bool first)
{
    for (uint e = range.x; e < range.y; ++e) {
        const uint2 w = ring[e];
        touched[w.x] = touched[w.y] = CHANGED; // by others too, all of them alike
        if (first && (w.x == other || w.y == other)) atomic_dec(degrees + (w.x == other ? w.y : w.x));
    }
}

__kernel void edge_collapse_rounds_apply_winners(
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const uint *restrict ids,
    __global const uint4 *restrict winners,
    __global const float4 *restrict spots,
    __global const uint *restrict winner_count,
    __global const uint *restrict cuts,
    __global float4 *restrict places,
    __global uint *restrict degrees,
    __global uint *restrict absorbed,
    __global uchar *restrict touched,
    __global float4 *restrict points,
    __global uint *restrict parents,
    __global uint4 *restrict sequence,
    __global float4 *restrict moves,
    __global float *restrict limits,
    __global float8 *restrict held,
    __global uint *restrict state,
    const uint limited,
    const uint holding,
    const uint target,
    const uint recorded,
    const uint pass,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint count = state[VERTICES + generation];
    const uint2 cuts_at = apply_cut(cuts + pass * BINS, ring_most(state, target, pass));
    const uint cut = cuts_at.x, left = cuts_at.y;
    uint before = 0, gone = 0, collapses = 0; // triangles at the cut's bin, in the order of vertices
    for (uint c = 0; cut < BINS && c < chunk; ++c) {
        const uint first = chunk_rows(c, chunk_count, count).x;
        for (uint i = first; i < first + winner_count[c]; ++i)
            before += cost_bin(as_float(winners[i].w)) == cut ? winners[i].z : 0;
    }
    const uint first = chunk_rows(chunk, chunk_count, count).x;
    for (uint i = first; i < first + winner_count[chunk]; ++i) {
        const uint4 edge = winners[i];
        const uint u = edge.x, v = edge.y, bin = cost_bin(as_float(edge.w));
        before += bin == cut ? edge.z : 0;
        if (bin > cut || (bin == cut && before > left)) continue;
        const uint2 one = link_range(starts, u), two = link_range(starts, v);
        const float4 spot = spots[i];
        apply_touch(ring, one, v, touched, degrees, true);
        apply_touch(ring, two, u, touched, degrees, false);
        places[v] = spot;
        degrees[v] = one.y - one.x + two.y - two.x - 2 * edge.z;
        degrees[u] = 0;
        absorbed[v] = u;
        const uint from = ids[u], to = ids[v];
        points[to].xyz = spot.xyz;
        points[from].w = 0.0f;
        parents[from] = to;
        if (limited) limits[to] = fmin(limits[to], limits[from]);
        if (holding) held[to] += held[from];
        if (recorded) {
            sequence[from] = (uint4)(state[SWEEPS], pass, edge.w, from);
            moves[from] = (float4)(spot.xyz, edge.z);
        }
        gone += edge.z;
        ++collapses;
    }
    atomic_add(state + GONE + pass, gone);
    atomic_add(state + COLLAPSES, collapses);
}
