// A cubic triangle: points cubic and normals quadratic in u and v, by powers about P0.
//
// Source    Vlachos et al. 2001, sections 3.1 and 3.3
// Work      functions only, what common/lattice_walk.cl asks of a surface. On the edges at P0 the sums are those of the
//           edge P1 P2: what is left of the others is zero
// Reads     coefficients  float[76 * triangles]  P0, u u^2 u^3, v v^2 v^3, uv u^2v uv^2 | begin of P1 P2, t t^2 t^3, end |
//                                                N0, u u^2, v v^2, uv | its begin, t t^2, end | 1 where it begins at P2
// Writes    nothing
// Needs     common/packed.cl
// Plain     refine/pn_triangles/reference.py

#define COEFFICIENTS 76

typedef struct {
    float3 p[10], edge_p[5];
    float3 n[6], edge_n[4];
    bool from_p2;
} lattice_surface;

static inline void lattice_surface_of(lattice_surface *s, __global const float *restrict coefficients, const size_t triangle)
{
    __global const float *c = coefficients + COEFFICIENTS * triangle;
    for (uint i = 0; i < 10; ++i) s->p[i] = vload3(i, c);
    for (uint i = 0; i < 5; ++i) s->edge_p[i] = vload3(10 + i, c);
    for (uint i = 0; i < 6; ++i) s->n[i] = vload3(15 + i, c);
    for (uint i = 0; i < 4; ++i) s->edge_n[i] = vload3(21 + i, c);
    s->from_p2 = c[75] > 0.0f;
}

static inline bool lattice_from_p2(const lattice_surface *s) { return s->from_p2; }

// t (a + t (b + t c)) added to sum
static inline float8 cubic_sum(const float8 t, const float a, const float b, const float c, const float8 sum)
{
    return fma(t, fma(t, fma(t, (float8)(c), (float8)(b)), (float8)(a)), sum);
}

static inline float8 quadratic_sum(const float8 t, const float a, const float b, const float8 sum)
{
    return fma(t, fma(t, (float8)(b), (float8)(a)), sum);
}

#define CUBIC_POINT(axis)                                                                                              \
    fma(uv, fma(u, (float8)(p[8].axis), fma(v, (float8)(p[9].axis), (float8)(p[7].axis))),                             \
        cubic_sum(v, p[4].axis, p[5].axis, p[6].axis,                                                                  \
            cubic_sum(u, p[1].axis, p[2].axis, p[3].axis, (float8)(p[0].axis))))
#define CUBIC_NORMAL(axis)                                                                                             \
    fma(uv, (float8)(n[5].axis),                                                                                       \
        quadratic_sum(v, n[3].axis, n[4].axis, quadratic_sum(u, n[1].axis, n[2].axis, (float8)(n[0].axis))))

static inline planes8 lattice_point(const lattice_surface *s, const float8 u, const float8 v)
{
    const float3 *p = s->p;
    const float8 uv = u * v;
    const planes8 point = {CUBIC_POINT(x), CUBIC_POINT(y), CUBIC_POINT(z)};
    return point;
}

static inline planes8 lattice_normal(const lattice_surface *s, const float8 u, const float8 v)
{
    const float3 *n = s->n;
    const float8 uv = u * v;
    const planes8 normal = {CUBIC_NORMAL(x), CUBIC_NORMAL(y), CUBIC_NORMAL(z)};
    return normal;
}

static inline planes8 lattice_edge_point(const lattice_surface *s, const float8 t)
{
    const float3 *e = s->edge_p;
    const planes8 end = {e[4].x, e[4].y, e[4].z};
    const planes8 point = {cubic_sum(t, e[1].x, e[2].x, e[3].x, (float8)(e[0].x)),
        cubic_sum(t, e[1].y, e[2].y, e[3].y, (float8)(e[0].y)), cubic_sum(t, e[1].z, e[2].z, e[3].z, (float8)(e[0].z))};
    return planes8_pick(t == 1.0f, end, point);
}

static inline planes8 lattice_edge_normal(const lattice_surface *s, const float8 t)
{
    const float3 *e = s->edge_n;
    const planes8 end = {e[3].x, e[3].y, e[3].z};
    const planes8 normal = {quadratic_sum(t, e[1].x, e[2].x, (float8)(e[0].x)),
        quadratic_sum(t, e[1].y, e[2].y, (float8)(e[0].y)), quadratic_sum(t, e[1].z, e[2].z, (float8)(e[0].z))};
    return planes8_pick(t == 1.0f, end, normal);
}
