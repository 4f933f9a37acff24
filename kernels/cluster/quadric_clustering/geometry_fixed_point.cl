// Quadric vertex clustering, geometry stage for devices with many units: quadrics added by 64-bit integer atomics.
//
// Source    DeCoro & Tatarchuk 2007, slide 12 (additive blending); fixed point, so that the order of arrival is of no effect
// Work      1-D, one item per triangle; integer sums come out the same in any order
// Reads     points     float4[vertex_count]         x y z in units of the largest cell edge, w: bits of the cell's rank
//           triangles  uint[3 * triangle_count]
// Writes    sums       long[14 * capacity]          per cell: xx xy xz yy yz zz x y z, corner sum x y z, corners, surviving corners
// Needs     cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py

#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

__kernel void quadric_clustering_geometry_fixed_point(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global long *restrict sums,
    const float4 scale, // of A, of b, of positions: powers of two
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count) return;

    const uint3 v = vload3(t, triangles);
    const float4 corners[3] = {points[v.x], points[v.y], points[v.z]};
    const float3 a = corners[0].xyz;
    const float3 m = cross(corners[1].xyz - a, corners[2].xyz - a);
    const float square = dot(m, m);
    // no area, no plane: such a triangle counts at its corners alone
    const float3 w = square > 1e-30f ? m / (6.0f * sqrt(square)) : (float3)(0.0f);
    const float d = -dot(m, a);
    const uint3 c = (uint3)(as_uint(corners[0].w), as_uint(corners[1].w), as_uint(corners[2].w));
    const long survives = c.x != c.y && c.y != c.z && c.z != c.x;

    const long quadric[9] = {
        (long)(m.x * w.x * scale.x), (long)(m.x * w.y * scale.x), (long)(m.x * w.z * scale.x),
        (long)(m.y * w.y * scale.x), (long)(m.y * w.z * scale.x), (long)(m.z * w.z * scale.x),
        (long)(d * w.x * scale.y), (long)(d * w.y * scale.y), (long)(d * w.z * scale.y)};
    for (uint corner = 0; corner < 3; ++corner) {
        const float4 p = corners[corner];
        __global long *sum = sums + WORDS * (size_t)as_uint(p.w);
        for (uint i = 0; i < 9; ++i) atom_add(sum + WORD_XX + i, quadric[i]);
        atom_add(sum + WORD_CORNER_X, (long)(p.x * scale.z));
        atom_add(sum + WORD_CORNER_X + 1, (long)(p.y * scale.z));
        atom_add(sum + WORD_CORNER_X + 2, (long)(p.z * scale.z));
        atom_add(sum + WORD_CORNERS, 1l);
        atom_add(sum + WORD_SURVIVING, survives);
    }
}
