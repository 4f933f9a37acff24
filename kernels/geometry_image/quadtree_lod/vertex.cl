// Quadtree over a geometry image, vertex stage: the samples in use, moved together in row-major order.
//
// Source    Wang et al., section 3.2 (the merged triangles' vertices pass through the vertex shader); fitted vertices are
//           an addition
// Work      1-D, one item per run of samples of one image row, 2^n / RUN runs a row
// Reads     flags           uchar[side * side]       1: in use; side = 2^n + 1
//           image           float[3 * side * side]   positions, row-major, model units
//           image_normals   float[3 * side * side]
//           states          uchar[texel_count]       0 too coarse, 1 nothing to draw, 2 drawn
//           levels          float[3 * level_samples] where vertices of depth 0, 1, ... n - 1 lie, one after the other
//           offsets         uint [run_count]         the run's first output vertex
// Writes    ranks           uint [side * side]       output vertex of a sample in use, seam duplicates alike
//           positions       float[3 * capacity]
//           normals         float[3 * capacity]
//           counts          uint [2]                 the first: vertices
// Needs     common/quadtree.cl
// Plain     geometry_image/quadtree_lod/reference.py
// Defines   RUN   1, or a power of two from 16 to 2^n

// the leaf cell at (x, y), over the fold where that is outside the image
static inline uint2 folded_cell(int x, int y, const int last)
{
    if (x < 0 || x >= last) {
        x = x < 0 ? 0 : last - 1;
        y = last - 1 - y;
    }
    if (y < 0 || y >= last) {
        y = y < 0 ? 0 : last - 1;
        x = last - 1 - x;
    }
    return (uint2)(x, y);
}

// the depth of the finest drawn node, or part of a fan, that has sample (i, j) as a corner
static inline uint vertex_depth(__global const uchar *restrict states, const uint i, const uint j, const uint n)
{
    const int last = 1 << n;
    const uint both = i | j | (uint)last;
    uint depth = n - (31 - clz(both & -both));
    if (depth == n) return n;
    depth = depth ? depth : 1;
    const uint2 a = folded_cell((int)i - 1, (int)j - 1, last), b = folded_cell((int)i, (int)j - 1, last);
    const uint2 c = folded_cell((int)i - 1, (int)j, last), d = folded_cell((int)i, (int)j, last);
    for (; depth < n; ++depth) {
        const uint shift = n - depth;
        if (states[quadtree_texel(depth, a.x >> shift, a.y >> shift, n)] != 0
            && states[quadtree_texel(depth, b.x >> shift, b.y >> shift, n)] != 0
            && states[quadtree_texel(depth, c.x >> shift, c.y >> shift, n)] != 0
            && states[quadtree_texel(depth, d.x >> shift, d.y >> shift, n)] != 0)
            break;
    }
    return depth;
}

// samples of all levels above `depth`: the sum of (2^k + 1)^2
static inline uint level_start(const uint depth)
{
    return ((1u << (2 * depth)) - 1) / 3 + 2 * ((1u << depth) - 1) + depth;
}

__kernel void quadtree_lod_vertex(
    __global const uchar *restrict flags,
    __global const float *restrict image,
    __global const float *restrict image_normals,
    __global const uchar *restrict states,
    __global const float *restrict levels,
    __global const uint *restrict offsets,
    __global uint *restrict ranks,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict counts,
    const uint fitted, // 0: every vertex lies on its sample
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
        const uint depth = fitted ? vertex_depth(states, i, j, n) : n;
        const uint shift = n - depth;
        __global const float *place = depth == n
            ? image + from
            : levels + 3 * (size_t)(level_start(depth) + (j >> shift) * ((1u << depth) + 1) + (i >> shift));
        for (uint k = 0; k < 3; ++k) positions[to + k] = place[k];
        for (uint k = 0; k < 3; ++k) normals[to + k] = image_normals[from + k];
        ++rank;
    }
    // seam duplicates are written by the sample that stands for them, and by no one else
    if (j == 0 || j == last)
        for (uint i = own.x; i < own.y; ++i) ranks[row + last - i] = ranks[row + i];
    if (own.x == 0 && own.y > 0) ranks[(size_t)(last - j) * side] = ranks[row];
    if (own.y == side) ranks[(size_t)(last - j) * side + last] = ranks[row + last];
    if (j == 0 && own.x == 0) ranks[(size_t)last * side + last] = ranks[0];
    if (r == run_count - 1) counts[0] = rank;
}
