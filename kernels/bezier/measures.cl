// What the tests of candidates compare, at the samples of a cell: points, unit normals or places on the screen.
//
// Source    Concheiro 2013, chapter 3 (Distance, Flat and Length tests). What they measure is a reconstruction
// Work      functions only. On a border of the patch nothing but the border's own control points is used, in sums that are
//           the same from either end
// Reads     nothing
// Writes    nothing
// Needs     bezier/cell.cl
// Plain     bezier/measures.py
// Defines   TEST  0: distance from the chord, 1: angle between the normals at its ends, 2: length on the screen
//           NORMALS (1 with the second)

#pragma OPENCL FP_CONTRACT OFF

typedef struct {
    float at[CELL_FLOATS];              // points in diagonals, unit normals, or places on the screen
    float along[4][3 * CELL_SIDE];      // with normals: unit tangents of borders u = 0, u = 1, v = 0, v = 1, or zeros
    uint borders;                       // bit k: the cell lies on that border
    float least;                        // of a measure that inserts, squared but for normals
} bezier_measures;

static inline float3 bezier_projected(const float3 p, const float16 screen)
{
    const float4 sum = screen.s0123 * p.x + screen.s4567 * p.y + screen.s89ab * p.z + screen.scdef;
    return sum.xyz / max(sum.w, 1e-6f); // behind the eye: large
}

#if TEST == 1
// unit tangents of a border curve over the cell; where there is none, zeros
static inline void bezier_tangents(float *out, const float4 a, const float4 b, const float4 c, const float4 d,
    const bezier_map map, const uint first, const float scale)
{
    __global const float *w = map.weights + 4 * map.stride + first;
    const float4 p = (b - a) * scale, q = (c - b) * scale, r = (d - c) * scale;
    for (uint k = 0; k < CELL_SIDE; ++k) {
        const float4 t = BEZIER_QUADRATIC(w[k], w[k + map.stride], w[k + 2 * map.stride], p, q, r);
        const float square = normals_square(t.xyz);
        vstore3(t.xyz * (square > 1e-30f ? 1.0f / sqrt(square) : 0.0f), k, out);
    }
}
#endif

#if TEST != 1
static inline float3 bezier_compared(const float3 p, const float2 measure, const float16 screen)
{
    return TEST == 0 ? p * measure.x : bezier_projected(p, screen);
}

// a point of each row of a block, at a column of its own
static inline void bezier_across(planes8 *p, const bezier_block *block, const float8 t)
{
    const float8 *m = block->point, tt = t * t;
#define ACROSS(k) (fma(tt, m[k + 2], m[k]) + t * fma(tt, m[k + 3], m[k + 1]))
    p->x = ACROSS(0), p->y = ACROSS(4), p->z = ACROSS(8);
}

// the samples on the cell's edges and diagonals alone
static inline void bezier_outline(float *out, const bezier_patch *patch, const bezier_map map, const bezier_cell cell,
    const uint side, const float2 measure, const float16 screen)
{
    bezier_block block;
    bezier_block_of(&block, patch, map, cell.i + CELL);
    bezier_cell_row(out, out, &block, 0, patch, map, cell, CELL, side);
    bezier_block_of(&block, patch, map, cell.i);
    bezier_cell_row(out, out, &block, 0, patch, map, cell, 0, side);
    for (uint k = 0; k < CELL_SIDE; ++k) {
        vstore3(bezier_compared(vload3(k, out), measure, screen), k, out);
        vstore3(bezier_compared(vload3(72 + k, out), measure, screen), 72 + k, out);
    }
    __global const float *t = map.weights + 7 * map.stride + cell.j;
    const float8 along = vload8(0, t), back = vload8(0, t + 1);
    planes8 down, up, first, last;
    bezier_across(&down, &block, along);
    bezier_across(&up, &block, SHUFFLE8(back, back, 7, 6, 5, 4, 3, 2, 1, 0));
    bezier_across(&first, &block, (float8)(t[0]));
    bezier_across(&last, &block, (float8)(t[CELL]));
    const float8 *c = block.controls; // where a row crosses a border its own control points are the border's
    if (cell.j == 0) first.x = c[0], first.y = c[4], first.z = c[8];
    if (cell.j + CELL == side - 1) last.x = c[3], last.y = c[7], last.z = c[11];
    for (uint i = 1; i < CELL; ++i) {
        const uint at = CELL_SIDE * i;
        vstore3(bezier_compared(bezier_lane(&first, i), measure, screen), at, out);
        vstore3(bezier_compared(bezier_lane(&down, i), measure, screen), at + i, out);
        vstore3(bezier_compared(bezier_lane(&up, i), measure, screen), at + CELL - i, out);
        vstore3(bezier_compared(bezier_lane(&last, i), measure, screen), at + CELL, out);
    }
}
#endif

// what the tests compare, at all samples of cell `number` or those alone that edges may need; `measure`: 1 / diagonal, least
// measure
static inline void bezier_measures_of(bezier_measures *m, __global const float *controls, const bezier_map map,
    const uint number, const uint side, const float2 measure, const float16 screen, const bool edges_alone)
{
    const bezier_cell cell = bezier_cell_of(number, (side - 1) / CELL);
    bezier_patch patch;
    bezier_patch_at(&patch, controls, cell.patch);
    m->least = measure.y;
    m->borders = (cell.i == 0) | (cell.i + CELL == side - 1) << 1 | (cell.j == 0) << 2 | (cell.j + CELL == side - 1) << 3;
#if TEST == 1
    float points[CELL_FLOATS];
    bezier_cell_rows(points, m->at, &patch, map, cell, 0x1ff, side);
    for (uint k = 0; k < 2; ++k) {
        const float16 c = patch.rows[3 * k];
        if (m->borders >> k & 1)
            bezier_tangents(m->along[k], c.s0123, c.s4567, c.s89ab, c.scdef, map, cell.j, measure.x);
        if (m->borders >> (2 + k) & 1) {
            float4 b[4];
            for (uint r = 0; r < 4; ++r) b[r] = k ? patch.rows[r].scdef : patch.rows[r].s0123;
            bezier_tangents(m->along[2 + k], b[0], b[1], b[2], b[3], map, cell.i, measure.x);
        }
    }
#else
    if (edges_alone) {
        bezier_outline(m->at, &patch, map, cell, side, measure, screen);
        return;
    }
    bezier_cell_rows(m->at, m->at, &patch, map, cell, 0x1ff, side);
    for (uint k = 0; k < CELL_SIDE * CELL_SIDE; ++k)
        vstore3(bezier_compared(vload3(k, m->at), measure, screen), k, m->at);
#endif
}
