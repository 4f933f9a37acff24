// Exclusive scan of counts: where does each row's output begin, and how much is there in all?
//
// Source    Blelloch 1990, section 1.3 (each processor scans its own run); modulo 2^32 like any uint sum
// Work      1-D, one item per chunk of rows; a chunk walks its rows in order, so the sums do not depend on the device
// Reads     counts      uint[capacity]
//           live        uint[1]          rows that count; the rest of the capacity is left alone
// Writes    chunk_sums  uint[chunk_count]
//           offsets     uint[capacity]   may be the same memory as counts
//           total       uint[1]
// Needs     common/chunk.cl

__kernel void stages_scan_sum(
    __global const uint *restrict counts,
    __global const uint *restrict live,
    __global uint *restrict chunk_sums,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, live[0] < capacity ? live[0] : capacity);
    uint8 sums = 0;
    uint r = rows.x;
    for (; r + 8 <= rows.y; r += 8) sums += vload8(0, counts + r);
    const uint4 four = sums.lo + sums.hi;
    uint sum = four.x + four.y + four.z + four.w;
    for (; r < rows.y; ++r) sum += counts[r];
    chunk_sums[chunk] = sum;
}

__kernel void stages_scan_write(
    __global const uint *counts, // no restrict: scanning in place is allowed
    __global const uint *restrict chunk_sums,
    __global const uint *restrict live,
    __global uint *offsets,
    __global uint *restrict total,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint sum = chunk_sum_before(chunk, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, live[0] < capacity ? live[0] : capacity);
    uint r = rows.x;
    for (; r + 8 <= rows.y; r += 8) {
        // three doubling steps inside the vector; only `sum` is carried from one vector to the next
        const uint8 own = vload8(0, counts + r);
        uint8 sums = own + (uint8)(0, own.s0123, own.s45, own.s6);
        sums += (uint8)(0, 0, sums.s0123, sums.s45);
        sums += (uint8)(0, 0, 0, 0, sums.s0123);
        vstore8(sums - own + sum, 0, offsets + r);
        sum += sums.s7;
    }
    for (; r < rows.y; ++r) {
        const uint own = counts[r];
        offsets[r] = sum;
        sum += own;
    }
    if (chunk == chunk_count - 1) total[0] = sum;
}
