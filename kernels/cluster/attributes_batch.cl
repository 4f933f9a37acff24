// Vertex clustering out of core: what belongs to vertices added to their cells, by the area of the triangles around.
//
// Source    none; sums of a cell are additive over triangles, as its quadric is
// Work      1-D, one item: batches come in order, and so do their triangles
// Reads     points     float4[vertex_count]       x y z in units of the largest cell edge, w: bits of the cell's rank
//           values     float[3 * vertex_count]    a normal, or a colour
//           triangles  uint[3 * triangle_count]
// Writes    sums       float8[capacity]           in place: sums of area times value and of area, what rounding left out

#define LEAST 1e-20f // a triangle without area still has a say where it is alone

__kernel void cluster_attributes_batch_add(
    __global const float4 *restrict points,
    __global const float *restrict values,
    __global const uint *restrict triangles,
    __global float8 *restrict sums,
    const uint triangle_count)
{
    if (get_global_id(0) > 0) return;

    for (uint t = 0; t < triangle_count; ++t) {
        const uint3 v = vload3(t, triangles);
        const float4 p = points[v.x], u = points[v.y] - p, w = points[v.z] - p;
        const float x = u.y * w.z - u.z * w.y, y = u.z * w.x - u.x * w.z, z = u.x * w.y - u.y * w.x;
        const float area = max(sqrt(x * x + y * y + z * z), LEAST);
        const uint corners[3] = {v.x, v.y, v.z};
        for (uint i = 0; i < 3; ++i) {
            __global float8 *cell = sums + as_uint(points[corners[i]].w);
            // Kahan 1965: what a sum loses is added to the next term
            const float8 own = *cell;
            const float4 term = (float4)(vload3(corners[i], values) * area, area) - own.hi, sum = own.lo + term;
            *cell = (float8)(sum, (sum - own.lo) - term);
        }
    }
}
