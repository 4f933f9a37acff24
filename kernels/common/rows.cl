// Rows of different lengths, one after the other: in which does a place lie?
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

// the last row that begins at `place` or before; offsets ascend from 0, count is at least 1
static inline uint row_of(__global const uint *restrict offsets, const uint count, const uint place)
{
    uint low = 0, high = count;
    while (high - low > 1) {
        const uint middle = low + (high - low) / 2;
        if (offsets[middle] <= place) low = middle;
        else high = middle;
    }
    return low;
}
