// Stream compaction: the rows whose flag is set move to the front, in their order.
//
// Source    Blelloch 1990, section 1.3 (each processor packs its own run); the geometry stage that discards
// Work      1-D, one item per chunk of rows, each writing to its own run of the output
// Reads     flags       uchar[capacity]              not 0: the row stays
//           live        uint [1]                     rows that count
//           rows        uint [ROW_WORDS * capacity]  any type of 4 bytes a word
// Writes    chunk_sums  uint [chunk_count]
//           indices     uint [capacity]              of the rows that stay
//           kept_rows   uint [ROW_WORDS * capacity]
//           total       uint [1]                     rows that stay
// Needs     common/chunk.cl
// Defines   ROW_WORDS   words in a row

__kernel void stages_compact_sum(
    __global const uchar *restrict flags,
    __global const uint *restrict live,
    __global uint *restrict chunk_sums,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, live[0] < capacity ? live[0] : capacity);
    int16 sums = 0;
    uint r = rows.x;
    for (; r + 16 <= rows.y; r += 16) sums -= convert_int16(vload16(0, flags + r) != (uchar16)0);
    const int8 eight = sums.lo + sums.hi;
    const int4 four = eight.lo + eight.hi;
    uint sum = four.x + four.y + four.z + four.w;
    for (; r < rows.y; ++r) sum += flags[r] != 0;
    chunk_sums[chunk] = sum;
}

// every row is written where the next kept one belongs, and overwritten until one is kept: no branch to mispredict.
// the loops end with the last kept row, so that nothing is written past the chunk's own run
__kernel void stages_compact_indices(
    __global const uchar *restrict flags,
    __global const uint *restrict live,
    __global const uint *restrict chunk_sums,
    __global uint *restrict indices,
    __global uint *restrict total,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint at = chunk_sum_before(chunk, chunk_sums);
    const uint end = at + chunk_sums[chunk];
    if (chunk == chunk_count - 1) total[0] = end;
    const uint2 rows = chunk_rows(chunk, chunk_count, live[0] < capacity ? live[0] : capacity);
    for (uint r = rows.x; at < end; r += 8) {
        // eight rows at once where none stays: twice as fast on sparse flags; it does not pay where rows are moved
        if (r + 8 <= rows.y && as_ulong(vload8(0, flags + r)) == 0) continue;
        for (uint i = r; i < r + 8 && at < end; ++i) {
            indices[at] = i;
            at += flags[i] != 0;
        }
    }
}

__kernel void stages_compact_rows(
    __global const uchar *restrict flags,
    __global const uint *restrict rows,
    __global const uint *restrict live,
    __global const uint *restrict chunk_sums,
    __global uint *restrict kept_rows,
    __global uint *restrict total,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint at = chunk_sum_before(chunk, chunk_sums);
    const uint end = at + chunk_sums[chunk];
    if (chunk == chunk_count - 1) total[0] = end;
    const uint2 range = chunk_rows(chunk, chunk_count, live[0] < capacity ? live[0] : capacity);
    for (uint r = range.x; at < end; ++r) {
        for (uint w = 0; w < ROW_WORDS; ++w)
            kept_rows[(size_t)at * ROW_WORDS + w] = rows[(size_t)r * ROW_WORDS + w];
        at += flags[r] != 0;
    }
}
