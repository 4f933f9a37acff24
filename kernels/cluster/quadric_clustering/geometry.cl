// Quadric vertex clustering, geometry stage: each triangle's quadric added to its corners' cells.
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 (quadric map) and 16-17 (final clustering); `fused` does both in one
//           walk over the triangles and emits the cells' ranks, which are turned into output vertices later
// Work      1-D, one item per private map, each over its share of the triangles, four at a time
// Reads     points        float4[vertex_count]         x y z in units of the largest cell edge, w: bits of the cell's rank
//           triangles     uint[3 * triangle_count]
// Writes    maps          float[16 * capacity * map_count]  per cell: xx xy xz yy yz zz x y | z, surviving corners, 0 0, corner sum x y z, corners
//           pieces        uint[3 * triangle_count + 4 * map_count]  ranks of surviving triangles, one piece per map
//           piece_counts  uint[map_count]              triangles in each piece
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl

#define AHEAD 24 // triangles between a prefetch and its use

typedef struct { float4 x, y, z, w; } geometry_four;

static inline geometry_four geometry_transpose(const float4 a, const float4 b, const float4 c, const float4 d)
{
    geometry_four t;
    t.x = (float4)(a.x, b.x, c.x, d.x);
    t.y = (float4)(a.y, b.y, c.y, d.y);
    t.z = (float4)(a.z, b.z, c.z, d.z);
    t.w = (float4)(a.w, b.w, c.w, d.w);
    return t;
}

// adds one triangle to its three cells; branch-free: all three even when they are the same cell
static inline void geometry_add(
    __global float8 *restrict map, const float4 a, const float4 b, const float4 c, const float4 normal, const float4 weighted,
    const float4 rest, const float live)
{
    const float8 low = normal.s00011201 * weighted.s01212233;
    __global float8 *cell = map + 2 * (size_t)as_uint(a.w);
    cell[0] += low;
    cell[1] += (float8)(rest, a.xyz * live, live);
    cell = map + 2 * (size_t)as_uint(b.w);
    cell[0] += low;
    cell[1] += (float8)(rest, b.xyz * live, live);
    cell = map + 2 * (size_t)as_uint(c.w);
    cell[0] += low;
    cell[1] += (float8)(rest, c.xyz * live, live);
}

typedef struct { int4 a, b, c, distinct; } geometry_ranks;

// four triangles given by twelve indices; live: 1, or 0 for a triangle that only fills up the four
static inline __attribute__((always_inline)) geometry_ranks geometry_four_triangles(
    __global const float4 *restrict points, __global float8 *restrict map, const uint *index, const float4 live)
{
    const float4 a0 = points[index[0]], b0 = points[index[1]], c0 = points[index[2]];
    const float4 a1 = points[index[3]], b1 = points[index[4]], c1 = points[index[5]];
    const float4 a2 = points[index[6]], b2 = points[index[7]], c2 = points[index[8]];
    const float4 a3 = points[index[9]], b3 = points[index[10]], c3 = points[index[11]];
    const geometry_four a = geometry_transpose(a0, a1, a2, a3);
    const geometry_four b = geometry_transpose(b0, b1, b2, b3);
    const geometry_four c = geometry_transpose(c0, c1, c2, c3);

    // m = (b - a) x (c - a), weight = area / 3 / |m|^2, so that weight m m^T = area / 3 n n^T
    const float4 ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
    const float4 vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    const float4 mx = uy * vz - uz * vy, my = uz * vx - ux * vz, mz = ux * vy - uy * vx;
    const float4 d = -(mx * a.x + my * a.y + mz * a.z);
    const float4 square = mx * mx + my * my + mz * mz;
    // no area, no plane: such a triangle counts at its corners alone
    const float4 weight = live * (square > (float4)(1e-30f) ? 1.0f / (6.0f * sqrt(square)) : (float4)(0.0f));
    const float4 wx = mx * weight, wy = my * weight, wz = mz * weight, wd = d * weight;

    geometry_ranks ranks = {as_int4(a.w), as_int4(b.w), as_int4(c.w), 0};
    ranks.distinct = (ranks.a != ranks.b) & (ranks.b != ranks.c) & (ranks.c != ranks.a) & (live > (float4)(0.0f));
    const float4 survives = ranks.distinct ? (float4)(1.0f) : (float4)(0.0f);
    const float4 bz = mz * wd;

    geometry_add(map, a0, b0, c0, (float4)(mx.x, my.x, mz.x, d.x), (float4)(wx.x, wy.x, wz.x, wd.x),
        (float4)(bz.x, survives.x, 0.0f, 0.0f), live.x);
    geometry_add(map, a1, b1, c1, (float4)(mx.y, my.y, mz.y, d.y), (float4)(wx.y, wy.y, wz.y, wd.y),
        (float4)(bz.y, survives.y, 0.0f, 0.0f), live.y);
    geometry_add(map, a2, b2, c2, (float4)(mx.z, my.z, mz.z, d.z), (float4)(wx.z, wy.z, wz.z, wd.z),
        (float4)(bz.z, survives.z, 0.0f, 0.0f), live.z);
    geometry_add(map, a3, b3, c3, (float4)(mx.w, my.w, mz.w, d.w), (float4)(wx.w, wy.w, wz.w, wd.w),
        (float4)(bz.w, survives.w, 0.0f, 0.0f), live.w);
    return ranks;
}

static inline __global float8 *geometry_clear(__global float8 *restrict maps, const uint map, const uint capacity)
{
    __global float8 *own = maps + 2 * (size_t)capacity * map;
    for (size_t i = 0; i < 2 * (size_t)capacity; ++i) own[i] = 0.0f;
    return own;
}

// the last triangles of a share, fewer than four: the rest of the four repeats one of them with no weight
static inline __attribute__((always_inline)) geometry_ranks geometry_last_triangles(__global const float4 *restrict points,
    __global const uint *restrict triangles, __global float8 *restrict map, const uint2 share, const uint t)
{
    uint index[12];
    float live[4];
    for (uint j = 0; j < 4; ++j) {
        const size_t row = min(t + j, share.y - 1);
        index[3 * j] = triangles[3 * row];
        index[3 * j + 1] = triangles[3 * row + 1];
        index[3 * j + 2] = triangles[3 * row + 2];
        live[j] = t + j < share.y ? 1.0f : 0.0f;
    }
    return geometry_four_triangles(points, map, index, vload4(0, live));
}

static inline __attribute__((always_inline)) geometry_ranks geometry_next_triangles(__global const float4 *restrict points,
    __global const uint *restrict triangles, __global float8 *restrict map, const uint t, const uint triangle_count)
{
    // the addresses ahead stay inside the array: the last ones are asked for again
    __global const uint *ahead = triangles + 3 * (size_t)min(t + AHEAD, triangle_count - 4);
#pragma unroll
    for (uint i = 0; i < 12; ++i) prefetch(points + ahead[i], 1);
    uint index[12];
#pragma unroll
    for (uint i = 0; i < 12; ++i) index[i] = triangles[3 * (size_t)t + i];
    return geometry_four_triangles(points, map, index, (float4)(1.0f));
}

__kernel void quadric_clustering_geometry_accumulate(
    __global const float4 *restrict points,
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
    for (; t + 4 <= share.y; t += 4) geometry_next_triangles(points, triangles, own, t, triangle_count);
    if (t < share.y) geometry_last_triangles(points, triangles, own, share, t);
}

// returns the next free place; four words are written even for a triangle that does not survive
static inline __global uint *geometry_emit4(__global uint *out, const geometry_ranks r)
{
    vstore4((uint4)(r.a.x, r.b.x, r.c.x, 0), 0, out);
    out += 3 & r.distinct.x;
    vstore4((uint4)(r.a.y, r.b.y, r.c.y, 0), 0, out);
    out += 3 & r.distinct.y;
    vstore4((uint4)(r.a.z, r.b.z, r.c.z, 0), 0, out);
    out += 3 & r.distinct.z;
    vstore4((uint4)(r.a.w, r.b.w, r.c.w, 0), 0, out);
    return out + (3 & r.distinct.w);
}

__kernel void quadric_clustering_geometry_fused(
    __global const float4 *restrict points,
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
    for (; t + 4 <= share.y; t += 4)
        out = geometry_emit4(out, geometry_next_triangles(points, triangles, own, t, triangle_count));
    if (t < share.y) out = geometry_emit4(out, geometry_last_triangles(points, triangles, own, share, t));
    piece_counts[map] = (uint)((out - piece) / 3);
}
