// Edge collapse, the last stage: what atomics placed in any order, in one that is always the same.
//
// Source    Shell 1959, A High-Speed Sorting Procedure
// Work      1-D, one item per chunk of vertices; for devices whose items share a map
// Reads     counts      uint[2]                   vertices, triangles of the output
//           owned, met  uint[row_count + 1]       where each vertex's samples and corners end
// Writes    samples     float4[sample_count]      in order at each vertex
//           ring        uint[9 * triangles out]
//           slots       uint[3 * triangles out]   the row of each corner there
// Needs     common/chunk.cl
// Plain     cluster/edge_collapse/fit_reference.py

// rows that are alike may lie as they like
static inline bool fit_after(const float4 p, const float4 q)
{
    return p.x != q.x ? p.x > q.x : p.y != q.y ? p.y > q.y : p.z != q.z ? p.z > q.z : p.w > q.w;
}

static inline void fit_order(__global float4 *samples, const uint sample_count, __global uint *ring, const uint corner_count)
{
    for (uint gap = sample_count / 2; gap; gap /= 2)
        for (uint i = gap; i < sample_count; ++i) {
            const float4 own = samples[i];
            uint at = i;
            for (; at >= gap && fit_after(samples[at - gap], own); at -= gap) samples[at] = samples[at - gap];
            samples[at] = own;
        }
    for (uint i = 1; i < corner_count; ++i) {
        const uint3 own = vload3(i, ring);
        uint at = i;
        for (; at && ring[3 * (at - 1)] > own.x; --at) vstore3(vload3(at - 1, ring), at, ring);
        vstore3(own, at, ring);
    }
}

__kernel void edge_collapse_fit_order_rows(
    __global const uint *restrict counts,
    __global const uint *restrict owned,
    __global const uint *restrict met,
    __global float4 *restrict samples,
    __global uint *restrict ring,
    __global uint *restrict slots,
    const uint room,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || counts[1] > room) return;
    const uint2 range = chunk_rows(chunk, chunk_count, counts[0]);
    for (uint v = range.x; v < range.y; ++v) {
        const uint first = v ? owned[v - 1] : 0, start = v ? met[v - 1] : 0;
        fit_order(samples + first, owned[v] - first, ring + 3 * (size_t)start, met[v] - start);
        for (uint i = start; i < met[v]; ++i) slots[ring[3 * (size_t)i]] = i;
    }
}
