// Quadtree over a geometry image, vertex stage: the samples in use, moved together in row-major order.
//
// Source    Wang et al., section 3.2 (the merged triangles' vertices pass through the vertex shader)
// Work      1-D, one item per run of ROW_RUN samples of one image row
// Reads     flags           uchar[side * side]       1: in use; side = 2^n + 1
//           image           float[3 * side * side]   positions, row-major, model units
//           image_normals   float[3 * side * side]
//           offsets         uint [run_count]         the run's first output vertex
// Writes    run_counts      uint [run_count]         samples in use that stand for themselves
//           ranks           uint [side * side]       output vertex of such a sample
//           positions       float[3 * capacity]
//           normals         float[3 * capacity]
//           counts          uint [2]                 the first: vertices
// Needs     common/quadtree.cl
// Defines   ROW_RUN   samples of one item

typedef struct {
    uint row, begin, end;
} Run;

// border samples on the far half of their side stand for nothing: their twins do
static inline Run run_samples(const uint run, const uint n)
{
    const uint side = (1u << n) + 1, runs = (side + ROW_RUN - 1) / ROW_RUN;
    Run found;
    found.row = run / runs;
    found.begin = (run - found.row * runs) * ROW_RUN;
    found.end = found.begin + ROW_RUN < side ? found.begin + ROW_RUN : side;
    const uint half_row = side / 2;
    if (found.row == 0 || found.row == side - 1) found.end = found.end < half_row + 1 ? found.end : half_row + 1;
    if (found.row > half_row) {
        found.begin = found.begin ? found.begin : 1;
        if (found.row < side - 1) found.end = found.end < side - 1 ? found.end : side - 1;
    }
    return found;
}

__kernel void quadtree_lod_vertex_count(
    __global const uchar *restrict flags,
    __global uint *restrict run_counts,
    const uint n,
    const uint run_count)
{
    const uint r = get_global_id(0);
    if (r >= run_count) return;

    const Run run = run_samples(r, n);
    const size_t row = (size_t)run.row * ((1u << n) + 1);
    uint count = 0;
    for (uint i = run.begin; i < run.end; ++i) count += flags[row + i];
    run_counts[r] = count;
}

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

    const Run run = run_samples(r, n);
    const size_t row = (size_t)run.row * ((1u << n) + 1);
    uint rank = offsets[r];
    for (uint i = run.begin; i < run.end; ++i) {
        if (!flags[row + i]) continue;
        ranks[row + i] = rank;
        const size_t from = 3 * (row + i), to = 3 * (size_t)rank;
        for (uint k = 0; k < 3; ++k) {
            positions[to + k] = image[from + k];
            normals[to + k] = image_normals[from + k];
        }
        ++rank;
    }
    if (r == run_count - 1) counts[0] = rank;
}
