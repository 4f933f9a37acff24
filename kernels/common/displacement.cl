// What raises vertices along their normals, eight at a time: a height d(p) over the place of the undisplaced point.
//
// Source    Boubekeur & Schlick 2005, section 4; the raised surface's normal is a reconstruction by the chain rule, which
//           takes the normal for constant: N less the tangential part of the height's gradient
// Work      functions only; the height itself is that of common/sine.cl, noise.cl, height_map.cl or function.cl, joined in
//           front of a surface: each gives `displace_eight`, and without attributes `displace_vectors` too
// Reads     table       uint []                           what the height looks up
//           attributes  float[3 * ATTRIBUTES * triangles]  of each triangle's corners in turn, where the height has any
// Writes    nothing
// Needs     common/packed.cl
// Plain     refine/displacement.py
// Defines   CHUNK (a multiple of eight: vertices that go through together at most), ATTRIBUTES (floats of a corner that a
//           height reads beside point and normal; else 0)

#ifndef ATTRIBUTES
#define ATTRIBUTES 0
#endif

typedef struct {
    float amplitude; // model units; of a function the step of its differences
    float waves;     // per diagonal
    float phase;     // turns of the sine, how far the noise has moved, or a function's time, s
    float inverse;   // 1 / diagonal
    __global const uint *table;
#if ATTRIBUTES
    __global const float *corners; // attributes of the triangle
    float8 at[ATTRIBUTES];         // those of eight of its vertices
#endif
} Displacement;

// to be called for each triangle before its vertices
static inline void displacement_enter(Displacement *d, __global const float *restrict attributes, const size_t triangle)
{
#if ATTRIBUTES
    d->corners = attributes + 3 * ATTRIBUTES * triangle;
#endif
}

#if ATTRIBUTES
// attributes at weights (u, v), by the same sums as a flat surface's points: equal to the bit on both sides of an edge
static inline void displacement_inside(Displacement *d, const float8 u, const float8 v)
{
    __global const float *a = d->corners, *b = a + ATTRIBUTES, *c = b + ATTRIBUTES;
    for (uint k = 0; k < ATTRIBUTES; ++k)
        d->at[k] = fma(v, (float8)(c[k] - a[k]), fma(u, (float8)(b[k] - a[k]), (float8)(a[k])));
}

// and at t of edge P1 P2 from its end of lower number, where the lane is on that edge
static inline void displacement_on_edge(Displacement *d, const int8 is_on, const float8 t, const bool from_p2)
{
    __global const float *a = d->corners + (from_p2 ? 2 : 1) * ATTRIBUTES;
    __global const float *b = d->corners + (from_p2 ? 1 : 2) * ATTRIBUTES;
    for (uint k = 0; k < ATTRIBUTES; ++k) {
        const float8 along = fma(t, (float8)(b[k] - a[k]), (float8)(a[k]));
        d->at[k] = float8_pick(is_on, float8_pick(t == 1.0f, (float8)(b[k]), along), d->at[k]);
    }
}
#endif

static inline planes8 displacement_in_diagonals(const planes8 p, const Displacement d)
{
    const planes8 q = {p.x * d.inverse, p.y * d.inverse, p.z * d.inverse};
    return q;
}

static inline planes8 displacement_raised(const planes8 p, const planes8 n, const float8 height)
{
    const planes8 raised = {fma(height, n.x, p.x), fma(height, n.y, p.y), fma(height, n.z, p.z)};
    return raised;
}

// N (1 + g N) - g is N less the tangential part of the gradient g
static inline planes8 displacement_tilted(const planes8 n, const planes8 g)
{
    const float8 along = fma(g.z, n.z, fma(g.y, n.y, fma(g.x, n.x, (float8)(1.0f))));
    const planes8 tilted = {fma(n.x, along, -g.x), fma(n.y, along, -g.y), fma(n.z, along, -g.z)};
    return planes8_normalise(tilted);
}
