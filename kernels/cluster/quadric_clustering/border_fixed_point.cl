// Quadric vertex clustering, geometry stage for devices with many units: border edges added by 64-bit integer atomics.
//
// Source    as border.cl; fixed point, so that the order of arrival is of no effect
// Work      1-D, one item per border edge
// Reads     points  float4[vertex_count]   x y z in units of the largest cell edge, w: bits of the cell's rank
//           edges   uint[3 * edge_count]   from, to, the triangle's third corner
// Writes    sums    long[14 * capacity]    in place, as share.cl has it
// Needs     cluster/quadric_clustering/border_plane.cl cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py

#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

__kernel void quadric_clustering_border_fixed_point(
    __global const float4 *restrict points,
    __global const uint *restrict edges,
    __global long *restrict sums,
    const float4 scale, // of A, of b, of positions: powers of two
    const float heaviness,
    const uint edge_count)
{
    const uint e = get_global_id(0);
    if (e >= edge_count) return;

    const uint3 v = vload3(e, edges);
    const float4 a = points[v.x], b = points[v.y];
    const border_plane p = border_plane_of(a.xyz, b.xyz, points[v.z].xyz, heaviness);
    const long quadric[9] = {
        (long)(p.m.x * p.w.x * scale.x), (long)(p.m.x * p.w.y * scale.x), (long)(p.m.x * p.w.z * scale.x),
        (long)(p.m.y * p.w.y * scale.x), (long)(p.m.y * p.w.z * scale.x), (long)(p.m.z * p.w.z * scale.x),
        (long)(p.d * p.w.x * scale.y), (long)(p.d * p.w.y * scale.y), (long)(p.d * p.w.z * scale.y)};
    for (uint end = 0; end < 2; ++end) {
        __global long *sum = sums + WORDS * (size_t)as_uint(end ? b.w : a.w) + WORD_XX;
        for (uint i = 0; i < 9; ++i) atom_add(sum + i, quadric[i]);
    }
}
