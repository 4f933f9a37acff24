// Edge collapse in rounds, geometry stage: what edges cost, what they may cost in this round, and the least of each vertex.
//
// Source    Garland & Heckbert 1997
// Work      costs, best: 1-D, one item per chunk of vertices; plan: one item
// Reads     places      float4[vertices]
//           starts      uint[vertices + 1]
//           ring        uint2[corners]
//           planes      float8[vertices]
//           kinds       uchar[vertices]
//           rims        uint[vertices]
//           touched     uchar[vertices]
// Writes    costs       float[corners]            of the edge to the next vertex; STALE where it is none to collapse
//           rim_costs   float[vertices]           of that from the rim
//           histograms  uint[BINS * chunk_count]  edges of each chunk by cost
//           totals      uint[BINS]                edges by cost; zeros but between costs and plan
//           best        uint2[vertices]           the least edge at a vertex: cost's bits, other end; NONE
//           state       uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl cluster/edge_collapse/plan.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// edges to be asked, `count` of eight, and where the first end keeps their costs; NONE: as its rim's
typedef struct {
    uint u[8], v[8], at[8];
    uint count;
} Asked;

// the costs to both ends of the edges, and counted
INLINE void geometry_ask(Asked *asked, __global const float4 *restrict places, __global const float8 *restrict planes,
    __global const uint *restrict starts, __global const uint2 *restrict ring, __global const uint *restrict rims,
    __global float *restrict costs, __global float *restrict rim_costs, __global uint *restrict histogram)
{
    const uint count = asked->count;
    for (uint i = count; i < 8; ++i) asked->u[i] = asked->u[0], asked->v[i] = asked->v[0];
    Quadrics u, v, sum;
    ring_quadrics(planes, places, asked->u, &u);
    ring_quadrics(planes, places, asked->v, &v);
    float found[8];
    vstore8(quadric_merge(&u, &v, &sum), 0, found);
    for (uint i = 0; i < count; ++i) {
        const uint own = asked->u[i], other = asked->v[i];
        const float cost = found[i];
        if (asked->at[i] == NONE)
            rim_costs[own] = cost;
        else
            costs[asked->at[i]] = cost;
        if (rims[other] == own) rim_costs[other] = cost;
        for (uint e = starts[other]; e < starts[other + 1]; ++e)
            if (ring[e].x == own) costs[e] = cost;
        ++histogram[cost_bin(cost)];
    }
    asked->count = 0;
}

__kernel void edge_collapse_rounds_geometry_costs(
    __global const float4 *restrict places,
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const float8 *restrict planes,
    __global const uchar *restrict kinds,
    __global const uint *restrict rims,
    __global const uint *restrict state,
    __global float *restrict costs,
    __global float *restrict rim_costs,
    __global uint *restrict histograms,
    __global uint *restrict totals,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    __global uint *histogram = histograms + (size_t)chunk * BINS;
    for (uint i = 0; i < BINS; ++i) histogram[i] = 0;
    Asked asked;
    asked.count = 0;
    // each edge once, by the lesser end; one whose cost was kept, since nothing near it changed, is counted alone
    for (uint v = rows.x; v < rows.y; ++v) {
        if (kinds[v] & FIXED) continue;
        const uint begin = starts[v], past = starts[v + 1], rim = rims[v];
        for (uint e = begin; e < past + (rim != NONE); ++e) {
            const uint w = e < past ? ring[e].x : rim;
            if (w < v || kinds[w] & FIXED) continue;
            const float kept = e < past ? costs[e] : rim_costs[v];
            if (kept >= 0.0f) {
                histogram[cost_bin(kept)] += kept < INFINITY;
                continue;
            }
            asked.u[asked.count] = v;
            asked.v[asked.count] = w;
            asked.at[asked.count++] = e < past ? e : NONE;
            if (asked.count == 8) geometry_ask(&asked, places, planes, starts, ring, rims, costs, rim_costs, histogram);
        }
    }
    if (asked.count) geometry_ask(&asked, places, planes, starts, ring, rims, costs, rim_costs, histogram);
    for (uint i = 0; i < BINS; ++i)
        if (histogram[i]) atomic_add(totals + i, histogram[i]);
}

__kernel void edge_collapse_rounds_geometry_plan(
    __global uint *restrict totals,
    __global uint *restrict state,
    const float share) // of the edges that may go
{
    if (get_global_id(0) > 0 || state[DONE]) return;

    uint edges = 0;
    for (uint i = 0; i < BINS; ++i) edges += totals[i];
    // where nothing was tried all edges below the threshold were banned; where that was all of them nothing ever will be
    if (state[SWEEPS] && !state[TRIED]) state[DONE] = state[THRESHOLD] == as_uint(INFINITY) || !edges;
    if (state[SWEEPS] && !state[TRIED]) ++state[IDLE];
    const float loosened = share * (float)(1u << min(state[IDLE], 30u));
    float cost = INFINITY;
    if (loosened < 1.0f) plan_bin(totals, loosened * edges, &cost);
    for (uint i = 0; i < BINS; ++i) totals[i] = 0;
    state[THRESHOLD] = as_uint(cost);
    state[TRIED] = 0;
    ++state[SWEEPS];
}

__kernel void edge_collapse_rounds_geometry_best(
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const uint *restrict rims,
    __global const uchar *restrict touched,
    __global const float *restrict costs,
    __global const float *restrict rim_costs,
    __global const uint *restrict state,
    __global uint2 *restrict best,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    const uint threshold = min(state[THRESHOLD], as_uint(INFINITY) - 1);
    for (uint v = rows.x; v < rows.y; ++v) {
        uint2 least = (uint2)(threshold, NONE);
        const uint begin = starts[v], past = starts[v + 1], rim = rims[v];
        for (uint e = begin; !touched[v] && e < past + (rim != NONE); ++e) {
            const uint cost = as_uint(e < past ? costs[e] : rim_costs[v]);
            if (cost > least.x) continue;
            const uint w = e < past ? ring[e].x : rim;
            if (touched[w] || (cost == least.x && least.y != NONE && !ring_before(v, w, v, least.y))) continue;
            least = (uint2)(cost, w);
        }
        best[v] = least;
    }
}
