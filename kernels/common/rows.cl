// Rows of different lengths, one after the other: in which does a place lie?
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

// the last row that begins at `place` or before; offsets ascend from 0, count is at least 1. No branch to mispredict
static inline uint row_of(__global const uint *restrict offsets, const uint count, const uint place)
{
    uint low = 0;
    for (uint left = count; left > 1; left -= left / 2) {
        const uint middle = low + left / 2;
        low = offsets[middle] <= place ? middle : low;
    }
    return low;
}
