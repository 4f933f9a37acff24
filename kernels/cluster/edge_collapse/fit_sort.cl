// Edge collapse, the last stage: corners of the input by the vertex of the output that they went to, and corners of the
// output by theirs.
//
// Source    none; a counting sort, stable on a CPU, where each item has a map
// Work      roots, chain: 1-D, one item per chunk of vertices; count, scatter: one per chunk of triangles; starts: one item
// Reads     parents     uint[vertex_count]        where a vertex went
//           numbers     uint[vertex_count]        of the output, 0xFFFFFFFF where none
//           points      float4[vertex_count]      w: triangles at the vertex, and whether it is locked
//           first       uint[given_count]         where the input's vertices went before all that; second: and then
//           positions   float[3 * given_count]    the input, model units
//           triangles   uint[3 * triangle_count]
//           survivors   uint[3 * triangles out]
//           counts      uint[2]                   vertices, triangles of the output
// Writes    places      float4[row_count]         output vertices, near 1; w: not 0, it stays
//           vertex_map  uint[given_count]         output vertex of each input vertex
//           samples     float4[sample_count]      half-way from the centroid to some input corners, and the area
//           ring        uint[9 * triangles out]   corners, the vertices next and before
//           slots       uint[3 * triangles out]   the row of each corner there
//           owned, met  uint[map_count * (row_count + 1)]   samples and corners of each vertex, in parts; then where they
//                                                 go; afterwards the last part has where each vertex's end
// Needs     common/chunk.cl cluster/edge_collapse/fit.cl
// Plain     cluster/edge_collapse/fit_reference.py
// Defines   FIT_SAMPLES corners of the input that are looked at for one triangle of the output, about; where these are many,
//           FIT_MANY    so many in all, or
//           FIT_FEW     for each, since samples are what the fit takes its time for

#define FIT_LOCKED 4194304.0f // as in setup.cl

__kernel void edge_collapse_fit_sort_roots(
    __global const uint *restrict parents,
    __global const uint *restrict numbers,
    __global const float4 *restrict points,
    __global float4 *restrict places,
    __global uint *restrict vertex_map,
    const uint row_count,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        uint root = v;
        for (uint above = parents[root]; above != root; above = parents[root]) root = above;
        const uint number = numbers[root];
        vertex_map[v] = number;
        if (root != v || number >= row_count) continue; // none, or no room for that many
        const float4 p = points[v];
        places[number] = (float4)(p.xyz, p.w > FIT_LOCKED ? 1.0f : 0.0f);
    }
}

__kernel void edge_collapse_fit_sort_chain(
    __global const uint *restrict first,
    __global const uint *restrict second,
    __global uint *restrict vertex_map,
    const uint given_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, given_count);
    for (uint v = range.x; v < range.y; ++v) vertex_map[v] = first[v] == FIT_NONE ? FIT_NONE : second[first[v]];
}

// every so many corners of the input are samples; odd, so that no row of a pattern is met at one place alone
static inline uint fit_stride(__global const uint *counts, const uint triangle_count)
{
    const ulong wanted = min((ulong)FIT_SAMPLES * counts[1], max((ulong)FIT_FEW * counts[1], (ulong)FIT_MANY));
    return (uint)(3ul * triangle_count / max(wanted, 1ul)) | 1u;
}

// what an item sorts, of every so many corners of the input and of all of the output, and where its part of the sums begins
typedef struct {
    uint2 samples, corners;
    uint stride;
    size_t part;
    bool alone; // the part is its own
} fit_share;

static inline void fit_share_of(fit_share *share, const uint chunk, const uint chunk_count, const uint map_count,
    const uint row_count, __global const uint *counts, const uint triangle_count)
{
    share->alone = chunk_count == map_count;
    share->part = share->alone ? (size_t)chunk * (row_count + 1) : 0;
    share->stride = fit_stride(counts, triangle_count);
    share->samples = chunk_rows(chunk, chunk_count, (3 * triangle_count + share->stride - 1) / share->stride);
    share->corners = chunk_rows(chunk, chunk_count, 3 * counts[1]);
}

// the number, and then one more
static inline uint fit_next(__global uint *number, const bool alone) { return alone ? (*number)++ : atomic_inc(number); }

__kernel void edge_collapse_fit_sort_count(
    __global const uint *restrict triangles,
    __global const uint *restrict vertex_map,
    __global const uint *restrict survivors,
    __global const uint *restrict counts,
    __global uint *restrict owned,
    __global uint *restrict met,
    const uint room,
    const uint row_count,
    const uint triangle_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || counts[1] > room) return;

    fit_share share;
    fit_share_of(&share, chunk, chunk_count, map_count, row_count, counts, triangle_count);
    owned += share.part, met += share.part;
    if (share.alone)
        for (uint v = 0; v < counts[0]; ++v) owned[v] = met[v] = 0;
    for (uint s = share.samples.x; s < share.samples.y; ++s) {
        const uint v = vertex_map[triangles[(size_t)s * share.stride]];
        if (v != FIT_NONE) fit_next(owned + v, share.alone);
    }
    for (uint c = share.corners.x; c < share.corners.y; ++c) fit_next(met + survivors[c], share.alone);
}

__kernel void edge_collapse_fit_sort_starts(
    __global const uint *restrict counts,
    __global uint *restrict owned,
    __global uint *restrict met,
    const uint room,
    const uint row_count,
    const uint map_count)
{
    if (get_global_id(0) > 0 || counts[1] > room) return;
    uint samples = 0, corners = 0;
    for (uint v = 0; v < counts[0]; ++v)
        for (uint map = 0; map < map_count; ++map) {
            const size_t at = (size_t)map * (row_count + 1) + v;
            const uint own = owned[at], here = met[at];
            owned[at] = samples;
            met[at] = corners;
            samples += own;
            corners += here;
        }
}

__kernel void edge_collapse_fit_sort_scatter(
    __global const float *restrict positions,
    __global const uint *restrict triangles,
    __global const uint *restrict vertex_map,
    __global const uint *restrict survivors,
    __global const uint *restrict counts,
    __global uint *restrict owned,
    __global uint *restrict met,
    __global float4 *restrict samples,
    __global uint *restrict ring,
    __global uint *restrict slots,
    const float prescale,
    const uint room,
    const uint row_count,
    const uint triangle_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || counts[1] > room) return;

    fit_share share;
    fit_share_of(&share, chunk, chunk_count, map_count, row_count, counts, triangle_count);
    owned += share.part, met += share.part;
    for (uint s = share.samples.x; s < share.samples.y; ++s) {
        const uint corner = s * share.stride, u = triangles[corner], v = vertex_map[u];
        if (v == FIT_NONE) continue;
        const uint2 others = fit_others(corner);
        const float3 a = vload3(u, positions) * prescale, b = vload3(triangles[others.x], positions) * prescale - a;
        const float3 c = vload3(triangles[others.y], positions) * prescale - a, n = cross(b, c);
        const uint at = fit_next(owned + v, share.alone);
        samples[at] = (float4)(a + (b + c) * 0.166666667f, sqrt(dot(n, n)));
    }
    for (uint c = share.corners.x; c < share.corners.y; ++c) {
        const uint v = survivors[c], at = fit_next(met + v, share.alone);
        const uint2 others = fit_others(c);
        vstore3((uint3)(c, survivors[others.x], survivors[others.y]), at, ring);
        slots[c] = at;
    }
}
