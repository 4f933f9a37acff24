// Quadric vertex clustering, geometry stage: each triangle's quadric added to its corners' cells.
//
// Long because all walks over the triangles share their eights
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (quadric map) and 16-17 (final clustering); `fused` does both in one
//           walk over the triangles and emits the cells' ranks, which are turned into output vertices later
// Work      1-D, one item per private map, each over its share of the triangles, eight at a time
// Reads     points        float4[vertex_count]         x y z in units of the largest cell edge, w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
// Writes    maps          float[16 * capacity * map_count]  per cell: xx xy xz yy yz zz x y | z, surviving corners, 0 0, corner sum x y z, corners
//           pieces        uint[3 * triangle_count + 4 * map_count]  ranks of surviving triangles, one piece per map
//           piece_counts  uint[map_count]              triangles in each piece
// Needs     common/chunk.cl common/transpose.cl cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py

#define AHEAD 24 // triangles between a prefetch and its use
#define INLINE static inline __attribute__((always_inline)) // a call would pass the eight triangles through memory

// one corner of eight triangles, given by every third index
INLINE fours8 geometry_corner(__global const float4 *points, const uint *index)
{
    return transpose_fours((float8)(points[index[0]], points[index[12]]), (float8)(points[index[3]], points[index[15]]),
        (float8)(points[index[6]], points[index[18]]), (float8)(points[index[9]], points[index[21]]));
}

// `points` is nowhere restrict: since the maps might then alias it, the compiler reads a corner again where it is added;
// kept from its first use, 24 corners would go through the stack
INLINE uint geometry_rank(__global const float4 *points, const uint v)
{
    // a load of its own: taking it out of the vector again costs more
    return ((__global const uint *)points)[4 * (size_t)v + 3];
}

// the cells of a map that are added to: all, or `count` of them from `first` on; what belongs to another goes to the row
// `other`, which no one reads, since a branch would cost more
typedef struct {
    bool all;
    uint first, count;
    size_t other;
} geometry_cells;

#define GEOMETRY_ALL ((geometry_cells){true, 0, 0, 0})

INLINE __global float8 *geometry_row(__global float8 *restrict map, const uint rank, const geometry_cells cells)
{
    return map + 2 * (cells.all || rank - cells.first < cells.count ? (size_t)rank : cells.other);
}

// Adds one triangle to its three cells, all three even when they are the same: a branch would cost more; writes its
// ranks to `out` and returns the next free place, which is the same when the triangle does not survive
INLINE __global uint *geometry_add(__global const float4 *points, __global float8 *restrict map, const geometry_cells cells,
    __global uint *out, const uint *index, const float8 low, const float4 rest, const uint step, const bool emit)
{
    const uint a = geometry_rank(points, index[0]), b = geometry_rank(points, index[1]), c = geometry_rank(points, index[2]);
    __global float8 *cell = geometry_row(map, a, cells);
    cell[0] += low;
    cell[1] += (float8)(rest, points[index[0]].xyz, 1.0f);
    cell = geometry_row(map, b, cells);
    cell[0] += low;
    cell[1] += (float8)(rest, points[index[1]].xyz, 1.0f);
    cell = geometry_row(map, c, cells);
    cell[0] += low;
    cell[1] += (float8)(rest, points[index[2]].xyz, 1.0f);
    if (!emit) return out;
    out[0] = a;
    out[1] = b;
    out[2] = c;
    return out + step;
}

// eight triangles given by 24 indices; those from `count` on only fill up the eight, and are not added
INLINE __global uint *geometry_eight_triangles(__global const float4 *points, __global float8 *restrict map,
    const geometry_cells cells, __global uint *out, const uint *index, const uint count, const bool emit)
{
    const fours8 a = geometry_corner(points, index);
    const fours8 b = geometry_corner(points, index + 1);
    const fours8 c = geometry_corner(points, index + 2);

    // m = (b - a) x (c - a), weight = area / 3 / |m|^2, so that weight m m^T = area / 3 n n^T
    const float8 ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
    const float8 vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    const float8 mx = uy * vz - uz * vy, my = uz * vx - ux * vz, mz = ux * vy - uy * vx;
    const float8 d = -(mx * a.x + my * a.y + mz * a.z);
    const float8 square = mx * mx + my * my + mz * mz;
    // no area, no plane: such a triangle counts at its corners alone
    const float8 weight = square > (float8)(1e-30f) ? 1.0f / (6.0f * sqrt(square)) : (float8)(0.0f);
    const float8 wx = mx * weight, wy = my * weight, wz = mz * weight;

    const int8 ra = as_int8(a.w), rb = as_int8(b.w), rc = as_int8(c.w);
    const int8 distinct = (ra != rb) & (rb != rc) & (rc != ra);
    const float8 survives = distinct ? (float8)(1.0f) : (float8)(0.0f);
    const uint8 step = as_uint8(distinct) & 3;

    const float8 xx = mx * wx, xy = mx * wy, xz = mx * wz, yy = my * wy, yz = my * wz, zz = mz * wz;
    const float8 bx = d * wx, by = d * wy, bz = d * wz;

    // columns of products back to one row per triangle
    const fours8 q = transpose_fours(xx, xy, xz, yy), r = transpose_fours(yz, zz, bx, by);
    const fours8 s = transpose_fours(bz, survives, (float8)(0.0f), (float8)(0.0f));

    out = geometry_add(points, map, cells, out, index, (float8)(q.x.lo, r.x.lo), s.x.lo, step.s0, emit);
    if (count > 1) out = geometry_add(points, map, cells, out, index + 3, (float8)(q.y.lo, r.y.lo), s.y.lo, step.s1, emit);
    if (count > 2) out = geometry_add(points, map, cells, out, index + 6, (float8)(q.z.lo, r.z.lo), s.z.lo, step.s2, emit);
    if (count > 3) out = geometry_add(points, map, cells, out, index + 9, (float8)(q.w.lo, r.w.lo), s.w.lo, step.s3, emit);
    if (count > 4) out = geometry_add(points, map, cells, out, index + 12, (float8)(q.x.hi, r.x.hi), s.x.hi, step.s4, emit);
    if (count > 5) out = geometry_add(points, map, cells, out, index + 15, (float8)(q.y.hi, r.y.hi), s.y.hi, step.s5, emit);
    if (count > 6) out = geometry_add(points, map, cells, out, index + 18, (float8)(q.z.hi, r.z.hi), s.z.hi, step.s6, emit);
    if (count > 7) out = geometry_add(points, map, cells, out, index + 21, (float8)(q.w.hi, r.w.hi), s.w.hi, step.s7, emit);
    return out;
}

static inline __global float8 *geometry_clear(__global float8 *restrict maps, const uint map, const uint capacity)
{
    __global float8 *own = maps + 2 * (size_t)capacity * map;
    for (size_t i = 0; i < 2 * (size_t)capacity; ++i) own[i] = 0.0f;
    return own;
}

// the last triangles of a share, fewer than eight: the rest of the eight repeats the last one
INLINE __global uint *geometry_last_triangles(__global const float4 *points, __global const uint *restrict triangles,
    __global float8 *restrict map, __global uint *out, const uint2 share, const uint t, const bool emit)
{
    uint index[24];
    for (uint j = 0; j < 8; ++j) {
        const size_t row = min(t + j, share.y - 1);
        for (uint corner = 0; corner < 3; ++corner) index[3 * j + corner] = triangles[3 * row + corner];
    }
    return geometry_eight_triangles(points, map, GEOMETRY_ALL, out, index, share.y - t, emit);
}

INLINE __global uint *geometry_next_triangles(__global const float4 *points, __global const uint *restrict triangles,
    __global float8 *restrict map, __global uint *out, const uint t, const uint triangle_count, const bool emit)
{
    // the addresses ahead stay inside the array: the last ones are asked for again
    __global const uint *ahead = triangles + 3 * (size_t)min(t + AHEAD, triangle_count - 8);
#pragma unroll
    for (uint i = 0; i < 24; ++i) prefetch(points + ahead[i], 1);
    uint index[24];
#pragma unroll
    for (uint i = 0; i < 24; ++i) index[i] = triangles[3 * (size_t)t + i];
    return geometry_eight_triangles(points, map, GEOMETRY_ALL, out, index, 8, emit);
}

__kernel void quadric_clustering_geometry_accumulate(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global float8 *restrict maps,
    const uint map_count,
    const uint capacity,
    const uint triangle_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    __global float8 *own = geometry_clear(maps, map, capacity);
    const uint2 share = geometry_share(map, map_count, triangle_count);
    uint t = share.x;
    for (; t + 8 <= share.y; t += 8) geometry_next_triangles(points, triangles, own, 0, t, triangle_count, false);
    if (t < share.y) geometry_last_triangles(points, triangles, own, 0, share, t, false);
}

__kernel void quadric_clustering_geometry_fused(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global float8 *restrict maps,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    const uint map_count,
    const uint capacity,
    const uint triangle_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    __global float8 *own = geometry_clear(maps, map, capacity);
    const uint2 share = geometry_share(map, map_count, triangle_count);
    __global uint *piece = pieces + 3 * (size_t)share.x + 4 * map;
    __global uint *out = piece;
    uint t = share.x;
    for (; t + 8 <= share.y; t += 8)
        out = geometry_next_triangles(points, triangles, own, out, t, triangle_count, true);
    if (t < share.y) out = geometry_last_triangles(points, triangles, own, out, share, t, true);
    piece_counts[map] = (uint)((out - piece) / 3);
}

// one batch of one map's share: the map goes on from the batch before, so that its sums are those of the whole share
__kernel void quadric_clustering_geometry_batch(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global float8 *restrict maps,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    const uint map,
    const uint capacity,
    const uint triangle_count)
{
    if (get_global_id(0) > 0) return;

    __global float8 *own = maps + 2 * (size_t)capacity * map;
    __global uint *out = pieces;
    uint t = 0;
    for (; t + 8 <= triangle_count; t += 8)
        out = geometry_next_triangles(points, triangles, own, out, t, triangle_count, true);
    const uint2 share = (uint2)(0, triangle_count);
    if (t < triangle_count) out = geometry_last_triangles(points, triangles, own, out, share, t, true);
    piece_counts[0] = (uint)((out - pieces) / 3);
}
