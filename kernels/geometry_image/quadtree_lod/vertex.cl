// Quadtree over a geometry image, vertex stage: the samples in use, moved together in row-major order.
//
// Source    Wang et al., section 3.2 (the merged triangles' vertices pass through the vertex shader)
// Work      1-D, one item per run of samples of one image row, 2^n / RUN runs a row
// Reads     flags           uchar[side * side]       1: in use; side = 2^n + 1
//           image           float[3 * side * side]   positions, row-major, model units
//           image_normals   float[3 * side * side]
//           offsets         uint [run_count]         the run's first output vertex
// Writes    ranks           uint [side * side]       output vertex of a sample in use, twins alike
//           positions       float[3 * capacity]
//           normals         float[3 * capacity]
//           counts          uint [2]                 the first: vertices
// Needs     common/quadtree.cl
// Defines   RUN   1, or a power of two from 16 to 2^n

__kernel void quadtree_lod_vertex(
    __global const uchar *restrict flags,
    __global const float *restrict image,
    __global const float *restrict image_normals,
    __global const uint *restrict offsets,
    __global uint *restrict ranks,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict counts,
    const uint n,
    const uint run_count)
{
    const uint r = get_global_id(0);
    if (r >= run_count) return;

    const uint last = 1u << n, side = last + 1, runs = last / RUN, j = r / runs;
    const uint2 own = quadtree_own_run(quadtree_row_run(r - j * runs, runs, n), j, n);
    const size_t row = (size_t)j * side;
    uint rank = offsets[r];
    for (uint i = own.x; i < own.y; ++i) {
        if (!flags[row + i]) continue;
        ranks[row + i] = rank;
        const size_t from = 3 * (row + i), to = 3 * (size_t)rank;
        for (uint k = 0; k < 3; ++k) positions[to + k] = image[from + k];
        for (uint k = 0; k < 3; ++k) normals[to + k] = image_normals[from + k];
        ++rank;
    }
    // twins are written by the sample that stands for them, and by no one else
    if (j == 0 || j == last)
        for (uint i = own.x; i < own.y; ++i) ranks[row + last - i] = ranks[row + i];
    if (own.x == 0 && own.y > 0) ranks[(size_t)(last - j) * side] = ranks[row];
    if (own.y == side) ranks[(size_t)(last - j) * side + last] = ranks[row + last];
    if (j == 0 && own.x == 0) ranks[(size_t)last * side + last] = ranks[0];
    if (r == run_count - 1) counts[0] = rank;
}
