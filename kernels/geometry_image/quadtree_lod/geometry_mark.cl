// Quadtree over a geometry image, geometry stage: which samples are vertices of the drawn nodes' triangles?
//
// Source    Wang et al., section 3.2, figure 4 (merged where no neighbour needs the vertex); a reconstruction
// Work      1-D, one item per run of samples of one image row, 2^n / RUN runs a row
// Reads     states      uchar[texel_count]   0 too coarse, 1 nothing to draw, 2 drawn
// Writes    flags       uchar[side * side]   1: a drawn node's corner, or the centre of a fan; side = 2^n + 1, seam duplicates alike
//           run_counts  uint [run_count]     flagged samples of the run that stand for themselves
// Needs     common/quadtree.cl
// Plain     geometry_image/quadtree_lod/reference.py
// Defines   RUN   1, or a power of two from 16 to 2^n

// gathered, so that nothing is cleared and no two items write to one place: a sample is a corner where a node that has
// it inside, or in the middle of an edge, is too coarse; the centre of a drawn node is used where a neighbour is

typedef struct {
    __global const uchar *states; // of one level, row 0
    uint across, n;
} Level;

static inline Level level_at(__global const uchar *states, const uint depth, const uint n)
{
    const Level level = {states + ((size_t)(1u << n) << n) + (1u << depth), 1u << depth, n};
    return level;
}

static inline uchar node_state(const Level level, const uint x, const uint y)
{
    return level.states[((size_t)y << level.n) + x];
}

// the nodes across the four edges; the image's border folds about the middle of each side
static inline uchar state_left(const Level level, const uint x, const uint y)
{
    return x ? node_state(level, x - 1, y) : node_state(level, 0, level.across - 1 - y);
}
static inline uchar state_right(const Level level, const uint x, const uint y)
{
    return x + 1 < level.across ? node_state(level, x + 1, y) : node_state(level, x, level.across - 1 - y);
}
static inline uchar state_below(const Level level, const uint x, const uint y)
{
    return y ? node_state(level, x, y - 1) : node_state(level, level.across - 1 - x, 0);
}
static inline uchar state_above(const Level level, const uint x, const uint y)
{
    return y + 1 < level.across ? node_state(level, x, y + 1) : node_state(level, level.across - 1 - x, y);
}

static inline uchar flag_at(__global const uchar *states, const uint i, const uint j, const uint n)
{
    const uint last = 1u << n, both = i | j;
    if ((both & (last / 2 - 1)) == 0) return 1; // corners of the four coarsest nodes
    // the largest node with this sample inside or in the middle of an edge is twice the lowest set bit wide
    const uint shift = 32 - clz(both & -both);
    const Level level = level_at(states, n - shift, n);
    const uint far = level.across - 1, x = i >> shift < far ? i >> shift : far, y = j >> shift < far ? j >> shift : far;
    const bool inside_row = i & (1u << (shift - 1)), inside_column = j & (1u << (shift - 1));
    const uchar own = node_state(level, x, y);
    if (own == 0) return 1;
    if (inside_row && inside_column)
        return own == 2
            && (state_left(level, x, y) == 0 || state_right(level, x, y) == 0 || state_below(level, x, y) == 0
                || state_above(level, x, y) == 0);
    if (inside_row) return (j == last ? state_above(level, x, y) : state_below(level, x, y)) == 0;
    return (i == last ? state_right(level, x, y) : state_left(level, x, y)) == 0;
}

#if RUN >= 16
static inline uchar8 eight_states(const Level level, const uint x, const uint y)
{
    return vload8(0, level.states + ((size_t)y << level.n) + x);
}
static inline uchar8 eight_below(const Level level, const uint x, const uint y)
{
    return y ? eight_states(level, x, y - 1) : eight_states(level, level.across - 8 - x, 0).s76543210;
}
static inline uchar8 eight_above(const Level level, const uint x, const uint y)
{
    return y + 1 < level.across ? eight_states(level, x, y + 1) : eight_states(level, level.across - 8 - x, y).s76543210;
}

// 1 where the state is 0, of states up to 2, by arithmetic: no vector of truth values has to become one of bytes
static inline uchar8 eight_coarse(const uchar8 states)
{
    return ((states | (states >> (uchar8)1)) & (uchar8)1) ^ (uchar8)1;
}

// samples i to i + 15 of row j, i a multiple of 16, from the eight smallest merged nodes beside them
static inline uchar16 flags_at(__global const uchar *states, const uint i, const uint j, const uint n)
{
    const Level level = level_at(states, n - 1, n);
    const uint x = i / 2;
    if (j & 1) { // the nodes' middle row: edges and centres
        const uint y = j / 2;
        const uchar8 own = eight_states(level, x, y);
        uchar8 left = own.s00123456, right = own.s12345677;
        left.s0 = state_left(level, x, y);
        right.s7 = state_right(level, x + 7, y);
        const uchar8 coarse = eight_coarse(own), beside = eight_coarse(left);
        const uchar8 any = beside | eight_coarse(right) | eight_coarse(eight_below(level, x, y))
                         | eight_coarse(eight_above(level, x, y));
        return (uchar16)(coarse | beside, coarse | ((own >> (uchar8)1) & any)).s08192a3b4c5d6e7f;
    }
    const bool top = j >> n != 0; // the row between nodes: edges, and samples of the next coarser image
    const uint y = top ? level.across - 1 : j / 2;
    const uchar8 coarse = eight_coarse(eight_states(level, x, y))
                        | eight_coarse(top ? eight_above(level, x, y) : eight_below(level, x, y));
    uchar8 coarser;
    coarser.s0 = flag_at(states, i, j, n);
    coarser.s1 = flag_at(states, i + 2, j, n);
    coarser.s2 = flag_at(states, i + 4, j, n);
    coarser.s3 = flag_at(states, i + 6, j, n);
    coarser.s4 = flag_at(states, i + 8, j, n);
    coarser.s5 = flag_at(states, i + 10, j, n);
    coarser.s6 = flag_at(states, i + 12, j, n);
    coarser.s7 = flag_at(states, i + 14, j, n);
    return (uchar16)(coarser, coarse).s08192a3b4c5d6e7f;
}
#endif

__kernel void quadtree_lod_geometry_mark(
    __global const uchar *restrict states,
    __global uchar *restrict flags,
    __global uint *restrict run_counts,
    const uint n,
    const uint run_count)
{
    const uint r = get_global_id(0);
    if (r >= run_count) return;

    const uint runs = (1u << n) / RUN, j = r / runs;
    const uint2 run = quadtree_row_run(r - j * runs, runs, n), own = quadtree_own_run(run, j, n);
    __global uchar *row = flags + (size_t)j * ((1u << n) + 1);
    uint i = run.x;
#if RUN >= 16
    for (; i + 16 <= run.y; i += 16) vstore16(flags_at(states, i, j, n), 0, row + i);
#endif
    for (; i < run.y; ++i) row[i] = flag_at(states, i, j, n);
    uint count = 0;
    for (i = own.x; i < own.y; ++i) count += row[i];
    run_counts[r] = count;
}
