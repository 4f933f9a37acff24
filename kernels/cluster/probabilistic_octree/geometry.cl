// Probabilistic octree, geometry stage: each corner's quadric added to the slots of the nodes above it.
//
// Source    DeCoro & Tatarchuk 2007, slides 11-12 and 30-33: additive blending of quadrics, blending of (key, -key) by the
//           larger; fixed point, so that the order of arrival is of no effect
// Work      1-D, one item per chunk of vertices, or per triangle; integer sums and maxima come out the same in any order
// Reads     positions  float[3 * vertex_count]     model units
//           triangles  uint[3 * triangle_count]
// Writes    points     float[4 * vertex_count]     x y z in units of the finest cell edge, w: bits of the finest cell's code
//           sums       long[14 * slot_count]       quadric, corner sum, corners, each in units of the node's own edge
//           keys       int[2 * slot_count]         largest key, largest negative key; the least integer before
// Needs     common/chunk.cl common/grid.cl cluster/octree/cell.cl cluster/probabilistic_octree/key.cl
// Plain     cluster/probabilistic_octree/reference.py

#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

__kernel void probabilistic_octree_geometry_place(
    __global const float *restrict positions,
    __global float *restrict points,
    const float4 low,
    const float4 per_axis, // w: units per model unit
    const uint4 cells,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; v += 8) {
        const grid_points8 q = grid_scale8(grid_load8(positions, v, vertex_count), low, per_axis.w);
        grid_store8(points, q, as_float8(octree_code8(q, per_axis, cells)), v, vertex_count);
    }
}

__kernel void probabilistic_octree_geometry_add(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global long *restrict sums,
    volatile __global int *restrict keys,
    const float2 scale, // of the quadrics, of the corners: powers of two
    const uint finest,
    const uint randomised,
    const uint seed,
    const uint slot_count,
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count) return;

    const uint3 v = vload3(t, triangles);
    const float4 corners[3] = {points[v.x], points[v.y], points[v.z]};
    const float3 a = corners[0].xyz, m = cross(corners[1].xyz - a, corners[2].xyz - a);
    const float square = dot(m, m);
    // no area, no plane: such a triangle counts at its corners alone
    const float weight = square > 1e-30f ? 1.0f / (6.0f * sqrt(square)) : 0.0f;
    for (uint k = 0; k < 3; ++k) {
        const uint code = as_uint(corners[k].w);
        for (uint up = 0; up <= finest; ++up) {
            if (randomised && !key_written(3 * t + k, up, seed)) continue;
            const float edge = (float)(1u << up), share = randomised ? edge : 1.0f;
            const uint own = code >> (3 * up);
            const float3 cell = {(float)octree_gather(own), (float)octree_gather(own >> 1), (float)octree_gather(own >> 2)};
            const float3 p = corners[k].xyz / edge - cell - 0.5f;
            const float d = -dot(m, p);
            const float3 w = m * weight * share * scale.x;
            const int key = key_of(code, finest - up, finest);
            const uint slot = key_slot(key, slot_count, seed);
            const long added[WORDS] = {(long)(m.x * w.x), (long)(m.x * w.y), (long)(m.x * w.z), (long)(m.y * w.y),
                (long)(m.y * w.z), (long)(m.z * w.z), (long)(d * w.x), (long)(d * w.y), (long)(d * w.z),
                (long)(d * d * weight * share * scale.x), (long)(p.x * share * scale.y), (long)(p.y * share * scale.y),
                (long)(p.z * share * scale.y), (long)share};
            for (uint i = 0; i < WORDS; ++i) atom_add(sums + WORDS * (size_t)slot + i, added[i]);
            atomic_max(keys + 2 * (size_t)slot, key);
            atomic_max(keys + 2 * (size_t)slot + 1, -key);
        }
    }
}
