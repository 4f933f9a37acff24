// The test "mean": each cell wishes for a grid, its edges have the finer of both sides' levels, then vertices and triangles.
//
// Source    none in Concheiro 2013: a reconstruction, whose grids have the least mean error for as many triangles
// Work      1-D, one item per cell
// Reads     map              float[8 * map_stride]  as bezier/row.cl has it, of the finest level
//           controls         float[64 * patches]    as bezier/patch.cl has it
//           sources          uint [8 * patches]     as bezier/cell.cl has it
//           ring             uint [4 * cell_count]  for each edge of each cell, 4 cell + edge, the next that is one with it
//           vertex_offsets   uint [cell_count]      where a cell's vertices begin
//           triangle_offsets uint [cell_count]      where its triangles do
//           vertex_total, triangle_total  uint [1]
// Writes    wishes           uint [cell_count]      level along u, 4 level along v, 16 if cut along the other diagonal
//           masks            ulong[2 * cell_count]  nodes of each coarse triangle or half, bits as bezier/cell.cl and
//                                                   bezier/half_strips.cl have them
//           vertex_counts    uint [cell_count]
//           triangle_counts  uint [cell_count]
//           positions        float[3 * vertex_room]    packed
//           normals          float[3 * vertex_room]    packed, unit length; nothing where NORMALS is 0
//           triangles        uint [3 * triangle_room]
//           counts           uint [2]  live vertices and triangles: none where the room does not suffice
// Needs     bezier/half_strips.cl, bezier/emission.cl
// Plain     bezier/grids.py
// Defines   NORMALS (1: normals too), STREAMING (bezier/output.cl, 1)

#pragma OPENCL FP_CONTRACT OFF

#define LEVEL_U (uint16)(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3) // of each grid, coarsest first
#define LEVEL_V (uint16)(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3)
#define TRIANGLE_EDGES 0x1ff81830c66ful // nodes on the edges of a coarse triangle
#define HALF_EDGES 0x1ff80c0603fful     // and of a half

static inline float16 grids_power(const uint16 exponent) { return as_float16((127u - exponent) << 23); } // of a half

// how far each grid is off the surface about place (i, j) of a cell, times area, added to both diagonals' sums
static inline void grids_off(float16 sums[2], const float *at, const uint place, const float inverse)
{
    const uint down = 18, right = 2; // samples
    float3 p[9];
    for (uint k = 0; k < 9; ++k) p[k] = vload3(place + (k / 3) * down - down + (k % 3) * right - right, at) * inverse;
    const float3 normal = cross(p[7] - p[1], p[5] - p[3]) * 4.0f;
    const float square = dot(normal, normal);
    if (!(square > 1e-30f && square < 1e30f)) return;
    // second differences of the whole cell times area; a third of 720's root is left to the end
    const float a = dot(p[7] + p[1] - p[4] * 2.0f, normal) * 16.0f;
    const float b = dot(p[8] + p[0] - p[2] - p[6], normal) * 4.0f;
    const float c = dot(p[5] + p[3] - p[4] * 2.0f, normal) * 16.0f;
    const float16 one = a * grids_power(2 * LEVEL_U), other = c * grids_power(2 * LEVEL_V);
    const float16 twist = 2.0f * b * grids_power(LEVEL_U + LEVEL_V), sum = one + other, squares = one * one + other * other;
    for (uint k = 0; k < 2; ++k) {
        const float16 third = k ? sum - twist : sum + twist, all = sum + third;
        sums[k] += sqrt(all * all + squares + third * third);
    }
}

__kernel void bezier_grids_choose(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global uint *restrict wishes,
    const float inverse, // 1 / diagonal
    const float price,   // of a triangle, in squares of the diagonal, times what the sums below lack
    const uint map_stride,
    const uint side,
    const uint depth,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    const bezier_cell cell = bezier_cell_of(number, (side - 1) / CELL);
    const bezier_map weights = {map, map_stride};
    bezier_patch patch;
    bezier_patch_at(&patch, controls, cell.patch);
    float at[CELL_FLOATS];
    bezier_cell_rows(at, at, &patch, weights, cell, 0x155, side);
    float16 sums[2] = {(float16)(0.0f), (float16)(0.0f)};
    for (uint i = 2; i < CELL; i += 2)
        for (uint j = 2; j < CELL; j += 2) grids_off(sums, at, CELL_SIDE * i + j, inverse);
    float off[32];
    vstore16(sums[0], 0, off), vstore16(sums[1], 1, off);
    const uint finest = 5 * depth;
    uint found = finest, cut = off[16 + finest] < off[finest];
    float least = INFINITY;
    for (uint k = 0; k < 16 && price > 0.0f; ++k) {
        if (k / 4 > depth || k % 4 > depth) continue;
        const uint other = off[16 + k] < off[k];
        const float cost = off[16 * other + k] + price * (float)(2u << (k / 4 + k % 4));
        if (cost < least) least = cost, found = k, cut = other;
    }
    wishes[number] = found / 4 | (found % 4) << 2 | cut << 4;
}

// the finest that a cell on this edge wishes for
static inline uint grids_edge(__global const uint *restrict wishes, __global const uint *restrict ring, const uint edge)
{
    uint level = 0, at = edge;
    do {
        const uint wish = wishes[at / 4];
        level = max(level, at & 2 ? wish & 3 : wish >> 2 & 3), at = ring[at];
    } while (at != edge);
    return level;
}

// nine places of which an edge of a level has every 8 >> level, from bit 0 on
static inline uint grids_on(const uint level) { return level == 3 ? 0x1ff : level == 2 ? 0x155 : level == 1 ? 0x111 : 0x101; }

static inline ulong grids_half(const uint outer, const uint columns, const uint rows, const uint left, const uint right, const uint k)
{
    const uint inside = grids_on(columns) & 0xfe;
    ulong mask = (ulong)grids_on(k ? columns : outer) | (ulong)grids_on(k ? outer : columns) << CELL_SIDE * (HALF_ROWS - 1);
    for (uint r = 1; r < HALF_ROWS - 1; ++r) {
        const uint row = (grids_on(rows) >> r & 1 ? inside : 0) | (grids_on(left) >> r & 1) | (grids_on(right) >> r & 1) << CELL;
        mask |= (ulong)row << CELL_SIDE * r;
    }
    return mask;
}

static inline ulong grids_triangle(const uint left, const uint right, const uint base)
{
    return bezier_edge_mask(grids_on(left), grids_on(right), grids_on(base));
}

__kernel void bezier_grids_test(
    __global const uint *restrict wishes,
    __global const uint *restrict ring,
    __global ulong *restrict masks,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    const uint wish = wishes[number], u = wish & 3, v = wish >> 2 & 3, other = wish >> 4;
    uint edge[4];
    for (uint k = 0; k < 4; ++k) edge[k] = grids_edge(wishes, ring, 4 * number + k);
    uint vertices = 0, faces = 0;
    for (uint k = 0; k < 2; ++k) {
        ulong mask;
        uint way = 3 * k + 6 * other;
        if (u | v) {
            mask = u ? grids_half(edge[k], v, u, edge[2], edge[3], k) : grids_half(edge[2 + k], u, v, edge[1], edge[0], k);
            way = FIRST_HALF + k + (u ? 0 : 2);
            mask |= (ulong)(other ^ (u == 0)) << OTHER_CUT;
        } else if (other) {
            mask = k ? grids_triangle(edge[1], 0, edge[3]) : grids_triangle(edge[2], edge[0], 0);
        } else {
            mask = k ? grids_triangle(0, edge[0], edge[3]) : grids_triangle(edge[2], 0, edge[1]);
        }
        masks[2 * number + k] = mask | (ulong)way << 60;
        const uint count = (uint)popcount(bezier_nodes(mask));
        vertices += count;
        faces += 2 * count - 2 - (uint)popcount(mask & (u | v ? HALF_EDGES : TRIANGLE_EDGES));
    }
    vertex_counts[number] = vertices;
    triangle_counts[number] = faces;
}

__kernel void bezier_grids_emit(
    __global const float *restrict controls,
    __global const uint *restrict sources,
    __global const ulong *restrict masks,
    __global const uint *restrict vertex_offsets,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict vertex_total,
    __global const uint *restrict triangle_total,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict triangles,
    __global uint *restrict counts,
    const uint side,
    const uint vertex_room,
    const uint triangle_room,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    if (!bezier_fits(counts, vertex_total[0], triangle_total[0], vertex_room, triangle_room, number)) return;

    const bezier_cell cell = bezier_cell_of(number, (side - 1) / CELL);
    const ulong2 both = vload2(number, masks);
    uint first = vertex_offsets[number];
    bezier_emit(positions, normals, controls, sources, cell, both, first, side);
    __global uint *to = triangles + 3 * (size_t)triangle_offsets[number];
    for (uint t = 0; t < 2; ++t) {
        const ulong mask = t ? both.y : both.x, nodes = bezier_nodes(mask);
        uchar list[3 * STRIP_TRIANGLES];
        const uint count = 3 * (bezier_way(mask) >= FIRST_HALF ? half_strips(list, mask) : bezier_strips(list, nodes));
        for (uint k = 0; k < count; ++k) to[k] = first + list[k];
        to += count;
        first += (uint)popcount(nodes);
    }
}
