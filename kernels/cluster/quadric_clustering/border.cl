// Quadric vertex clustering, geometry stage: border edges hold the cells of their ends.
//
// Source    Lindstrom & Turk 1998 (boundary optimisation), Lindstrom 2000: a plane through the border edge, upright on its
//           triangle, by the square of the edge's length; how heavy is a reconstruction
// Work      1-D, one item per private map, after the triangles, over its share of the edges; `batch` is one item's
// Reads     points  float4[vertex_count]              x y z in units of the largest cell edge, w: bits of the cell's rank
//           edges   uint[3 * edge_count]              from, to, the triangle's third corner
// Writes    maps    float[16 * capacity * map_count]  in place, as share.cl has it
// Needs     cluster/quadric_clustering/border_plane.cl cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py

static inline void border_add(__global const float4 *restrict points, __global const uint *restrict edges,
    __global float *restrict map, const float heaviness, const uint2 share)
{
    for (uint e = share.x; e < share.y; ++e) {
        const uint3 v = vload3(e, edges);
        const border_plane p = border_plane_of(points[v.x].xyz, points[v.y].xyz, points[v.z].xyz, heaviness);
        const float quadric[9] = {p.m.x * p.w.x, p.m.x * p.w.y, p.m.x * p.w.z, p.m.y * p.w.y, p.m.y * p.w.z,
            p.m.z * p.w.z, p.d * p.w.x, p.d * p.w.y, p.d * p.w.z};
        for (uint end = 0; end < 2; ++end) {
            __global float *cell = map + LANES * (size_t)as_uint(points[end ? v.y : v.x].w) + LANE_XX;
            for (uint i = 0; i < 9; ++i) cell[i] += quadric[i];
        }
    }
}

__kernel void quadric_clustering_border_add(
    __global const float4 *restrict points,
    __global const uint *restrict edges,
    __global float *restrict maps,
    const float heaviness,
    const uint map_count,
    const uint capacity,
    const uint edge_count)
{
    const uint map = get_global_id(0);
    if (map >= map_count) return;

    const uint2 share = geometry_share(map, map_count, edge_count);
    border_add(points, edges, maps + LANES * (size_t)capacity * map, heaviness, share);
}

// one batch of one map's share
__kernel void quadric_clustering_border_batch(
    __global const float4 *restrict points,
    __global const uint *restrict edges,
    __global float *restrict maps,
    const float heaviness,
    const uint map,
    const uint capacity,
    const uint edge_count)
{
    if (get_global_id(0) > 0) return;

    border_add(points, edges, maps + LANES * (size_t)capacity * map, heaviness, (uint2)(0, edge_count));
}
