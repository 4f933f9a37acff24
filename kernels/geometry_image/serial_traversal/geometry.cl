// Quadtree over a geometry image, walked node by node: what the one-pass filter is measured against.
//
// Source    Wang et al., introduction and section 3.2 (the predecessor walks the tree to choose, merge and draw)
// Work      one item, which walks the tree twice: corners and vertices, then triangles
// Reads     errors          float[texel_count]       packed, saturated
//           image           float[3 * side * side]   side = 2^n + 1
//           image_normals   float[3 * side * side]
// Writes    flags           uchar[side * side]       zero before; 1: a drawn node's corner, seam duplicates alike
//           ranks           uint [side * side]       output vertex of a sample that stands for itself
//           positions       float[3 * capacity]      in the order of first use
//           normals         float[3 * capacity]
//           triangles       uint [3 * 2 * 4^n]
//           counts          uint [2]                 vertices, triangles
// Needs     common/quadtree.cl
// Plain     geometry_image/serial_traversal/reference.py

typedef struct {
    __global const float *image, *image_normals;
    __global uchar *flags;
    __global uint *ranks;
    __global float *positions, *normals;
    uint n, vertex_count;
} Output;

static inline void add_vertex(Output *output, const uint sample)
{
    const uint rank = output->vertex_count++;
    output->ranks[sample] = rank;
    for (uint k = 0; k < 3; ++k) {
        output->positions[3 * (size_t)rank + k] = output->image[3 * (size_t)sample + k];
        output->normals[3 * (size_t)rank + k] = output->image_normals[3 * (size_t)sample + k];
    }
}

static inline void mark_corner(Output *output, const uint i, const uint j)
{
    const uint last = 1u << output->n, at = j * (last + 1) + i;
    if (output->flags[at]) return;
    const uint own = quadtree_sample(i, j, output->n);
    if (!output->flags[own]) add_vertex(output, own);
    output->flags[own] = output->flags[at] = 1;
    // the seam duplicate across the fold, which a neighbour there walks over
    if (j == 0 || j == last) output->flags[j * (last + 1) + last - i] = 1;
    if (i == 0 || i == last) output->flags[(last - j) * (last + 1) + i] = 1;
}

static inline uint next_on_edge(
    __global const uchar *flags, const uint start, const int stride, const uint size, const uint from)
{
    uint step = from ? from & -from : size;
    while (step > 1 && flags[start + (int)(from + step / 2) * stride]) step /= 2;
    return from + step;
}

static inline bool edge_is_split(__global const uchar *flags, const uint start, const int stride, const uint size)
{
    return size > 1 && flags[start + (int)(size / 2) * stride];
}

static inline uint rank_of(const Output *output, const uint i, const uint j)
{
    return output->ranks[quadtree_sample(i, j, output->n)];
}

static inline __global uint *draw_node(Output *output, __global uint *out, const uint i, const uint j, const uint size)
{
    const int row = (1 << output->n) + 1;
    const uint low = j * row + i;
    __global const uchar *flags = output->flags;
    if (!edge_is_split(flags, low, 1, size) && !edge_is_split(flags, low + size, row, size)
        && !edge_is_split(flags, low + size * row, 1, size) && !edge_is_split(flags, low, row, size)) {
        const uint p = rank_of(output, i, j), q = rank_of(output, i + size, j);
        const uint r = rank_of(output, i + size, j + size), s = rank_of(output, i, j + size);
        const bool anti = quadtree_anti_diagonal(i, j, size, output->n);
        out[0] = p;
        out[1] = q;
        out[2] = anti ? s : r;
        out[3] = anti ? q : p;
        out[4] = r;
        out[5] = s;
        return out + 6;
    }
    const uint middle = low + (size / 2) * row + size / 2;
    add_vertex(output, middle);
    const uint centre = output->ranks[middle];
    uint x = i, y = j;
    for (uint side = 0; side < 4; ++side) {
        const int dx = side == 0 ? 1 : side == 2 ? -1 : 0, dy = side == 1 ? 1 : side == 3 ? -1 : 0;
        const uint start = y * row + x;
        uint before = rank_of(output, x, y);
        for (uint at = 0; at < size;) {
            at = next_on_edge(flags, start, dy * row + dx, size, at);
            const uint after = rank_of(output, x + (int)at * dx, y + (int)at * dy);
            out[0] = centre;
            out[1] = before;
            out[2] = after;
            out += 3;
            before = after;
        }
        x += dx * (int)size;
        y += dy * (int)size;
    }
    return out;
}

__kernel void serial_traversal_geometry(
    __global const float *restrict errors,
    __global const float *restrict image,
    __global const float *restrict image_normals,
    __global uchar *flags,
    __global uint *ranks,
    __global float *positions,
    __global float *normals,
    __global uint *triangles,
    __global uint *counts,
    const float threshold, // model units
    const uint n)
{
    if (get_global_id(0) != 0) return;

    Output output = {image, image_normals, flags, ranks, positions, normals, n, 0};
    __global uint *out = triangles;
    uint3 stack[40]; // three waiting siblings per level, and one
    for (uint pass = 0; pass < 2; ++pass) {
        uint waiting = 0;
        for (uint child = 4; child-- > 0;) stack[waiting++] = (uint3)(child & 1, child >> 1, 1);
        while (waiting > 0) {
            const uint3 node = stack[--waiting];
            const uint depth = node.z;
            if (depth < n && !(errors[quadtree_texel(depth, node.x, node.y, n)] < threshold)) {
                for (uint child = 4; child-- > 0;)
                    stack[waiting++] = (uint3)(2 * node.x + (child & 1), 2 * node.y + (child >> 1), depth + 1);
                continue;
            }
            const uint size = 1u << (n - depth), i = node.x * size, j = node.y * size;
            if (pass == 0) {
                mark_corner(&output, i, j);
                mark_corner(&output, i + size, j);
                mark_corner(&output, i + size, j + size);
                mark_corner(&output, i, j + size);
            } else
                out = draw_node(&output, out, i, j, size);
        }
    }
    counts[0] = output.vertex_count;
    counts[1] = (uint)((out - triangles) / 3);
}
