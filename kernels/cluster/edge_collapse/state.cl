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
