// Quadric vertex clustering, set-up: how large the sums can get.
//
// Source    none
// Work      1-D, one item per chunk of triangles
// Reads     points     float4[vertex_count]          x y z in units of the largest cell edge
//           triangles  uint[3 * triangle_count]
// Writes    exponents  uint[256 * chunk_count]       per chunk: triangles by the exponent of area / 3
// Needs     common/chunk.cl
// Plain     cluster/quadric_clustering/reference.py

__kernel void quadric_clustering_setup_exponents(
    __global const float4 *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict exponents,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    __global uint *own = exponents + 256 * chunk;
    for (uint e = 0; e < 256; ++e) own[e] = 0;
    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const float3 a = points[v.x].xyz;
        const float3 m = cross(points[v.y].xyz - a, points[v.z].xyz - a);
        own[(as_uint(length(m) * (1.0f / 6.0f)) >> 23) & 255u] += 1;
    }
}
