// Quadtree over a geometry image, geometry stage: the drawn nodes' triangles, merged, without cracks.
//
// Source    Wang et al., section 3.2, figure 4 and the text below it (a fan per merged node); the fan over the node's
//           perimeter, which keeps every corner of a finer neighbour, is a reconstruction
// Work      1-D, one item per run of RUN packed texels of one row
// Reads     states      uchar[texel_count]    0 too coarse, 1 nothing to draw, 2 drawn
//           flags       uchar[side * side]    a vertex of the drawn nodes' triangles; side = 2^n + 1, seam duplicates alike
//           ranks       uint [side * side]    output vertex of a flagged sample, seam duplicates alike
//           offsets     uint [run_count]      the run's first triangle
// Writes    run_counts  uint [run_count]      triangles of a run
//           triangles   uint [3 * 2 * 4^n]    output vertices, counter-clockwise from outside
//           counts      uint [2]              the second: triangles
// Needs     common/quadtree.cl
// Plain     geometry_image/quadtree_lod/reference.py
// Defines   RUN   1, or a power of two from 16 to 2^n

#if RUN >= 16
#define STEP 8
// one bit per texel of eight whose node is drawn
static inline ulong drawn_of(__global const uchar *states) { return as_ulong(vload8(0, states)) & 0x0202020202020202ul; }
#else
#define STEP 1
static inline ulong drawn_of(__global const uchar *states) { return states[0] & 2; }
#endif

static inline uint edge_corners(__global const uchar *flags, const uint start, const int stride, const uint size)
{
    uint count = 0;
    for (uint at = quadtree_next_corner(flags, start, stride, size, 0); at < size; ++count)
        at = quadtree_next_corner(flags, start, stride, size, at);
    return count;
}

// two where the centre is not flagged: no neighbour is finer; else one per corner on the perimeter
static inline uint node_triangles(__global const uchar *flags, const uint3 node, const uint n)
{
    const int row = (1 << n) + 1;
    const uint size = node.z, low = node.y * row + node.x;
    if (size == 1 || !flags[low + size / 2 * row + size / 2]) return 2;
    if (size == 2) // most fans: a sample on each edge is a corner or is not
        return 4 + flags[low + 1] + flags[low + row] + flags[low + row + 2] + flags[low + 2 * row + 1];
    return 4 + edge_corners(flags, low, 1, size) + edge_corners(flags, low + size, row, size)
         + edge_corners(flags, low + size * row, 1, size) + edge_corners(flags, low, row, size);
}

__kernel void quadtree_lod_geometry_count(
    __global const uchar *restrict states,
    __global const uchar *restrict flags,
    __global uint *restrict run_counts,
    const uint n,
    const uint run_count)
{
    const uint run = get_global_id(0);
    if (run >= run_count) return;

    const uint first = run * RUN;
    uint count = 0;
    for (uint texel = first; texel < first + RUN; texel += STEP) {
        const ulong drawn = drawn_of(states + texel);
        if (first >> (2 * n) == 0)
            count += 2 * (uint)popcount(drawn);
        else if (drawn != 0)
            for (uint t = texel; t < texel + STEP; ++t)
                if (states[t] == 2) count += node_triangles(flags, quadtree_node(t, n), n);
    }
    run_counts[run] = count;
}

// the fan's triangles along one side of the node, from sample `start` by `stride` a step
static inline __global uint *emit_side(
    __global const uchar *flags, __global const uint *ranks, __global uint *out, const uint centre, const uint start,
    const int stride, const uint size)
{
    uint before = ranks[start];
    for (uint at = 0; at < size;) {
        at = quadtree_next_corner(flags, start, stride, size, at);
        const uint after = ranks[start + (int)at * stride];
        out[0] = centre;
        out[1] = before;
        out[2] = after;
        out += 3;
        before = after;
    }
    return out;
}

static inline __global uint *emit_two(
    __global uint *out, const uint p, const uint q, const uint r, const uint s, const bool anti)
{
    out[0] = p;
    out[1] = q;
    out[2] = anti ? s : r;
    out[3] = anti ? q : p;
    out[4] = r;
    out[5] = s;
    return out + 6;
}

static inline __global uint *emit_node(
    __global const uchar *flags, __global const uint *ranks, __global uint *out, const uint3 node, const uint n)
{
    const uint size = node.z, row = (1u << n) + 1, low = node.y * row + node.x, high = low + size * row;
    const uint middle = low + size / 2 * row + size / 2;
    if (size == 1 || !flags[middle])
        return emit_two(
            out, ranks[low], ranks[low + size], ranks[high + size], ranks[high],
            quadtree_anti_diagonal(node.x, node.y, size, n));
    const uint centre = ranks[middle];
    out = emit_side(flags, ranks, out, centre, low, 1, size);
    out = emit_side(flags, ranks, out, centre, low + size, (int)row, size);
    out = emit_side(flags, ranks, out, centre, high + size, -1, size);
    return emit_side(flags, ranks, out, centre, high, -(int)row, size);
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
    __global uint *out = triangles + 3 * (size_t)offsets[run];
    for (uint texel = first; texel < first + RUN; texel += STEP) {
        if (drawn_of(states + texel) == 0) continue;
        for (uint t = texel; t < texel + STEP; ++t)
            if (states[t] == 2) out = emit_node(flags, ranks, out, quadtree_node(t, n), n);
    }
    if (run == run_count - 1) counts[1] = (uint)((out - triangles) / 3);
}
