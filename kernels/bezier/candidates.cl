// Which candidate vertices are inserted into a cell's two coarse triangles: local tests, the same from both sides of an edge.
//
// Source    Concheiro 2013, chapter 3 (Distance, Flat and Length tests; decisions on an edge from that edge alone). The
//           measures, and that the vertices between which an inserted one lies are inserted too, are reconstructions
// Work      functions only. On a border of the patch nothing but the border's own control points is used, in sums that are
//           the same from either end
// Reads     nothing
// Writes    nothing
// Needs     bezier/measures.cl
// Plain     bezier/candidates.py
// Defines   TEST (bezier/measures.cl)

#pragma OPENCL FP_CONTRACT OFF

#define EDGES_AT_MOST(depth) ((depth) == 3 ? 0xfeu : (depth) == 2 ? 0x54u : (depth) == 1 ? 0x10u : 0u)

// by how much the chord between two samples asks for one on it, of which the `share` of the way lies before
static inline float bezier_asked(const float *from, const uint one, const uint other, const uint middle, const float share)
{
    const float3 a = vload3(one, from), b = vload3(other, from);
#if TEST == 1
    const bool both_are = normals_square(a) > 0.5f && normals_square(b) > 0.5f;
    return both_are ? max(1.0f - (a.x * b.x + a.y * b.y + a.z * b.z), 0.0f) : 0.0f;
#else
    return normals_square(TEST == 0 ? a * (1.0f - share) + b * share - vload3(middle, from) : a - b);
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

static inline uint bezier_or(const int8 a)
{
    const int4 four = a.lo | a.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
}

// the same along an edge: places 0 to 7, and 8 in all lanes of `last`; those of 0 say nothing
static inline float8 bezier_asked8(const planes8 p, const planes8 last)
{
#define ONE(axis) SHUFFLE8(p.axis, last.axis, 0, 0, 0, 2, 0, 4, 4, 6)
#define OTHER(axis) SHUFFLE8(p.axis, last.axis, 0, 2, 4, 4, 8, 6, 8, 8)
    const planes8 a = {ONE(x), ONE(y), ONE(z)}, b = {OTHER(x), OTHER(y), OTHER(z)};
#if TEST == 1
    const float8 one = a.x * a.x + a.y * a.y + a.z * a.z, other = b.x * b.x + b.y * b.y + b.z * b.z;
    const float8 turned = max(1.0f - (a.x * b.x + a.y * b.y + a.z * b.z), (float8)(0.0f));
    return float8_pick(one > 0.5f & other > 0.5f, turned, (float8)(0.0f));
#else
    planes8 d = {a.x - b.x, a.y - b.y, a.z - b.z};
    if (TEST == 0) d.x = (a.x + b.x) * 0.5f - p.x, d.y = (a.y + b.y) * 0.5f - p.y, d.z = (a.z + b.z) * 0.5f - p.z;
    return d.x * d.x + d.y * d.y + d.z * d.z;
#endif
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
    planes8 p, q; // places 0 to 7, and 8 in all lanes
#define EDGE_PLACES(axis, lane)                                                                                        \
    p.axis = (float8)(AT(0, lane), AT(1, lane), AT(2, lane), AT(3, lane), AT(4, lane), AT(5, lane), AT(6, lane), AT(7, lane)); \
    q.axis = (float8)(AT(8, lane));
#define AT(k, lane) from[3 * (begin + step * (k)) + (lane)]
    EDGE_PLACES(x, 0) EDGE_PLACES(y, 1) EDGE_PLACES(z, 2)
    const float8 asked = bezier_asked8(p, q);
    const int8 passes = asked >= m->least;
    const uint allowed = EDGES_AT_MOST(depth);
    edge.inserted = bezier_closed(bezier_or(passes & (int8)(1, 2, 4, 8, 16, 32, 64, 128)) & allowed);
    edge.turned = bezier_closed(bezier_or(passes & (int8)(256, 128, 64, 32, 16, 8, 4, 2)) & allowed);
    edge.bent = max(max(asked.s2, asked.s4), asked.s6);
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

// is the candidate inside, in row r of a triangle, inserted? Its chord lies along the row, and within the triangle
static inline uint bezier_inserts(const bezier_measures *m, const uint4 corners, const uint r, const uint c)
{
    const uint reach = c & (0u - c), begin = c - reach, end = min(c + reach, r);
    const uint one = bezier_sample(corners, r, begin), other = bezier_sample(corners, r, end);
    const float share = (float)reach / (float)(end - begin);
    return bezier_asked(m->at, one, other, bezier_sample(corners, r, c), share) >= m->least;
}
