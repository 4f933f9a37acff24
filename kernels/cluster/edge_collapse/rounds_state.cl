// Edge collapse in rounds: what its stages share; words of `state` beside those of state.cl, rings, the order of edges.
//
// Source    none
// Work      functions only; a ring holds, for each triangle at a vertex, the next and the previous corner's vertex
// Reads     nothing
// Writes    nothing
// Needs     common/chunk.cl common/transpose.cl cluster/edge_collapse/state.cl cluster/edge_collapse/fragment.cl

#define VERTICES 1  // and the word after it: of the two generations
#define STUBBORN 7  // the round after which triangles may turn by up to 90 degrees, since a target is missed; 0: none
#define MET 8       // the target is met
#define TRIED 9     // edges that won in this round, whether they went or not
#define SHARE 12    // a float's bits: of the edges that may go in this round
#define GONE 13     // and two words after it: triangles that went in each pass of this round

#define PASSES 3
#define NONE 0xFFFFFFFFu
#define STALE (-1e-37f) // a cost to be found anew, as all negative ones: as bits they are above every cost
#define LAZY 2.0f     // what cost more than so many times the threshold need not be found anew yet
#define RIM 1u       // kinds of vertices: on the border
#define FIXED 2u     // it stays where it is
#define CHANGED 1u   // what touched a vertex: its ring is another
#define REFUSED 2u   // its least edge may not go

INLINE bool ring_done(__global const uint *restrict state) { return state[DONE] || state[MET]; }

// columns of eight records of four numbers, `stride` such records apart
INLINE fours8 ring_columns(__global const float4 *restrict records, const uint stride, const uint *v)
{
    return transpose_fours((float8)(records[stride * v[0]], records[stride * v[4]]),
        (float8)(records[stride * v[1]], records[stride * v[5]]), (float8)(records[stride * v[2]], records[stride * v[6]]),
        (float8)(records[stride * v[3]], records[stride * v[7]]));
}

// quadrics of eight vertices: planes through them
INLINE void ring_quadrics(__global const float8 *restrict planes, __global const float4 *restrict places, const uint *v,
    Quadrics *q)
{
    __global const float4 *halves = (__global const float4 *)planes;
    const fours8 first = ring_columns(halves, 2, v), second = ring_columns(halves + 1, 2, v);
    const fours8 place = ring_columns(places, 1, v);
    q->xx = first.x, q->xy = first.y, q->xz = first.z, q->yy = first.w, q->yz = second.x, q->zz = second.y;
    q->px = place.x, q->py = place.y, q->pz = place.z;
    q->bx = q->by = q->bz = q->c = 0.0f;
}

// among edges of one cost: does the edge between a and b come before that between c and d? By a hash, so that flat parts
// do not wait for each other
INLINE bool ring_before(const uint a, const uint b, const uint c, const uint d)
{
    const uint low = min(a, b), high = max(a, b), other_low = min(c, d), other_high = max(c, d);
    const uint hash = (low * 2654435761u ^ high) * 2246822519u, other = (other_low * 2654435761u ^ other_high) * 2246822519u;
    if (hash != other) return hash < other;
    return low != other_low ? low < other_low : high < other_high;
}

// an edge's cost after a round: kept where no ring changed, else kept as the one before, negative; to be found anew where
// an end is `joined` from two, or where the edge was not allowed
INLINE float ring_cost(const float cost, const bool changed, const bool joined)
{
    const float before = fabs(cost);
    return !changed ? cost : joined || !(before < INFINITY) ? STALE : -before;
}

// triangles that may go before a pass of this round, an even number
INLINE uint ring_most(__global const uint *restrict state, const uint target, const uint pass)
{
    uint live = state[LIVE];
    for (uint i = 0; i < pass; ++i) live -= state[GONE + i];
    return live > target ? live - target + 1 & ~1u : 0;
}
