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
//           histograms  uint[BINS * chunk_count]  edges of each chunk by cost, by either end
//           totals      uint[BINS]                of all chunks; zeros but between costs and plan
//           cuts        uint[BINS * PASSES]       zeros
//           best        uint2[vertices]           the least edge at a vertex: cost's bits, other end; NONE
//           state       uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl cluster/edge_collapse/plan.cl
// Plain     cluster/edge_collapse/rounds_reference.py

#define MANY 64  // edges, so that eight and eight follow each other without a branch

// edges to be asked, `count` of so many: the lesser end first, so that both ends are told the same bits; where the costs go
typedef struct {
    uint u[MANY], v[MANY], at[MANY];
    uint count;
} Asked;

#define OF_RIM 0x80000000u  // `at` is a vertex, whose edge from its rim it is

INLINE void geometry_ask(Asked *asked, __global const float4 *restrict places, __global const float8 *restrict planes,
    __global float *restrict costs, __global float *restrict rim_costs, __global uint *restrict histogram)
{
    const uint count = asked->count, whole = (count + 7) / 8;
    for (uint i = count; i < 8 * whole; ++i) asked->u[i] = asked->u[0], asked->v[i] = asked->v[0];
    float found[MANY];
    for (uint i = 0; i < whole; ++i) {
        Quadrics u, v, sum;
        ring_quadrics(planes, places, asked->u + 8 * i, &u);
        ring_quadrics(planes, places, asked->v + 8 * i, &v);
        vstore8(quadric_merge(&u, &v, &sum), i, found);
    }
    for (uint i = 0; i < count; ++i) {
        const uint at = asked->at[i];
        if (at & OF_RIM)
            rim_costs[at & ~OF_RIM] = found[i];
        else
            costs[at] = found[i];
        ++histogram[cost_bin(found[i])];
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
    // each edge by both ends; one whose cost was kept, since nothing near it changed, is counted alone
    for (uint v = rows.x; v < rows.y; ++v) {
        if (kinds[v] & FIXED) continue;
        const uint past = starts[v + 1], rim = rims[v];
        for (uint e = starts[v]; e < past + (rim != NONE); ++e) {
            const bool inside = e < past;
            const uint w = inside ? ring[e].x : rim;
            const float kept = inside ? costs[e] : rim_costs[v];
            if (kept >= 0.0f && kept < INFINITY) ++histogram[cost_bin(kept)];
            asked.u[asked.count] = min(v, w);
            asked.v[asked.count] = max(v, w);
            asked.at[asked.count] = inside ? e : v | OF_RIM;
            asked.count += !(kept >= 0.0f) & !(kinds[w] & FIXED) & (w != v);
            if (asked.count == MANY) geometry_ask(&asked, places, planes, costs, rim_costs, histogram);
        }
    }
    if (asked.count) geometry_ask(&asked, places, planes, costs, rim_costs, histogram);
    for (uint i = 0; i < BINS; ++i)
        if (histogram[i]) atomic_add(totals + i, histogram[i]);
}

__kernel void edge_collapse_rounds_geometry_plan(
    __global uint *restrict totals,
    __global uint *restrict cuts,
    __global uint *restrict state,
    const float least) // share of the edges that may go in a round
{
    if (get_global_id(0) > 0 || state[DONE]) return;

    uint edges = 0;
    for (uint i = 0; i < BINS; ++i) edges += totals[i];
    float share = least;
    if (state[SWEEPS] && !state[TRIED]) { // all that costs less than the threshold may not go: where that is all, none ever
        state[DONE] = !edges || as_float(state[THRESHOLD]) == INFINITY;
        share = 2.0f * as_float(state[SHARE]);
    }
    float cost = INFINITY;
    if (share < 1.0f) plan_bin(totals, share * edges, &cost);
    for (uint i = 0; i < BINS; ++i) totals[i] = 0;
    for (uint i = 0; i < PASSES * BINS; ++i) cuts[i] = 0;
    for (uint i = 0; i < PASSES; ++i) state[GONE + i] = 0;
    state[THRESHOLD] = as_uint(cost);
    state[SHARE] = as_uint(share);
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
