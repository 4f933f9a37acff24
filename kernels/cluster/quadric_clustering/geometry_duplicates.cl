// Quadric vertex clustering, geometry stage: of output triangles with the same three vertices the first stays.
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
// Needs     common/chunk.cl

#define NO_TRIANGLE 0xFFFFFFFFu

// the three vertices in ascending order
static inline uint3 duplicates_key(__global const uint *restrict joined, const uint t)
{
    const uint3 c = vload3(t, joined);
    const uint low = min(c.x, min(c.y, c.z)), high = max(c.x, max(c.y, c.z));
    return (uint3)(low, c.x ^ c.y ^ c.z ^ low ^ high, high);
}

static inline bool duplicates_same(const uint3 a, const uint3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static inline uint duplicates_slot(const uint3 key, const uint slot_mask)
{
    uint hash = key.x * 0x9E3779B1u ^ key.y * 0x85EBCA77u ^ key.z * 0xC2B2AE3Du;
    hash = (hash ^ (hash >> 15)) * 0x2C1B3C6Du;
    return (hash ^ (hash >> 13)) & slot_mask;
}

__kernel void quadric_clustering_geometry_duplicates_insert(
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
        const uint3 key = duplicates_key(joined, t);
        // at least half of the slots are free, so the walk ends
        for (uint slot = duplicates_slot(key, slot_mask);; slot = (slot + 1) & slot_mask) {
            const uint found = atomic_cmpxchg(slots + slot, NO_TRIANGLE, t);
            if (found == NO_TRIANGLE) break;
            if (duplicates_same(duplicates_key(joined, found), key)) {
                atomic_min(slots + slot, t);
                break;
            }
        }
    }
}

__kernel void quadric_clustering_geometry_duplicates_count(
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
        const uint3 key = duplicates_key(joined, t);
        uint slot = duplicates_slot(key, slot_mask);
        while (!duplicates_same(duplicates_key(joined, slots[slot]), key)) slot = (slot + 1) & slot_mask;
        flags[t] = slots[slot] == t;
        count += flags[t];
    }
    chunk_sums[chunk] = count;
}

__kernel void quadric_clustering_geometry_duplicates_write(
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
