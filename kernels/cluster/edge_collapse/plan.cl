// Edge collapse, between geometry stages: what edges may cost in this sweep, and how much each block may take away.
//
// Source    none, ours: a quantile of all costs, and in the last sweeps quotas that end at the target
// Work      one item
// Reads     histograms  uint[BINS * blocks]   edges of the blocks that were asked, by cost
//           schedule    uint[16 * sweeps]
// Writes    quotas      uint[blocks]          triangles that a block may take away
//           totals      uint[BINS]
//           state       uint[16]
// Needs     cluster/edge_collapse/state.cl
// Plain     cluster/edge_collapse/reference.py

#define FEW 64 // edges of a bin that go together, be they alike or not

// the cost that so many edges stay below, evenly spread in their bin, where these are not few; its bin
static inline uint plan_bin(__global const uint *restrict totals, const float edges, float *cost)
{
    float below = 0.0f;
    uint bin = 0;
    for (; bin < BINS - 1 && below + totals[bin] < edges; ++bin) below += totals[bin];
    const float share = totals[bin] > FEW ? fmin((edges - below) / totals[bin], 1.0f) : 1.0f;
    *cost = bin_cost(bin) + share * (bin_cost(bin + 1) - bin_cost(bin));
    return bin;
}

__kernel void edge_collapse_plan_quotas(
    __global const uint *restrict histograms,
    __global const uint *restrict schedule,
    __global uint *restrict quotas,
    __global uint *restrict totals,
    __global uint *restrict state,
    const uint target)
{
    if (get_global_id(0) > 0 || state[DONE]) return;

    __global const uint *sweep = schedule + SWEEP_WORDS * (state[SWEEPS] - 1);
    const uint goal = sweep[GOAL];
    const float gain = as_float(sweep[GAIN]), least = as_float(sweep[LEAST_SHARE]);
    const uint blocks = state[BLOCKS], stride = state[STRIDE], live = state[LIVE];
    uint edges = 0;
    for (uint i = 0; i < BINS; ++i) totals[i] = 0;
    for (uint b = 0; b < blocks; b += stride)
        for (uint i = 0; i < BINS; ++i) totals[i] += histograms[(size_t)b * BINS + i];
    for (uint i = 0; i < BINS; ++i) edges += totals[i];
    const float share = live > goal ? (float)(live - goal) / live : 0.0f;
    float cost;
    const uint bin = plan_bin(totals, fmax(gain * share, least) * edges, &cost);
    const ulong pairs = live > target ? (live - target + 1) / 2 : 0;
    if (least == 0.0f) { // no block alone takes more than its part of all that is to go
        for (uint b = 0; b < blocks; ++b) quotas[b] = 2 * (pairs * (b + 1) / blocks - pairs * b / blocks);
    } else {
        ulong before = 0, all = 0, part = 0;
        for (uint b = 0; b < blocks; b += stride)
            for (uint i = 0; i <= bin; ++i) all += (ulong)histograms[(size_t)b * BINS + i] * min(stride, blocks - b);
        all = max(all, 1ul);
        for (uint b = 0; b < blocks; ++b) {
            ulong own = before;
            // a block has what the one before it has that was asked
            if (b % stride == 0) {
                part = 0;
                for (uint i = 0; i <= bin; ++i) part += histograms[(size_t)b * BINS + i];
            }
            own += part;
            quotas[b] = 2 * (pairs * own / all - pairs * before / all);
            before = own;
        }
    }
    if (blocks == 1 && live > target) quotas[0] = live - target; // the last collapse may take one more than is left
    state[THRESHOLD] = as_uint(cost);
}
