// Quadric vertex clustering, set-up: the box, and how large the sums can get.
//
// Source    none
// Work      1-D, one item per chunk of vertices or triangles
// Reads     positions  float[3 * vertex_count]       model units
//           points     float4[vertex_count]          x y z in units of the largest cell edge
//           triangles  uint[3 * triangle_count]
// Writes    boxes      float[48 * chunk_count]       per chunk: eight lower corners x8 y8 z8, then eight upper ones
//           exponents  uint[256 * chunk_count]       per chunk: triangles by the exponent of area / 3
// Needs     common/chunk.cl common/grid.cl

__kernel void quadric_clustering_setup_box(
    __global const float *restrict positions,
    __global float8 *restrict boxes,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    grid_points8 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (uint v = rows.x; v < rows.y; v += 8) {
        const grid_points8 p = grid_load8(positions, v, vertex_count);
        low.x = min(low.x, p.x);
        low.y = min(low.y, p.y);
        low.z = min(low.z, p.z);
        high.x = max(high.x, p.x);
        high.y = max(high.y, p.y);
        high.z = max(high.z, p.z);
    }
    __global float8 *box = boxes + 6 * chunk;
    box[0] = low.x;
    box[1] = low.y;
    box[2] = low.z;
    box[3] = high.x;
    box[4] = high.y;
    box[5] = high.z;
}

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
