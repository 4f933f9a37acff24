// Edge collapse in rounds, geometry stage: edges that are the least in the rings of both ends win, if they may go.
//
// Source    none, ours
// Work      1-D, one item per chunk of vertices. No two winners have a triangle that touches both, so that each is alone
//           in what it reads of rings and changes there
// Reads     places        float4[vertices]
//           starts        uint[vertices + 1]
//           ring          uint2[corners]
//           planes        float8[vertices]
//           kinds         uchar[vertices]
//           rims          uint[vertices]
//           best          uint2[vertices]
//           ids           uint[vertices]            the vertex of the mesh
//           limits        float[vertex_count]       where limited: of the root of what a collapse costs there in the mean
// Writes    costs         float[corners]            INFINITY where the edge may not go, until its rings change
//           rim_costs     float[vertices]
//           touched       uchar[vertices]           REFUSED
//           winners       uint4[vertices]           of each chunk at the front of its room: both ends, triangles, cost
//           spots         float4[vertices]          where the vertex then lies
//           winner_count  uint[chunk_count]
//           cuts          uint[BINS * PASSES]       triangles that would go, by cost
//           state         uint[16]
// Needs     cluster/edge_collapse/rounds_link.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// is the edge at a vertex not less than the one from u to v?
INLINE bool select_not_less(__global const uint2 *restrict best, const uint w, const uint cost, const uint u, const uint v)
{
    const uint2 other = best[w];
    return other.x > cost || other.y == NONE || (other.x == cost && !ring_before(w, other.y, u, v));
}

// nor those at its neighbours? Inside the surface each of these is once the next one
INLINE bool select_least(__global const uint2 *restrict ring, __global const uint2 *restrict best, const uint2 range,
    const bool rim, const uint cost, const uint u, const uint v)
{
    for (uint e = range.x; e < range.y; ++e)
        if (!select_not_less(best, ring[e].x, cost, u, v)) return false;
    for (uint e = range.x; rim && e < range.y; ++e)
        if (!select_not_less(best, ring[e].y, cost, u, v)) return false;
    return true;
}

INLINE void select_ban(__global const uint2 *restrict ring, const uint2 range, __global const uint *restrict rims,
    const uint u, const uint v, __global float *restrict costs, __global float *restrict rim_costs)
{
    for (uint e = range.x; e < range.y; ++e)
        if (ring[e].x == v) costs[e] = INFINITY;
    if (rims[u] == v) rim_costs[u] = INFINITY;
}

// the sum of two vertices' quadrics where they meet
INLINE void select_merge(__global const float4 *restrict places, __global const float8 *restrict planes, const uint u,
    const uint v, Quadrics *merged)
{
    const uint one[8] = {u, u, u, u, u, u, u, u}, two[8] = {v, v, v, v, v, v, v, v};
    Quadrics a, b;
    ring_quadrics(planes, places, one, &a);
    ring_quadrics(planes, places, two, &b);
    quadric_merge(&a, &b, merged);
}

// does the collapse cost more in the mean than the square of the limit?
INLINE bool select_strays(const Quadrics *merged, const float limit)
{
    return merged->c.s0 > limit * limit * (merged->xx.s0 + merged->yy.s0 + merged->zz.s0);
}

__kernel void edge_collapse_rounds_select_edges(
    __global const float4 *restrict places,
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const float8 *restrict planes,
    __global const uchar *restrict kinds,
    __global const uint *restrict rims,
    __global const uint2 *restrict best,
    __global const uint *restrict ids,
    __global const float *restrict limits,
    __global float *restrict costs,
    __global float *restrict rim_costs,
    __global uchar *restrict touched,
    __global uint4 *restrict winners,
    __global float4 *restrict spots,
    __global uint *restrict winner_count,
    __global uint *restrict cuts,
    __global uint *restrict state,
    const float turn_limit, // square of the cosine
    const uint limited,
    const uint target,
    const uint pass,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    const uint most = ring_most(state, target, pass);
    const bool stubborn = state[STUBBORN];
    const float limit = stubborn ? 0.0f : turn_limit;
    uint at = rows.x, tried = 0;
    for (uint u = rows.x; u < rows.y; ++u) {
        const uint cost = best[u].x, v = best[u].y;
        if (v == NONE || u > v || best[v].y != u) continue;
        const uint2 one = link_range(starts, u), two = link_range(starts, v);
        const bool rim_u = kinds[u] & RIM, rim_v = kinds[v] & RIM;
        if (!select_least(ring, best, one, rim_u, cost, u, v) || !select_least(ring, best, two, rim_v, cost, u, v))
            continue;
        ++tried;
        const uint gone = link_gone(starts, ring, u, v, rim_u, rim_v);
        float3 place = 0.0f;
        bool strays = false;
        if (gone) {
            Quadrics merged;
            select_merge(places, planes, u, v, &merged);
            link_level(places, starts, ring, u, v, &merged);
            place = (float3)(merged.px.s0, merged.py.s0, merged.pz.s0);
            strays = limited && select_strays(&merged, fmin(limits[ids[u]], limits[ids[v]]));
        }
        bool refused = !gone || gone > most || strays, turns = true;
        for (uint k = 0; !refused && turns && k < (stubborn ? 3 : 1); ++k) { // in the end at either end, too
            if (k) place = places[k == 1 ? u : v].xyz;
            turns = link_turns(places, ring, one, places[u].xyz, v, place, limit)
                || link_turns(places, ring, two, places[v].xyz, u, place, limit);
        }
        if (refused || turns) {
            touched[u] = touched[v] = REFUSED;
            select_ban(ring, one, rims, u, v, costs, rim_costs);
            select_ban(ring, two, rims, v, u, costs, rim_costs);
            continue;
        }
        winners[at] = (uint4)(u, v, gone, cost);
        spots[at++] = (float4)(place, places[v].w);
        atomic_add(cuts + pass * BINS + cost_bin(as_float(cost)), gone);
    }
    winner_count[chunk] = at - rows.x;
    if (tried) atomic_or(state + TRIED, 1u);
}
