// A uniform grid over a mesh's box: positions in units of its cells, and the cell that holds each.
//
// Source    DeCoro & Tatarchuk 2007, slide 12 (cluster id); scaled so that 1e-20, 1e20 and far offsets stay finite
// Work      functions only; eight vertices at once
// Reads     nothing
// Writes    nothing, but for points where `grid_store8` is called
// Plain     cluster/grid.py

typedef struct { float8 x, y, z; } grid_points8;

// positions of rows v .. v + 7; rows past the last one repeat it
static inline grid_points8 grid_load8(__global const float *restrict positions, const uint v, const uint vertex_count)
{
    grid_points8 p;
    if (v + 8 <= vertex_count) {
        const float8 a = vload8(3 * (size_t)(v / 8), positions);
        const float8 b = vload8(3 * (size_t)(v / 8) + 1, positions);
        const float8 c = vload8(3 * (size_t)(v / 8) + 2, positions);
        p.x = (float8)(a.s036, b.s147, c.s25);
        p.y = (float8)(a.s147, b.s25, c.s036);
        p.z = (float8)(a.s25, b.s036, c.s147);
    } else {
        float x[8], y[8], z[8];
        for (uint j = 0; j < 8; ++j) {
            const size_t row = v + j < vertex_count ? v + j : vertex_count - 1;
            x[j] = positions[3 * row];
            y[j] = positions[3 * row + 1];
            z[j] = positions[3 * row + 2];
        }
        p.x = vload8(0, x);
        p.y = vload8(0, y);
        p.z = vload8(0, z);
    }
    return p;
}

// low.w is a power of two, so the first product is exact and every device, and the reference, rounds alike
static inline grid_points8 grid_scale8(const grid_points8 p, const float4 low, const float inverse)
{
    grid_points8 q;
    q.x = (p.x * low.w - low.x) * inverse;
    q.y = (p.y * low.w - low.y) * inverse;
    q.z = (p.z * low.w - low.z) * inverse;
    return q;
}

// clamped: a vertex on the far face of the box belongs to the last cell, not to one past it, and whatever float comes
// in, no cell outside the grid is named; limits are vectors, since Oclgrind reads lanes of a scalar one
static inline int8 grid_cell8(const grid_points8 q, const float4 per_axis, const uint4 cells)
{
    const int8 x = clamp(convert_int8(q.x * per_axis.x), (int8)0, (int8)((int)cells.x - 1));
    const int8 y = clamp(convert_int8(q.y * per_axis.y), (int8)0, (int8)((int)cells.y - 1));
    const int8 z = clamp(convert_int8(q.z * per_axis.z), (int8)0, (int8)((int)cells.z - 1));
    return (z * (int)cells.y + y) * (int)cells.x + x;
}

// points of rows v .. v + 7, x y z and what is kept beside each; rows past the last one are left alone
static inline void grid_store8(
    __global float *restrict points, const grid_points8 p, const float8 beside, const uint v, const uint vertex_count)
{
    const float16 first = (float16)(
        p.x.s0, p.y.s0, p.z.s0, beside.s0, p.x.s1, p.y.s1, p.z.s1, beside.s1,
        p.x.s2, p.y.s2, p.z.s2, beside.s2, p.x.s3, p.y.s3, p.z.s3, beside.s3);
    const float16 second = (float16)(
        p.x.s4, p.y.s4, p.z.s4, beside.s4, p.x.s5, p.y.s5, p.z.s5, beside.s5,
        p.x.s6, p.y.s6, p.z.s6, beside.s6, p.x.s7, p.y.s7, p.z.s7, beside.s7);
    if (v + 8 <= vertex_count) {
        vstore16(first, v / 4, points);
        vstore16(second, v / 4 + 1, points);
    } else {
        float last[32];
        vstore16(first, 0, last);
        vstore16(second, 1, last);
        for (uint j = 0; j < 4 * (vertex_count - v); ++j) points[4 * (size_t)v + j] = last[j];
    }
}
