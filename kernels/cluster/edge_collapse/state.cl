// Edge collapse: what the sweeps of a frame keep on the device; words of `state`, a uint[16].
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

#define LIVE 0         // triangles
#define BLOCKS 1       // of this sweep
#define EACH 2         // rows of a block
#define BLOCKS_BEFORE 3
#define EACH_BEFORE 4
#define DONE 5         // the target is met
#define THRESHOLD 6    // a float's bits: edges that cost more stay
#define STRIDE 7       // every so many blocks are asked for costs
#define SAMPLED 8      // next block to be asked
#define TAKEN 9        // next block to be collapsed
#define SWEEPS 10      // done so far
#define COLLAPSES 11   // done so far

// words of a sweep in the schedule, a uint[SWEEP_WORDS * sweeps]
#define SWEEP_WORDS 16
#define BITS 0         // cells along an axis: 2^bits
#define ORDER 1        // where the curve through these cells begins
#define BLOCK_MOST 2   // triangles of a block
#define WHOLE_MOST 3   // triangles that are one block
#define ASKED 4        // blocks to be asked for costs, about
#define APART 5        // at most
#define GOAL 6         // triangles after it
#define GAIN 7         // a float: share of the edges for a share of the triangles
#define LEAST_SHARE 8  // a float: of the edges; above 0: quotas by cost
#define TURN_LIMIT 9   // a float: square of a cosine
#define CELLS 10       // a float: cells per unit
#define SHIFT 11       // three floats, cells

// costs are counted in bins, four to an octave, from 2^-95 on
#define BINS 512
#define FIRST_BIN (32u << 2)

static inline uint cost_bin(const float cost)
{
    const uint bin = as_uint(cost) >> 21;
    return bin < FIRST_BIN ? 0 : min(bin - FIRST_BIN, BINS - 1u);
}

// where the costs of a bin begin
static inline float bin_cost(const uint bin) { return bin ? as_float((bin + FIRST_BIN) << 21) : 0.0f; }
