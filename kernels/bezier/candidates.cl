// Which candidate vertices are inserted into a cell's two coarse triangles: local tests, the same from both sides of an edge.
//
// Source    Concheiro 2013, chapter 3 (Distance, Flat and Length tests; decisions on an edge from that edge alone). The
//           measures, and that the vertices between which an inserted one lies are inserted too, are reconstructions
// Work      functions only. On a border of the patch nothing but the border's own control points is used, in sums that are
//           the same from either end
// Reads     nothing
// Writes    nothing
// Needs     bezier/cell.cl
// Plain     bezier/candidates.py
// Defines   TEST  0: distance from the chord, 1: angle between the normals at its ends, 2: length on the screen

#pragma OPENCL FP_CONTRACT OFF

#define EDGES_AT_MOST(depth) ((depth) == 3 ? 0xfeu : (depth) == 2 ? 0x54u : (depth) == 1 ? 0x10u : 0u)

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
        const float square = bezier_square(t.xyz);
        vstore3(t.xyz * (square > 1e-30f ? 1.0f / sqrt(square) : 0.0f), k, out);
    }
}
#endif

// what the tests compare, at all samples of a cell; `measure`: 1 / diagonal, least measure
static inline void bezier_measures_of(bezier_measures *m, const bezier_patch *patch, const bezier_map map,
    const bezier_cell cell, const uint side, const float2 measure, const float16 screen)
{
    m->least = measure.y;
    m->borders = (cell.i == 0) | (cell.i + CELL == side - 1) << 1 | (cell.j == 0) << 2 | (cell.j + CELL == side - 1) << 3;
#if TEST == 1
    float points[CELL_FLOATS];
    bezier_cell_rows(points, m->at, patch, map, cell, 0x1ff, side, true);
    for (uint k = 0; k < 2; ++k) {
        const float16 c = patch->rows[3 * k];
        if (m->borders >> k & 1)
            bezier_tangents(m->along[k], c.s0123, c.s4567, c.s89ab, c.scdef, map, cell.j, measure.x);
        if (m->borders >> (2 + k) & 1) {
            float4 b[4];
            for (uint r = 0; r < 4; ++r) b[r] = k ? patch->rows[r].scdef : patch->rows[r].s0123;
            bezier_tangents(m->along[2 + k], b[0], b[1], b[2], b[3], map, cell.i, measure.x);
        }
    }
#else
    bezier_cell_rows(m->at, m->at, patch, map, cell, 0x1ff, side, false);
    for (uint k = 0; k < CELL_SIDE * CELL_SIDE; ++k) {
        const float3 p = vload3(k, m->at);
        vstore3(TEST == 0 ? p * measure.x : bezier_projected(p, screen), k, m->at);
    }
#endif
}

// by how much the chord between two samples asks for one on it, of which the `share` of the way lies before
static inline float bezier_asked(const float *from, const uint one, const uint other, const uint middle, const float share)
{
    const float3 a = vload3(one, from), b = vload3(other, from);
#if TEST == 1
    const bool both_are = bezier_square(a) > 0.5f && bezier_square(b) > 0.5f;
    return both_are ? max(1.0f - (a.x * b.x + a.y * b.y + a.z * b.z), 0.0f) : 0.0f;
#else
    return bezier_square(TEST == 0 ? a * (1.0f - share) + b * share - vload3(middle, from) : a - b);
#endif
}

typedef struct {
    uint inserted, turned; // bits 1 .. 7, from its first end on, and from its last
    float bent;    // the most that places 2, 4 and 6 ask
} bezier_edge;

// with each inserted vertex those between which it lies are inserted too, so that a curve may cross its chord
static inline uint bezier_closed(uint edge)
{
    edge |= (edge >> 1 | edge << 1) & 0x44;
    return edge | ((edge >> 2 | edge << 2) & 0x10);
}

// the edge between two of the cell's corners; border: that which it lies on if the cell does, or 4
static inline bezier_edge bezier_edge_of(
    const bezier_measures *m, const uint first, const uint last, const uint border, const uint depth)
{
    const float *from = m->at;
    int begin = (int)first, step = ((int)last - (int)first) / CELL;
#if TEST == 1
    if (border < 4 && m->borders >> border & 1) from = m->along[border], begin = first > last ? CELL : 0, step = first > last ? -1 : 1;
#endif
    bezier_edge edge;
    edge.inserted = edge.turned = 0, edge.bent = 0.0f;
    for (int k = 1; k < CELL; ++k) {
        const int reach = k & -k;
        const float asked = bezier_asked(from, begin + step * (k - reach), begin + step * (k + reach), begin + step * k, 0.5f);
        const uint passes = asked >= m->least ? EDGES_AT_MOST(depth) >> k & 1 : 0;
        edge.inserted |= passes << k, edge.turned |= passes << (CELL - k);
        if (!(k & 1)) edge.bent = max(edge.bent, asked);
    }
    edge.inserted = bezier_closed(edge.inserted), edge.turned = bezier_closed(edge.turned);
    return edge;
}

static inline uint bezier_edge_level(const uint edge) { return edge & 0xaa ? 3 : edge & 0x44 ? 2 : edge & 0x10 ? 1 : 0; }

typedef struct {
    uint way, left, right, base;
} bezier_coarse;

// a triangle whose edges follow each other: its base is the edge that bends least, so that rows run that way
static inline bezier_coarse bezier_coarse_of(const uint first_way, const bezier_edge a, const bezier_edge b, const bezier_edge c)
{
    bezier_coarse t;
    if (b.bent <= a.bent && b.bent <= c.bent) t.way = first_way, t.left = a.inserted, t.base = b.inserted, t.right = c.turned;
    else if (c.bent <= a.bent) t.way = first_way + 1, t.left = b.inserted, t.base = c.inserted, t.right = a.turned;
    else t.way = first_way + 2, t.left = c.inserted, t.base = a.inserted, t.right = b.turned;
    return t;
}

// both triangles of a cell, cut along the diagonal that bends less
static inline void bezier_coarse_both(bezier_coarse both[2], const bezier_measures *m, const uint depth)
{
    const bezier_edge ab = bezier_edge_of(m, 0, 72, 2, depth), bc = bezier_edge_of(m, 72, 80, 1, depth);
    const bezier_edge cd = bezier_edge_of(m, 80, 8, 3, depth), da = bezier_edge_of(m, 8, 0, 0, depth);
    const bezier_edge ac = bezier_edge_of(m, 0, 80, 4, depth), bd = bezier_edge_of(m, 72, 8, 4, depth);
    bezier_edge back;
    if (ac.bent <= bd.bent) {
        back.inserted = ac.turned, back.turned = ac.inserted, back.bent = ac.bent;
        both[0] = bezier_coarse_of(0, ab, bc, back), both[1] = bezier_coarse_of(3, ac, cd, da);
    } else {
        back.inserted = bd.turned, back.turned = bd.inserted, back.bent = bd.bent;
        both[0] = bezier_coarse_of(6, ab, bd, da), both[1] = bezier_coarse_of(9, bc, cd, back);
    }
}

// as a mask, with the corners
static inline ulong bezier_edge_mask(const uint left, const uint right, const uint base)
{
    ulong mask = 1ul | 1ul << bezier_node(CELL, 0) | 1ul << bezier_node(CELL, CELL) | (ulong)base << bezier_node(CELL, 0);
    for (uint k = 1; k < CELL; ++k)
        mask |= (ulong)(left >> k & 1) << bezier_node(k, 0) | (ulong)(right >> k & 1) << bezier_node(k, k);
    return mask;
}

// is the candidate inside, in row r of a triangle, inserted? Its chord lies along the row, and within the triangle
static inline uint bezier_inserts(const bezier_measures *m, const uint4 corners, const uint r, const uint c)
{
    const uint reach = c & (0u - c), begin = c - reach, end = min(c + reach, r);
    const uint one = bezier_sample(corners, r, begin), other = bezier_sample(corners, r, end);
    const float share = (float)reach / (float)(end - begin);
    return bezier_asked(m->at, one, other, bezier_sample(corners, r, c), share) >= m->least;
}
