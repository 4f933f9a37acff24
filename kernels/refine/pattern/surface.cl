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
    float3 p0, p1, p2, n0, n1, n2; // p1, p2, n1, n2 from p0 and n0
    float3 edge_p, edge_n, edge_pd, edge_nd, end_p, end_n; // P1 P2: begin, to the end, end
    bool from_p2;
} lattice_surface;

static inline void flat_surface(lattice_surface *s, const float3 p0, const float3 p1, const float3 p2, const float3 n0,
    const float3 n1, const float3 n2, const bool from_p2)
{
    s->p0 = p0, s->p1 = p1 - p0, s->p2 = p2 - p0;
    s->n0 = n0, s->n1 = n1 - n0, s->n2 = n2 - n0;
    s->edge_p = from_p2 ? p2 : p1, s->end_p = from_p2 ? p1 : p2;
    s->edge_n = from_p2 ? n2 : n1, s->end_n = from_p2 ? n1 : n2;
    s->edge_pd = s->end_p - s->edge_p, s->edge_nd = s->end_n - s->edge_n;
    s->from_p2 = from_p2;
}

static inline void lattice_surface_of(lattice_surface *s, __global const float *restrict corners, const size_t triangle)
{
    __global const float *a = corners + CORNER_FLOATS * triangle;
    flat_surface(
        s, vload3(0, a), vload3(1, a), vload3(2, a), vload3(3, a), vload3(4, a), vload3(5, a), a[18] > 0.0f);
}

static inline bool lattice_from_p2(const lattice_surface *s) { return s->from_p2; }

static inline planes8 lattice_point(const lattice_surface *s, const float8 u, const float8 v)
{
    return planes8_span(u, v, s->p0, s->p1, s->p2);
}

static inline planes8 lattice_normal(const lattice_surface *s, const float8 u, const float8 v)
{
    return planes8_span(u, v, s->n0, s->n1, s->n2);
}

// by the same sum as on the edges at P0, and exact at the end
static inline planes8 flat_edge(const float8 t, const float3 begin, const float3 way, const float3 end)
{
    const planes8 last = {end.x, end.y, end.z};
    return planes8_pick(t == 1.0f, last, planes8_span(t, (float8)(0.0f), begin, way, (float3)(0.0f)));
}

static inline planes8 lattice_edge_point(const lattice_surface *s, const float8 t)
{
    return flat_edge(t, s->edge_p, s->edge_pd, s->end_p);
}

static inline planes8 lattice_edge_normal(const lattice_surface *s, const float8 t)
{
    return flat_edge(t, s->edge_n, s->edge_nd, s->end_n);
}
