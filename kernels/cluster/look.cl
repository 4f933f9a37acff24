// Vertex clustering, set-up: the box of all positions, and whether edges have a triangle on one side only, in one launch.
//
// Source    none
// Work      1-D, one item per chunk of vertices and of triangles
// Reads     positions   float[3 * vertex_count]   model units
//           triangles   uint[3 * triangle_count]
// Writes    boxes       float[48 * chunk_count]   as in cluster/box.cl
//           sums        uint[2 * chunk_count]     as in cluster/borders.cl
// Needs     cluster/box.cl cluster/borders.cl

__kernel void cluster_look(
    __global const float *restrict positions,
    __global const uint *restrict triangles,
    __global float8 *restrict boxes,
    __global uint *restrict sums,
    const uint vertex_count,
    const uint triangle_count,
    const uint chunk_count)
{
    if (get_global_id(0) >= chunk_count) return;
    cluster_box(positions, boxes, vertex_count, chunk_count);
    cluster_borders_sum(triangles, sums, triangle_count, chunk_count);
}
