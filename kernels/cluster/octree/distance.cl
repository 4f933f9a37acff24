// Octree, rule "maximum": how far is a node's representative from the farthest plane of its triangles?
//
// Source    reconstruction; DeCoro & Tatarchuk 2007, slide 31, leave the error open
// Work      1-D, one item per chunk of triangles
// Reads     points     float4[vertex_count]        x y z in units of the finest cell edge, w: bits of the cell's rank
//           triangles  uint[3 * triangle_count]
//           parents    uint[]                      the root's is itself
//           solved     float4[]                    representatives in those units
// Writes    errors     uint[]                      bits of distances, which order as the floats do; the maximum comes out
//                                                  the same in any order
// Needs     common/chunk.cl
// Plain     cluster/octree/reference.py

__kernel void octree_distance_add(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global const uint *restrict parents,
    __global const float4 *restrict solved,
    volatile __global uint *restrict errors,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const float4 corners[3] = {points[v.x], points[v.y], points[v.z]};
        const float3 a = corners[0].xyz, m = cross(corners[1].xyz - a, corners[2].xyz - a);
        const float square = dot(m, m);
        if (!(square > 1e-30f)) continue;
        const float3 normal = m / sqrt(square);
        for (uint k = 0; k < 3; ++k) {
            for (uint node = as_uint(corners[k].w), last = ~node; node != last; node = parents[node]) {
                const uint far = as_uint(fabs(dot(normal, solved[node].xyz - a)));
                if (far > errors[node]) atomic_max(errors + node, far);
                last = node;
            }
        }
    }
}
