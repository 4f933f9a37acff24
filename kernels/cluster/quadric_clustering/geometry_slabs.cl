// Quadric vertex clustering, geometry stage for many cores: cells in slabs, each summed by one item alone.
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (quadric map) and 16-17 (final clustering); the slabs are a reconstruction.
//           A slab is a run of cells. The triangles that touch it are listed in their order, so each cell's sum has the
//           order and so the bits of one item per map over all triangles, whatever the number of slabs and chunks
// Work      1-D, `sample` and `list` one item per chunk of triangles; `sum` one item per slab, eight triangles at a time
// Reads     points        float4[vertex_count]         x y z in units of the largest cell edge, w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
// Writes    samples       uint[BINS * chunk_count]     per chunk: corners of every stride-th triangle by bin, 2^shift cells
//           bounds        uint[slab_count + 1]         first cell of each slab
//           pieces        uint[3 * triangle_count + 4 * chunk_count]  ranks of surviving triangles, one piece per chunk
//           piece_counts  uint[chunk_count]            triangles in each piece
//           lists         uint[BLOCK * blocks]         triangles, in blocks; a chunk takes its own blocks, as it needs them
//           links         uint[blocks]                 the block that follows in its list
//           heads         uint[2 * slab_count * chunk_count]  of each chunk, by slab: first block, triangles in all
//           maps          float[16 * (capacity * map_count + slab_count)]  as in geometry.cl; then a row of each slab for
//                                                      corners in other slabs
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl cluster/quadric_clustering/geometry.cl
// Plain     cluster/quadric_clustering/reference.py

#define BINS 2048 // as host.py has it
#define BLOCK 64  // as host.py has it
#define MOST_SLABS 256

__kernel void quadric_clustering_geometry_slabs_sample(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global uint *restrict samples,
    const uint shift,
    const uint stride,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint bins[BINS];
    for (uint b = 0; b < BINS; ++b) bins[b] = 0;
    const uint2 share = geometry_share(chunk, chunk_count, triangle_count);
    for (ulong t = share.x; t < share.y; t += stride) {
        const uint3 v = vload3((size_t)t, triangles);
        ++bins[min(geometry_rank(points, v.x) >> shift, BINS - 1u)];
        ++bins[min(geometry_rank(points, v.y) >> shift, BINS - 1u)];
        ++bins[min(geometry_rank(points, v.z) >> shift, BINS - 1u)];
    }
    for (uint b = 0; b < BINS; ++b) samples[BINS * chunk + b] = bins[b];
}

// The slab of each bin, so that slabs have like numbers of sampled corners: every chunk finds the same, which takes less
// than a launch of its own would
static inline void slabs_cut(
    __global const uint *restrict samples, uchar *slabs, const uint slab_count, const uint chunk_count)
{
    uint bins[BINS];
    for (uint b = 0; b < BINS; ++b) bins[b] = 0;
    for (uint chunk = 0; chunk < chunk_count; ++chunk)
        for (uint b = 0; b < BINS; ++b) bins[b] += samples[BINS * chunk + b];
    ulong total = 0;
    for (uint b = 0; b < BINS; ++b) total += bins[b];
    ulong before = 0;
    for (uint b = 0; b < BINS; ++b) {
        slabs[b] = total ? (2 * before + bins[b]) * slab_count / (2 * total + 1) : 0;
        before += bins[b];
    }
}

// where the next triangle of one slab goes
typedef struct { uint block, count; } slabs_end;

INLINE void slabs_push(__global uint *restrict lists, __global uint *restrict links, slabs_end *end, uint *next, const uint t)
{
    lists[BLOCK * (size_t)end->block + end->count % BLOCK] = t;
    if (++end->count % BLOCK) return;
    links[end->block] = *next;
    end->block = (*next)++;
}

__kernel void quadric_clustering_geometry_slabs_list(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global const uint *restrict samples,
    __global uint *restrict bounds,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    __global uint *restrict lists,
    __global uint *restrict links,
    __global uint2 *restrict heads,
    const uint shift,
    const uint slab_count,
    const uint capacity,
    const uint emit, // the pieces too
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uchar slabs[BINS];
    slabs_cut(samples, slabs, slab_count, chunk_count);
    if (chunk == 0) {
        uint slab = 0;
        for (uint b = 0; b < BINS; ++b)
            while (slab <= slabs[b]) bounds[slab++] = min((ulong)b << shift, (ulong)capacity);
        while (slab <= slab_count) bounds[slab++] = capacity;
    }

    const uint2 share = geometry_share(chunk, chunk_count, triangle_count);
    // at most three entries a triangle, and a block of each slab that is not full
    const uint first = (uint)(3 * (ulong)share.x / BLOCK) + (slab_count + 1) * chunk;
    uint next = first + slab_count;
    slabs_end ends[MOST_SLABS];
    for (uint s = 0; s < slab_count; ++s) ends[s] = (slabs_end){first + s, 0};
    __global uint *piece = pieces + 3 * (size_t)share.x + 4 * chunk;
    __global uint *out = piece;
    for (uint t = share.x; t < share.y; ++t) {
        __global const uint *ahead = triangles + 3 * (size_t)min(t + AHEAD, triangle_count - 1);
        prefetch(points + ahead[0], 1);
        prefetch(points + ahead[1], 1);
        prefetch(points + ahead[2], 1);
        const uint3 v = vload3(t, triangles);
        const uint a = geometry_rank(points, v.x), b = geometry_rank(points, v.y), c = geometry_rank(points, v.z);
        if (emit) {
            out[0] = a;
            out[1] = b;
            out[2] = c;
            out += 3 * ((a != b) & (b != c) & (c != a));
        }
        const uint sa = slabs[min(a >> shift, BINS - 1u)];
        const uint sb = slabs[min(b >> shift, BINS - 1u)];
        const uint sc = slabs[min(c >> shift, BINS - 1u)];
        slabs_push(lists, links, ends + sa, &next, t);
        if (sb != sa) slabs_push(lists, links, ends + sb, &next, t);
        if (sc != sa && sc != sb) slabs_push(lists, links, ends + sc, &next, t);
    }
    piece_counts[chunk] = (uint)((out - piece) / 3);
    for (uint s = 0; s < slab_count; ++s) heads[slab_count * chunk + s] = (uint2)(first + s, ends[s].count);
}

// up to eight triangles of a list
INLINE void slabs_add(__global const float4 *points, __global const uint *restrict triangles,
    __global float8 *restrict map, const geometry_cells cells, __global const uint *restrict list, const uint count)
{
    uint index[24];
#pragma unroll
    for (uint j = 0; j < 8; ++j) {
        __global const uint *v = triangles + 3 * (size_t)list[j < count ? j : count - 1];
        index[3 * j] = v[0];
        index[3 * j + 1] = v[1];
        index[3 * j + 2] = v[2];
    }
    geometry_eight_triangles(points, map, cells, 0, index, count, false);
}

__kernel void quadric_clustering_geometry_slabs_sum(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global const uint *restrict bounds,
    __global const uint *restrict lists,
    __global const uint *restrict links,
    __global const uint2 *restrict heads,
    __global float8 *restrict maps,
    const uint map_count,
    const uint capacity,
    const uint slab_count,
    const uint chunk_count)
{
    const uint slab = get_global_id(0);
    if (slab >= slab_count) return;

    const uint first = bounds[slab], count = bounds[slab + 1] - first;
    const size_t spare = (size_t)capacity * map_count + slab;
    maps[2 * spare] = maps[2 * spare + 1] = 0.0f;
    const uint each = chunk_count / map_count;
    for (uint m = 0; m < map_count; ++m) {
        __global float8 *map = maps + 2 * (size_t)capacity * m;
        const geometry_cells cells = {false, first, count, spare - (size_t)capacity * m};
        for (size_t i = 2 * (size_t)first; i < 2 * ((size_t)first + count); ++i) map[i] = 0.0f;
        for (uint chunk = each * m; chunk < each * (m + 1); ++chunk) {
            const uint2 head = heads[slab_count * chunk + slab];
            uint block = head.x;
            for (uint left = head.y; left;) {
                __global const uint *list = lists + BLOCK * (size_t)block;
                const uint here = min(left, (uint)BLOCK);
                uint i = 0;
                for (; i + 8 <= here; i += 8) slabs_add(points, triangles, map, cells, list + i, 8);
                if (i < here) slabs_add(points, triangles, map, cells, list + i, here - i);
                left -= here;
                if (left) block = links[block];
            }
        }
    }
}
