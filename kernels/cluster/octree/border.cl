// Octree, geometry stage: border edges hold the finest cells of their ends.
//
// Source    Lindstrom & Turk 1998 (boundary optimisation), as in quadric_clustering/border.cl
// Work      1-D, one item per private map, after the triangles, over its share of the edges
// Reads     points  float4[vertex_count]                x y z in units of the finest cell edge, w: bits of the cell's rank
//           edges   uint[3 * edge_count]                from, to, the triangle's third corner
// Writes    maps    float[16 * leaf_count * map_count]  in place, as geometry.cl has it
// Needs     cluster/quadric_clustering/border_plane.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

__kernel void octree_border_add(
    __global const float4 *restrict points,
    __global const uint *restrict edges,
    __global float *restrict maps,
    const float4 per_axis,
    const uint4 cells,
    const float heaviness,
    const uint map_count,
    const uint leaf_count,
    const uint edge_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    __global float *own = maps + LANES * (size_t)leaf_count * map;
    const uint begin = (ulong)edge_count * map / map_count, end = (ulong)edge_count * (map + 1) / map_count;
    for (uint e = begin; e < end; ++e) {
        const uint3 v = vload3(e, edges);
        for (uint k = 0; k < 2; ++k) {
            // about the cell's centre
            const float4 at = points[k ? v.y : v.x];
            const int3 most = {(int)cells.x - 1, (int)cells.y - 1, (int)cells.z - 1};
            const int3 cell = clamp(convert_int3(at.xyz * per_axis.xyz), (int3)0, most);
            const float3 centre = convert_float3(cell) + 0.5f;
            const border_plane p = border_plane_of(points[v.x].xyz - centre, points[v.y].xyz - centre,
                points[v.z].xyz - centre, heaviness);
            const float3 m = p.m, w = p.w;
            const float square = m.x * m.x + m.y * m.y + m.z * m.z, mw = m.x * w.x + m.y * w.y + m.z * w.z;
            const float quadric[10] = {m.x * w.x, m.x * w.y, m.x * w.z, m.y * w.y, m.y * w.z, m.z * w.z, p.d * w.x, p.d * w.y,
                p.d * w.z, p.d * p.d * mw / max(square, 1e-30f)};
            for (uint i = 0; i < 10; ++i) own[LANES * (size_t)as_uint(at.w) + LANE_XX + i] += quadric[i];
        }
    }
}
