// Octree, geometry stage: each triangle's quadric added to its corners' finest cells, about each cell's centre.
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12; about the cell's own centre, because the error itself is asked for
//           here and would drown in float32 about the box's corner (reconstruction)
// Work      1-D, one item per private map, each over its share of the triangles, eight at a time
// Reads     points     float4[vertex_count]        x y z in units of the finest cell edge, w: bits of the cell's rank
//           triangles  uint[3 * triangle_count]
// Writes    maps       float[16 * leaf_count * map_count]  per cell: xx xy xz yy yz zz x y | z c 0 0, corner sum x y z, corners
// Needs     common/chunk.cl common/transpose.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

#define AHEAD 24 // triangles between a prefetch and its use
#define INLINE static inline __attribute__((always_inline)) // a call would pass the eight triangles through memory

// the same corner of eight triangles
INLINE fours8 geometry_corner8(__global const float4 *points, const uint *index)
{
    return transpose_fours((float8)(points[index[0]], points[index[12]]), (float8)(points[index[3]], points[index[15]]),
        (float8)(points[index[6]], points[index[18]]), (float8)(points[index[9]], points[index[21]]));
}

// m: normals of twice the area, weight m m^T: a third of the area times n n^T, of which q, yz and zz are the products
INLINE void geometry_add8(__global const float4 *points, __global float16 *map, const uint *index, const uint live,
    const fours8 corner, const fours8 q, const float8 yz, const float8 zz, const float8 mx, const float8 my,
    const float8 mz, const float8 weight, const float4 per_axis, const uint4 cells)
{
    const float8 x = corner.x - convert_float8(octree_steps8(corner.x, per_axis.x, cells.x)) - 0.5f;
    const float8 y = corner.y - convert_float8(octree_steps8(corner.y, per_axis.y, cells.y)) - 0.5f;
    const float8 z = corner.z - convert_float8(octree_steps8(corner.z, per_axis.z, cells.z)) - 0.5f;
    const float8 d = -(mx * x + my * y + mz * z), dw = d * weight;
    const fours8 r = transpose_fours(yz, zz, dw * mx, dw * my);
    const fours8 s = transpose_fours(dw * mz, d * dw, (float8)(0.0f), (float8)(0.0f));
    const fours8 p = transpose_fours(x, y, z, (float8)(1.0f));
#define ADD(j, lane, half)                                                                                             \
    if (live > j) map[as_uint(points[index[3 * j]].w)] += (float16)(q.lane.half, r.lane.half, s.lane.half, p.lane.half)
    ADD(0, x, lo);
    ADD(1, y, lo);
    ADD(2, z, lo);
    ADD(3, w, lo);
    ADD(4, x, hi);
    ADD(5, y, hi);
    ADD(6, z, hi);
    ADD(7, w, hi);
#undef ADD
}

// eight triangles given by 24 indices, of which `live` are added
INLINE void geometry_triangles8(__global const float4 *points, __global float16 *map, const uint *index, const uint live,
    const float4 per_axis, const uint4 cells)
{
    const fours8 a = geometry_corner8(points, index);
    const fours8 b = geometry_corner8(points, index + 1);
    const fours8 c = geometry_corner8(points, index + 2);
    const float8 ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
    const float8 vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    const float8 mx = uy * vz - uz * vy, my = uz * vx - ux * vz, mz = ux * vy - uy * vx;
    const float8 square = mx * mx + my * my + mz * mz;
    // no area, no plane: such a triangle counts at its corners alone
    const float8 weight = square > (float8)(1e-30f) ? 1.0f / (6.0f * sqrt(square)) : (float8)(0.0f);
    const float8 wx = mx * weight, yz = my * mz * weight, zz = mz * mz * weight;
    const fours8 q = transpose_fours(mx * wx, my * wx, mz * wx, my * my * weight);
    geometry_add8(points, map, index, live, a, q, yz, zz, mx, my, mz, weight, per_axis, cells);
    geometry_add8(points, map, index + 1, live, b, q, yz, zz, mx, my, mz, weight, per_axis, cells);
    geometry_add8(points, map, index + 2, live, c, q, yz, zz, mx, my, mz, weight, per_axis, cells);
}

__kernel void octree_geometry_add(
    __global const float4 *points,
    __global const uint *restrict triangles,
    __global float16 *maps,
    const float4 per_axis,
    const uint4 cells,
    const uint map_count,
    const uint leaf_count,
    const uint triangle_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    __global float16 *own = maps + (size_t)leaf_count * map;
    for (uint i = 0; i < leaf_count; ++i) own[i] = 0.0f;
    const uint begin = (ulong)triangle_count * map / map_count, end = (ulong)triangle_count * (map + 1) / map_count;
    uint t = begin;
    for (; t + 8 <= end; t += 8) {
        // the addresses ahead stay inside the array: the last ones are asked for again
        __global const uint *ahead = triangles + 3 * (size_t)min(t + AHEAD, triangle_count - 8);
        uint index[24];
#pragma unroll
        for (uint i = 0; i < 24; ++i) prefetch(points + ahead[i], 1);
#pragma unroll
        for (uint i = 0; i < 24; ++i) index[i] = triangles[3 * (size_t)t + i];
        geometry_triangles8(points, own, index, 8, per_axis, cells);
    }
    if (t == end) return;
    uint index[24];
    for (uint j = 0; j < 8; ++j) {
        const size_t row = min(t + j, end - 1);
        for (uint k = 0; k < 3; ++k) index[3 * j + k] = triangles[3 * row + k];
    }
    geometry_triangles8(points, own, index, end - t, per_axis, cells);
}
