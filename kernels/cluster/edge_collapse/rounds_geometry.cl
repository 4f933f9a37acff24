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
// Writes    costs       float[corners + 8]        of the edge to the next vertex; STALE where it is none to collapse
//           rim_costs   float[vertices]           of that from the rim
//           histograms  uint[BINS * chunk_count]  edges of each chunk by cost, by either end
//           totals      uint[BINS]                of all chunks; zeros but between costs and plan
//           cuts        uint[BINS * PASSES]       zeros
//           best        uint2[vertices]           the least edge at a vertex: cost's bits, other end; NONE
//           state       uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl cluster/edge_collapse/plan.cl
// Defines   MANY        edges that are asked in one go, a multiple of eight: a CPU's pipeline wants several eights
// Plain     cluster/edge_collapse/rounds_reference.py

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
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    __global uint *histogram = histograms + (size_t)chunk * BINS;
    for (uint i = 0; i < BINS; ++i) histogram[i] = 0;
    const float enough = fmax(LAZY * as_float(state[THRESHOLD]), -STALE);
    const bool again = state[SWEEPS] && state[STUBBORN] == state[SWEEPS]; // those that might not go may now
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
            const bool asks = (kept < 0.0f && -kept <= enough) || (again && kept == INFINITY);
            if (!asks && fabs(kept) < INFINITY) ++histogram[cost_bin(fabs(kept))];
            asked.u[asked.count] = min(v, w);
            asked.v[asked.count] = max(v, w);
            asked.at[asked.count] = inside ? e : v | OF_RIM;
            asked.count += asks & !(kinds[w] & FIXED) & (w != v);
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
    const float least, // share of the edges that may go in a round
    const uint patient) // triangles turn no further in the end
{
    if (get_global_id(0) > 0 || ring_done(state)) return;

    uint edges = 0;
    for (uint i = 0; i < BINS; ++i) edges += totals[i];
    float share = least;
    if (state[SWEEPS] && !state[TRIED]) { // all that costs less than the threshold may not go: where that is all, none ever
        share = edges ? 2.0f * as_float(state[SHARE]) : 4.0f;
        if (share >= 4.0f && !patient && !state[STUBBORN]) {
            state[STUBBORN] = state[SWEEPS] + 1;
            share = 1.0f;
        }
        state[DONE] = share >= 4.0f; // from 2 on the costs, too, were found with the threshold open
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

// the least of the costs as bits, eight at once; there is room to read eight past the last
INLINE uint geometry_least(__global const float *restrict costs, const uint begin, const uint past)
{
    const uint8 lane = (uint8)(0, 1, 2, 3, 4, 5, 6, 7);
    uint8 least = NONE;
    for (uint e = begin; e < past; e += 8)
        least = min(least, lane < (uint8)(past - e) ? as_uint8(vload8(0, costs + e)) : (uint8)(NONE));
    const uint4 four = min(least.lo, least.hi);
    const uint2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
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
    const uint pass,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    const uint threshold = min(state[THRESHOLD], as_uint(INFINITY) - 1) + 1;
    for (uint v = rows.x; v < rows.y; ++v) {
        const uint own = touched[v];
        if (pass) { // most are as they were
            const uint before = best[v].y;
            if (before == NONE || !(own | (touched[before] & CHANGED))) continue;
        }
        uint2 least = (uint2)(threshold, NONE);
        const uint begin = starts[v], past = starts[v + 1], rim = rims[v];
        if (!pass) least.x = min(threshold, min(geometry_least(costs, begin, past), as_uint(rim_costs[v])));
        if (own & CHANGED || (!pass && least.x == threshold)) {
            best[v] = (uint2)(NONE);
            continue;
        }
        for (uint e = begin; e < past + (rim != NONE); ++e) {
            const uint cost = as_uint(e < past ? costs[e] : rim_costs[v]);
            if (cost > least.x || cost == threshold) continue;
            const uint w = e < past ? ring[e].x : rim;
            if (touched[w] & CHANGED || (cost == least.x && least.y != NONE && !ring_before(v, w, v, least.y))) continue;
            least = (uint2)(cost, w);
        }
        best[v] = least;
    }
}
