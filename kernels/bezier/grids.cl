// The test "mean", first: the grids that each cell wishes for.
//
// Source    none in Concheiro 2013: a reconstruction, whose grids have the least mean error for as many triangles
// Work      1-D, one item per cell
// Reads     map              float[8 * map_stride]  as bezier/row.cl has it, of the finest level
//           controls         float[64 * patches]    as bezier/patch.cl has it
// Writes    wishes           uint [cell_count]      as bezier/grids.py has them
//           rises            int  [2 * cell_count]  as bezier/rises.cl has them
// Needs     bezier/rises.cl
// Plain     bezier/grids.py
// Defines   NORMALS (0), STREAMING (common/output.cl, 1)

#pragma OPENCL FP_CONTRACT OFF

#define LEVEL_U (uint16)(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3) // of each grid, coarsest first
#define LEVEL_V (uint16)(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3)

static inline float16 grids_power(const uint16 exponent) { return as_float16((127u - exponent) << 23); } // of a half

// by row and column of the nine places: how far each grid is off the surface, along either diagonal; second differences
// along u and both and v, and area
typedef struct {
    float16 down[2][3], across[2][3];
    float4 bend_down[3], bend_across[3];
} grids_sums;

// what place (i, j), 1 to 3 each, adds: of a grid of the whole cell, times area
static inline void grids_off(
    grids_sums *sums, const float *at, const uint i, const uint j, const float inverse, const float mean)
{
    float3 p[9];
    for (uint k = 0; k < 9; ++k)
        p[k] = vload3(CELL_SIDE * 2 * (i + k / 3 - 1) + 2 * (j + k % 3 - 1), at) * inverse;
    const float3 normal = cross(p[7] - p[1], p[5] - p[3]) * 4.0f;
    const float square = dot(normal, normal);
    if (!(square > 1e-30f && square < 1e30f)) return;
    // second differences of the whole cell
    const float a = dot(p[7] + p[1] - p[4] * 2.0f, normal) * 16.0f;
    const float b = dot(p[8] + p[0] - p[2] - p[6], normal) * 4.0f;
    const float c = dot(p[5] + p[3] - p[4] * 2.0f, normal) * 16.0f;
    const float4 bend = (float4)(a, b, c, sqrt(square));
    sums->bend_down[i - 1] += bend, sums->bend_across[j - 1] += bend;
    const float16 one = a * grids_power(2 * LEVEL_U), other = c * grids_power(2 * LEVEL_V);
    const float16 twist = 2.0f * b * grids_power(LEVEL_U + LEVEL_V), sum = one + other, squares = one * one + other * other;
    for (uint k = 0; k < 2; ++k) {
        const float16 third = k ? sum - twist : sum + twist, all = sum + third;
        const float16 off = sqrt(max(all * all * mean + squares + third * third, (float16)(0.0f)));
        sums->down[k][i - 1] += off, sums->across[k][j - 1] += off;
    }
}

// the least cost of a half, of what its grids are off along either diagonal; `step` from rows to more rows, `next` from
// columns to more
static inline float grids_least(uint *found, const float16 both[2], const uint step, const uint next, const uint depth, const float price)
{
    float off[32], least = INFINITY;
    vstore16(both[0], 0, off), vstore16(both[1], 1, off);
    for (uint rows = 0; rows < depth; ++rows)
        for (uint columns = 0; columns <= depth; ++columns) {
            if (!(price > 0.0f) && (rows + 1 < depth || columns < depth)) continue; // all are inserted
            const uint grid = step * (rows + 1) + next * columns, other = off[16 + grid] < off[grid];
            const float cost = off[16 * other + grid] + price * (float)(2u << (rows + columns));
            if (cost < least || least == INFINITY) least = cost, *found = rows | columns << 2 | other << 4;
        }
    return least;
}

// how far the triangles of a half lie under the surface in the mean, by what its places bend
static inline int grids_rise(const float4 *three, const uint k, const uint level_u, const uint level_v, const uint other)
{
    const float4 bend = three[2 * k] + 0.5f * three[1];
    if (!(bend.w > 0.0f)) return 0;
    const float a = bend.x / (float)(1u << 2 * level_u), c = bend.z / (float)(1u << 2 * level_v);
    const float b = bend.y / (float)(1u << (level_u + level_v));
    return bezier_rise((a + c + (other ? -b : b)) / (-12.0f * bend.w));
}

__kernel void bezier_grids_choose(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global uint *restrict wishes,
    __global int *restrict rises,
    const float inverse, // 1 / diagonal
    const float mean,    // weight of the mean's square: 1, or -1/4 where vertices rise by it
    const float price,   // of a triangle, in squares of the diagonal, times what the sums lack
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
    grids_sums sums;
    for (uint k = 0; k < 2; ++k)
        for (uint n = 0; n < 3; ++n) sums.down[k][n] = sums.across[k][n] = (float16)(0.0f);
    for (uint n = 0; n < 3; ++n) sums.bend_down[n] = sums.bend_across[n] = (float4)(0.0f);
    for (uint i = 1; i < 4; ++i)
        for (uint j = 1; j < 4; ++j) grids_off(&sums, at, i, j, inverse, mean);
    const float16 one = sums.down[0][0] + sums.down[0][1] + sums.down[0][2];
    const float16 two = sums.down[1][0] + sums.down[1][1] + sums.down[1][2];
    uint found = (uint)(two.s0 < one.s0) << 6;
    float least = depth && !(price > 0.0f) ? INFINITY : min(one.s0, two.s0) + 2.0f * price;
    for (uint cut = 1; cut < 3 && depth; ++cut) {
        uint parts[2];
        float cost = 0.0f;
        for (uint k = 0; k < 2; ++k) {
            float16 both[2];
            for (uint n = 0; n < 2; ++n) {
                const float16 *three = cut == 1 ? sums.down[n] : sums.across[n];
                both[n] = three[2 * k] + 0.5f * three[1];
            }
            cost += grids_least(parts + k, both, cut == 1 ? 4 : 1, cut == 1 ? 1 : 4, depth, price);
        }
        if (cost < least || least == INFINITY) least = cost, found = cut | parts[0] << 2 | parts[1] << 7;
    }
    wishes[number] = found;
    const uint cut = found & 3;
    for (uint k = 0; k < 2; ++k) {
        const uint of_half = found >> (2 + 5 * k), rows = cut ? (of_half & 3) + 1 : 0, columns = cut ? of_half >> 2 & 3 : 0;
        const bool down = cut != 2;
        const uint other = cut ? of_half >> 4 & 1 : found >> 6 & 1;
        rises[2 * number + k] = grids_rise(
            down ? sums.bend_down : sums.bend_across, k, down ? rows : columns, down ? columns : rows, other);
    }
}
