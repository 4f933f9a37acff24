// The flat surface: points and normals of a coarse triangle, interpolated along it.
//
// Source    Boubekeur & Schlick 2005, section 3.2
// Work      functions only, what common/lattice_walk.cl asks of a surface
// Reads     corners  float[19 * triangles]  P0 P1 P2 N0 N1 N2, 1 where edge P1 P2 begins at P2; model units
// Writes    nothing
// Needs     common/packed.cl
// Plain     refine/pattern/reference.py

#define CORNER_FLOATS 19

typedef struct {
    float3 p0, p1, p2, n0, n1, n2;
    bool from_p2;
} lattice_surface;

static inline void lattice_surface_of(lattice_surface *s, __global const float *restrict corners, const size_t triangle)
{
    __global const float *a = corners + CORNER_FLOATS * triangle;
    s->p0 = vload3(0, a), s->p1 = vload3(1, a), s->p2 = vload3(2, a);
    s->n0 = vload3(3, a), s->n1 = vload3(4, a), s->n2 = vload3(5, a);
    s->from_p2 = a[18] > 0.0f;
}

static inline bool lattice_from_p2(const lattice_surface *s) { return s->from_p2; }

static inline planes8 lattice_point(const lattice_surface *s, const float8 u, const float8 v)
{
    return planes8_span(u, v, s->p0, s->p1 - s->p0, s->p2 - s->p0);
}

static inline planes8 lattice_normal(const lattice_surface *s, const float8 u, const float8 v)
{
    return planes8_span(u, v, s->n0, s->n1 - s->n0, s->n2 - s->n0);
}

// from a to b by the same sum as on the edges at P0, and exact at b
static inline planes8 flat_edge(const float8 t, const float3 a, const float3 b)
{
    const planes8 end = {b.x, b.y, b.z};
    return planes8_pick(t == 1.0f, end, planes8_span(t, (float8)(0.0f), a, b - a, (float3)(0.0f)));
}

static inline planes8 lattice_edge_point(const lattice_surface *s, const float8 t)
{
    return flat_edge(t, s->from_p2 ? s->p2 : s->p1, s->from_p2 ? s->p1 : s->p2);
}

static inline planes8 lattice_edge_normal(const lattice_surface *s, const float8 t)
{
    return flat_edge(t, s->from_p2 ? s->n2 : s->n1, s->from_p2 ? s->n1 : s->n2);
}
