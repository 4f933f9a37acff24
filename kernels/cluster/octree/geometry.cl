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

// the same corner of eight triangles
static inline fours8 geometry_corner8(__global const float4 *restrict points, const uint *index)
{
    return transpose_fours((float8)(points[index[0]], points[index[12]]), (float8)(points[index[3]], points[index[15]]),
        (float8)(points[index[6]], points[index[18]]), (float8)(points[index[9]], points[index[21]]));
}

__kernel void octree_geometry_add(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global float16 *restrict maps,
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
    for (uint t = begin; t < end; t += 8) {
        uint index[24];
        for (uint j = 0; j < 8; ++j) {
            const size_t row = min(t + j, end - 1);
            for (uint k = 0; k < 3; ++k) index[3 * j + k] = triangles[3 * row + k];
        }
        const fours8 corner[3] = {
            geometry_corner8(points, index), geometry_corner8(points, index + 1), geometry_corner8(points, index + 2)};
        const float8 ux = corner[1].x - corner[0].x, uy = corner[1].y - corner[0].y, uz = corner[1].z - corner[0].z;
        const float8 vx = corner[2].x - corner[0].x, vy = corner[2].y - corner[0].y, vz = corner[2].z - corner[0].z;
        const float8 mx = uy * vz - uz * vy, my = uz * vx - ux * vz, mz = ux * vy - uy * vx;
        const float8 square = mx * mx + my * my + mz * mz;
        // weight m m^T = area / 3 n n^T; no area, no plane: such a triangle counts at its corners alone
        const float8 weight = square > (float8)(1e-30f) ? 1.0f / (6.0f * sqrt(square)) : (float8)(0.0f);
        const float8 wx = mx * weight, wy = my * weight, wz = mz * weight;
        const fours8 q = transpose_fours(mx * wx, mx * wy, mx * wz, my * wy);
        const float8 yz = my * wz, zz = mz * wz;
        const uint live = min(end - t, 8u);
        for (uint k = 0; k < 3; ++k) {
            const float8 x = corner[k].x - convert_float8(octree_steps8(corner[k].x, per_axis.x, cells.x)) - 0.5f;
            const float8 y = corner[k].y - convert_float8(octree_steps8(corner[k].y, per_axis.y, cells.y)) - 0.5f;
            const float8 z = corner[k].z - convert_float8(octree_steps8(corner[k].z, per_axis.z, cells.z)) - 0.5f;
            const float8 d = -(mx * x + my * y + mz * z);
            const fours8 r = transpose_fours(yz, zz, d * wx, d * wy);
            const fours8 s = transpose_fours(d * wz, d * d * weight, (float8)(0.0f), (float8)(0.0f));
            const fours8 p = transpose_fours(x, y, z, (float8)(1.0f));
#define ADD(j, lane, half)                                                                                             \
    if (live > j)                                                                                                      \
        own[as_uint(points[index[3 * j + k]].w)] += (float16)(q.lane.half, r.lane.half, s.lane.half, p.lane.half)
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
    }
}
