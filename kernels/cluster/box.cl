// Vertex clustering, set-up: the box of all positions.
//
// Source    none
// Work      1-D, one item per chunk of vertices, eight at a time
// Reads     positions  float[3 * vertex_count]       model units
// Writes    boxes      float[48 * chunk_count]       per chunk: eight lower corners x8 y8 z8, then eight upper ones
// Needs     common/chunk.cl common/grid.cl

__kernel void cluster_box(
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
