// A quadtree over a (2^n + 1)^2 geometry image, its levels packed in one texture of 2^n by 3 * 2^(n-1) texels.
//
// Source    Wang et al., section 3.2, figure 3 (the leaves below, the levels above them from right to left)
// Work      functions only
// Reads     nothing
// Writes    nothing

// with N = 2^n:  texel rows 0 .. N-1        the N * N leaves
//                texel rows N .. N + N/2-1  level d < n in columns 2^d .. 2^(d+1)-1, so the root at column 1
static inline uint quadtree_texel(const uint depth, const uint x, const uint y, const uint n)
{
    return depth == n ? (y << n) + x : (((1u << n) + y) << n) + (1u << depth) + x;
}

// 31 - clz: the depth of the level that owns column x of the upper part
static inline uint quadtree_column_depth(const uint x) { return 31u - clz(x); }

// row-major index of the sample that stands for (i, j): border sides fold about their middle, corners are one point
static inline uint quadtree_sample(const uint i, const uint j, const uint n)
{
    const uint last = 1u << n;
    const bool row = j == 0 || j == last, column = i == 0 || i == last;
    if (row && column) return 0;
    const uint k = row && 2 * i > last ? last - i : i;
    const uint l = column && 2 * j > last ? last - j : j;
    return l * (last + 1) + k;
}

static inline bool quadtree_sample_is_own(const uint i, const uint j, const uint n)
{
    const uint last = 1u << n;
    if (j == 0) return 2 * i <= last;
    if (j == last) return i > 0 && 2 * i <= last;
    return (i > 0 && i < last) || 2 * j <= last;
}

// does the node's diagonal run from its right end below to its left end above? parallel to the octahedron's edges
static inline bool quadtree_anti_diagonal(const uint x, const uint y, const uint size, const uint n)
{
    const uint half_side = 1u << (n - 1);
    return (x + size / 2 >= half_side) == (y + size / 2 >= half_side);
}

// the next corner along an edge of `size` steps, from step `from`: its middle is a corner before any finer sample is
static inline uint quadtree_next_corner(
    __global const uchar *flags, const uint start, const int stride, const uint size, const uint from)
{
    uint step = from ? from & -from : size;
    while (step > 1 && flags[start + (int)(from + step / 2) * stride]) step /= 2;
    return from + step;
}

// left column, low row and size of the node at a texel
static inline uint3 quadtree_node(const uint texel, const uint n)
{
    const uint side = 1u << n, x = texel & (side - 1), y = texel >> n;
    if (y < side) return (uint3)(x, y, 1);
    const uint depth = quadtree_column_depth(x), size = side >> depth;
    return (uint3)((x - (1u << depth)) * size, (y - side) * size, size);
}

// the part of image row `row` that run `run` of `runs` owns: first sample, past-the-last; the last run takes one more
static inline uint2 quadtree_row_run(const uint run, const uint runs, const uint n)
{
    const uint each = (1u << n) / runs;
    return (uint2)(run * each, run + 1 < runs ? (run + 1) * each : (1u << n) + 1);
}

// of those, the ones that stand for themselves: the far half of a border side does not
static inline uint2 quadtree_own_run(uint2 run, const uint row, const uint n)
{
    const uint last = 1u << n;
    if (row == 0 || row == last) run.y = run.y < last / 2 + 1 ? run.y : last / 2 + 1;
    if (row > last / 2) {
        run.x = run.x ? run.x : 1;
        if (row < last) run.y = run.y < last ? run.y : last;
    }
    return run;
}
