// A long array cut into a few contiguous chunks, one work-item each.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

// first and past-the-last row of a chunk; whole cache lines of 16 words, so that no two chunks write to one
static inline uint2 chunk_rows(const uint chunk, const uint chunk_count, const uint row_count)
{
    const uint lines = row_count / 16 + (row_count % 16 ? 1 : 0);
    const ulong each = lines / chunk_count + (lines % chunk_count ? 1 : 0);
    const ulong begin = chunk * each * 16, end = begin + each * 16;
    return (uint2)(begin < row_count ? begin : row_count, end < row_count ? end : row_count);
}

static inline uint chunk_sum_before(const uint chunk, __global const uint *restrict chunk_sums)
{
    uint sum = 0;
    for (uint c = 0; c < chunk; ++c) sum += chunk_sums[c];
    return sum;
}
