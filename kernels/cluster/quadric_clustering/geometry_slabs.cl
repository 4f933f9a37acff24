// Quadric vertex clustering, geometry stage for many cores: cells in slabs, each summed by one item alone.
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (quadric map) and 16-17 (final clustering); the slabs are a reconstruction.
//           A slab is a run of cells. The triangles that touch it are listed in their order, so each cell's sum has the
//           order and so the bits of one item per map over all triangles, whatever the number of slabs and chunks
// Work      1-D, one item per chunk of vertices, then of triangles; `sum` one per slab, eight triangles at a time
// Reads     points        float4[vertex_count]         x y z in units of the largest cell edge, w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
// Writes    ranks         uint[vertex_count]           the same ranks close together
//           samples       uint[BINS * sample_count]    per share: corners of every stride-th triangle by bin, 2^shift cells
//           bounds        uint[slab_count + 1]         first cell of each slab
//           pieces        uint[3 * triangle_count + 4 * chunk_count]  ranks of surviving triangles, one piece per chunk
//           piece_counts  uint[chunk_count]            triangles in each piece
//           lists         uint[3 * BLOCK * blocks]     triangles, in blocks; a chunk takes its own blocks, as it needs them
//           links         uint[blocks]                 the block that follows in its list
//           heads         uint[2 * slab_count * chunk_count]  of each chunk, by slab: first block, triangles in all
//           maps          float[16 * (capacity * map_count + slab_count)]  as in geometry.cl; then a row of each slab for
//                                                      corners in other slabs
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl cluster/quadric_clustering/geometry.cl
// Plain     cluster/quadric_clustering/reference.py

#define BINS 1024 // like BLOCK, as slabs.py has it
#define BLOCK 128
#define MOST_SLABS 256

__kernel void quadric_clustering_geometry_slabs_ranks(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global uint *restrict ranks,
    __global uint *restrict samples,
    const uint shift,
    const uint stride,
    const uint sample_count,
    const uint vertex_count,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) ranks[v] = geometry_rank(points, v);

    // the first chunks sample for all
    if (chunk >= sample_count) return;
    uint bins[BINS] = {0};
    const uint2 share = geometry_share(chunk, sample_count, triangle_count);
    for (ulong t = share.x; t < share.y; t += stride) {
        const size_t row = 3 * (size_t)t;
        for (uint i = 0; i < 3; ++i) ++bins[geometry_rank(points, triangles[row + i]) >> shift];
    }
    for (uint b = 0; b < BINS; ++b) samples[BINS * chunk + b] = bins[b];
}

// The slab of each bin, so that slabs have like numbers of sampled corners: every chunk finds the same, which takes less
// than a launch of its own would
static inline void slabs_cut(
    __global const uint *restrict samples, uchar *slabs, const uint slab_count, const uint sample_count)
{
    uint bins[BINS];
    for (uint b = 0; b < BINS; ++b) bins[b] = 0;
    for (uint sample = 0; sample < sample_count; ++sample)
        for (uint b = 0; b < BINS; ++b) bins[b] += samples[BINS * sample + b];
    ulong total = 0, before = 0;
    for (uint b = 0; b < BINS; ++b) total += bins[b];
    for (uint b = 0; b < BINS; ++b) {
        slabs[b] = total ? (2 * before + bins[b]) * slab_count / (2 * total + 1) : 0;
        before += bins[b];
    }
}

// where the next triangle of one slab goes: its place among all blocks, and how many went into full ones
typedef struct { uint place, before; } slabs_end;

// writes a triangle behind a list, and moves its end if `is_in`
INLINE void slabs_push(__global uint *restrict lists, __global uint *restrict links, slabs_end *end, uint *next,
    const uint3 v, const bool is_in)
{
    const uint place = end->place;
    vstore3(v, place, lists);
    end->place = place + is_in;
    if (!(is_in & (place % BLOCK == BLOCK - 1))) return;
    links[place / BLOCK] = *next;
    end->place = BLOCK * (*next)++;
    end->before += BLOCK;
}

__kernel void quadric_clustering_geometry_slabs_list(
    __global const uint *restrict ranks,
    __global const uint *restrict triangles,
    __global const uint *restrict samples,
    __global uint *restrict bounds,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    __global uint *restrict lists,
    __global uint *restrict links,
    __global uint2 *restrict heads,
    const uint shift,
    const uint sample_count,
    const uint slab_count,
    const uint capacity,
    const uint emit, // words that a survivor takes of a piece: 3, or 0 where no one asks for them
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uchar slabs[BINS];
    slabs_cut(samples, slabs, slab_count, sample_count);
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
    for (uint s = 0; s < slab_count; ++s) ends[s] = (slabs_end){BLOCK * (first + s), 0};
    __global uint *piece = pieces + 3 * (size_t)share.x + 4 * chunk;
    __global uint *out = piece;
    for (uint t = share.x; t < share.y; ++t) {
        const uint3 ahead = vload3(min(t + AHEAD, triangle_count - 1), triangles);
        prefetch(ranks + ahead.x, 1);
        prefetch(ranks + ahead.y, 1);
        prefetch(ranks + ahead.z, 1);
        const uint3 v = vload3(t, triangles);
        const uint a = ranks[v.x], b = ranks[v.y], c = ranks[v.z];
        out[0] = a;
        out[1] = b;
        out[2] = c;
        out += (a != b) & (b != c) & (c != a) ? emit : 0;
        const uint sa = slabs[a >> shift], sb = slabs[b >> shift], sc = slabs[c >> shift];
        slabs_push(lists, links, ends + sa, &next, v, true);
        if ((sb != sa) | (sc != sa)) { // of the three slabs each once
            slabs_push(lists, links, ends + sb, &next, v, sb != sa);
            slabs_push(lists, links, ends + sc, &next, v, (sc != sa) & (sc != sb));
        }
    }
    piece_counts[chunk] = (uint)((out - piece) / 3);
    for (uint s = 0; s < slab_count; ++s) heads[slab_count * chunk + s] = (uint2)(first + s, ends[s].before + ends[s].place % BLOCK);
}

// up to eight triangles of a list
INLINE void slabs_add(__global const float4 *points, __global float8 *restrict map, const geometry_cells cells,
    __global const uint *restrict list, const uint count)
{
    uint index[24];
#pragma unroll
    for (uint j = 0; j < 24; ++j) index[j] = list[j / 3 < count ? j : j % 3];
    geometry_eight_triangles(points, map, cells, 0, index, count, false);
}

__kernel void quadric_clustering_geometry_slabs_sum(
    __global const float4 *points,
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
                __global const uint *list = lists + 3 * BLOCK * (size_t)block;
                const uint here = min(left, (uint)BLOCK);
                uint i = 0;
                for (; i + 8 <= here; i += 8) {
                    __global const uint *ahead = list + 3 * min(i + AHEAD, here - 8);
#pragma unroll
                    for (uint j = 0; j < 24; ++j) prefetch(points + ahead[j], 1);
                    slabs_add(points, map, cells, list + 3 * i, 8);
                }
                if (i < here) slabs_add(points, map, cells, list + 3 * i, here - i);
                left -= here;
                if (left) block = links[block];
            }
        }
    }
}
