// Vertex clustering, geometry stage: of output triangles with the same three vertices the first stays.
//
// Source    none: clustering folds thin sheets onto themselves, which leaves pairs of triangles
// Work      1-D, one item per chunk of triangles; a slot ends up with the first triangle of its vertices whoever came first
// Reads     joined      uint[3 * triangle_count]     output triangles with their duplicates
//           total       uint[2]                      [1]: how many
// Writes    slots       uint[slot_mask + 1]          all 0xFFFFFFFF before `insert`; a triangle's number after it
//           flags       uchar[triangle_count]        1: stays
//           chunk_sums  uint[chunk_count]
//           survivors   uint[3 * triangle_count]
//           counts      uint[2]                      both: vertices as in total, triangles that stay
// Needs     common/chunk.cl common/corners.cl

__kernel void cluster_duplicates_insert(
    __global const uint *restrict joined,
    __global const uint *restrict total,
    __global uint *restrict slots,
    const uint slot_mask,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, total[1]);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 key = corners_sorted(vload3(t, joined));
        // at least half of the slots are free, so the walk ends
        for (uint slot = corners_slot(key, slot_mask);; slot = (slot + 1) & slot_mask) {
            const uint found = atomic_cmpxchg(slots + slot, NO_TRIANGLE, t);
            if (found == NO_TRIANGLE) break;
            if (corners_same(corners_sorted(vload3(found, joined)), key)) {
                atomic_min(slots + slot, t);
                break;
            }
        }
    }
}

__kernel void cluster_duplicates_count(
    __global const uint *restrict joined,
    __global const uint *restrict total,
    __global const uint *restrict slots,
    __global uchar *restrict flags,
    __global uint *restrict chunk_sums,
    const uint slot_mask,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, total[1]);
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 key = corners_sorted(vload3(t, joined));
        uint slot = corners_slot(key, slot_mask);
        while (!corners_same(corners_sorted(vload3(slots[slot], joined)), key)) slot = (slot + 1) & slot_mask;
        flags[t] = slots[slot] == t;
        count += flags[t];
    }
    chunk_sums[chunk] = count;
}

__kernel void cluster_duplicates_write(
    __global const uint *restrict joined,
    __global const uint *restrict total,
    __global const uchar *restrict flags,
    __global const uint *restrict chunk_sums,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, total[1]);
    uint place = chunk_sum_before(chunk, chunk_sums);
    for (uint t = rows.x; t < rows.y; ++t)
        if (flags[t]) vstore3(vload3(t, joined), place++, survivors);
    if (chunk == chunk_count - 1) {
        counts[0] = total[0];
        counts[1] = place;
    }
}
