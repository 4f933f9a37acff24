// Quadtree over a geometry image, geometry stage: the drawn nodes' triangles, merged, without cracks.
//
// Source    Wang et al., section 3.2, figure 4 and the text below it (a fan per merged node); the fan over the node's
//           perimeter, which keeps every corner of a finer neighbour, is a reconstruction
// Work      mark: 1-D, one item per sample; count, emit: 1-D, one item per run of RUN packed texels
// Reads     states      uchar[texel_count]        0 too coarse, 1 nothing to draw, 2 drawn
//           ranks       uint [side * side]        output vertex of a sample that stands for itself, side = 2^n + 1
//           offsets     uint [run_count]          the run's first triangle
// Writes    flags       uchar[side * side]        1: a drawn node's corner, or the centre of a fan; twins alike
//           run_counts  uint [run_count]          triangles of a run
//           triangles   uint [3 * 2 * 4^n]        output vertices, counter-clockwise from outside
//           counts      uint [2]                  the second: triangles
// Needs     common/quadtree.cl
// Defines   RUN   texels of one item, a power of two

// a sample is a corner where a node that has it inside, or on an edge, is too coarse: no scattered writes, no atomics
__kernel void quadtree_lod_geometry_mark(
    __global const uchar *restrict states,
    __global uchar *restrict flags,
    const uint n,
    const uint sample_count)
{
    const uint at = get_global_id(0);
    if (at >= sample_count) return;

    const uint last = 1u << n, j = at / (last + 1), i = at - j * (last + 1);
    if (((i | j) & (last / 2 - 1)) == 0) { // corners of the four coarsest nodes
        flags[at] = 1;
        return;
    }
    // the largest node with this sample inside or in the middle of an edge is twice the lowest set bit wide
    const uint half_size = (i | j) & -(i | j), size = 2 * half_size, across = last / size;
    const uint shift = 31 - clz(size), x = i >> shift, y = j >> shift;
    __global const uchar *level = states + ((size_t)last << n) + across;
    uint x_one = x, y_one = y, x_two = x, y_two = y;
    if (!(j & half_size)) { // the middle of an edge along the row: the nodes below and above, or the fold's
        if (j == 0 || j == last) {
            y_one = y_two = j ? across - 1 : 0;
            x_two = (last - i) >> shift;
        } else
            y_two = y - 1;
    } else if (!(i & half_size)) {
        if (i == 0 || i == last) {
            x_one = x_two = i ? across - 1 : 0;
            y_two = (last - j) >> shift;
        } else
            x_two = x - 1;
    }
    flags[at] = level[((size_t)y_one << n) + x_one] == 0 || level[((size_t)y_two << n) + x_two] == 0;
}

// the next corner along an edge of `size` steps, from step `from`: its middle is marked before any finer sample is
static inline uint next_corner(
    __global const uchar *flags, const uint start, const int stride, const uint size, const uint from)
{
    uint step = from ? from & -from : size;
    while (step > 1 && flags[start + (int)(from + step / 2) * stride]) step /= 2;
    return from + step;
}

static inline uint edge_corners(__global const uchar *flags, const uint start, const int stride, const uint size)
{
    uint count = 0;
    for (uint at = next_corner(flags, start, stride, size, 0); at < size; ++count)
        at = next_corner(flags, start, stride, size, at);
    return count;
}

// left column, low row and size of the node at a texel; columns of the upper part know their depth
static inline uint3 node_of(const uint texel, const uint n)
{
    const uint side = 1u << n, x = texel & (side - 1), y = texel >> n;
    if (y < side) return (uint3)(x, y, 1);
    const uint depth = quadtree_column_depth(x), size = side >> depth;
    return (uint3)((x - (1u << depth)) * size, (y - side) * size, size);
}

static inline uint ring_corners(__global const uchar *flags, const uint3 node, const uint n)
{
    const int row = (1 << n) + 1;
    const uint size = node.z, low = node.y * row + node.x;
    return 4 + edge_corners(flags, low, 1, size) + edge_corners(flags, low + size, row, size)
         + edge_corners(flags, low + size * row + size, -1, size) + edge_corners(flags, low + size * row, -row, size);
}

__kernel void quadtree_lod_geometry_count(
    __global const uchar *restrict states,
    __global uchar *flags, // a fan's centre is written here, which no other node looks at
    __global uint *restrict run_counts,
    const uint n,
    const uint run_count)
{
    const uint run = get_global_id(0);
    if (run >= run_count) return;

    const uint first = run * RUN;
    uint count = 0;
    if (first >> (2 * n) == 0) {
        for (uint texel = first; texel < first + RUN; ++texel) count += states[texel] == 2 ? 2 : 0;
    } else {
        for (uint texel = first; texel < first + RUN; ++texel) {
            if (states[texel] != 2) continue;
            const uint3 node = node_of(texel, n);
            const uint ring = ring_corners(flags, node, n);
            count += ring == 4 ? 2 : ring;
            if (ring > 4) flags[(node.y + node.z / 2) * ((1u << n) + 1) + node.x + node.z / 2] = 1;
        }
    }
    run_counts[run] = count;
}

typedef struct {
    __global const uchar *flags;
    __global const uint *ranks;
    uint n;
} Image;

static inline uint rank_at(const Image image, const uint i, const uint j)
{
    return image.ranks[quadtree_sample(i, j, image.n)];
}

// the fan's triangles along one side of the node, from (i, j) by (di, dj) per step
static inline __global uint *emit_side(
    const Image image, __global uint *out, const uint centre, const uint i, const uint j, const int di, const int dj,
    const uint size)
{
    const int row = (1 << image.n) + 1, stride = dj * row + di;
    const uint start = j * row + i;
    uint before = rank_at(image, i, j);
    for (uint at = 0; at < size;) {
        at = next_corner(image.flags, start, stride, size, at);
        const uint after = rank_at(image, i + (int)at * di, j + (int)at * dj);
        out[0] = centre;
        out[1] = before;
        out[2] = after;
        out += 3;
        before = after;
    }
    return out;
}

static inline __global uint *emit_two(const Image image, __global uint *out, const uint3 node)
{
    const uint i = node.x, j = node.y, size = node.z;
    const uint p = rank_at(image, i, j), q = rank_at(image, i + size, j);
    const uint r = rank_at(image, i + size, j + size), s = rank_at(image, i, j + size);
    const bool anti = quadtree_anti_diagonal(i, j, size, image.n);
    out[0] = p;
    out[1] = q;
    out[2] = anti ? s : r;
    out[3] = anti ? q : p;
    out[4] = r;
    out[5] = s;
    return out + 6;
}

__kernel void quadtree_lod_geometry_emit(
    __global const uchar *restrict states,
    __global const uchar *restrict flags,
    __global const uint *restrict ranks,
    __global const uint *restrict offsets,
    __global uint *restrict triangles,
    __global uint *restrict counts,
    const uint n,
    const uint run_count)
{
    const uint run = get_global_id(0);
    if (run >= run_count) return;

    const uint first = run * RUN;
    const Image image = {flags, ranks, n};
    __global uint *out = triangles + 3 * (size_t)offsets[run];
    for (uint texel = first; texel < first + RUN; ++texel) {
        if (states[texel] != 2) continue;
        const uint3 node = node_of(texel, n);
        const uint i = node.x, j = node.y, size = node.z;
        const uint middle = (j + size / 2) * ((1u << n) + 1) + i + size / 2;
        if (size == 1 || !flags[middle]) {
            out = emit_two(image, out, node);
            continue;
        }
        const uint centre = ranks[middle];
        out = emit_side(image, out, centre, i, j, 1, 0, size);
        out = emit_side(image, out, centre, i + size, j, 0, 1, size);
        out = emit_side(image, out, centre, i + size, j + size, -1, 0, size);
        out = emit_side(image, out, centre, i, j + size, 0, -1, size);
    }
    if (run == run_count - 1) counts[1] = (uint)((out - triangles) / 3);
}
