// A cubic triangle's control points and normals, and how they are kept: as polynomials in u and v about P0.
//
// Source    Vlachos et al. 2001, sections 3.1 (control points) and 3.3 (control normals)
// Work      functions only; contraction is off, so that an edge comes out alike from both of its triangles
// Reads     nothing
// Writes    coefficients  float[76 * triangles]  as refine/cubic_surface.cl has them
// Plain     refine/pn_triangles/reference.py
// Defines   LINEAR  1: normals interpolated linearly

#pragma OPENCL FP_CONTRACT OFF

#define COEFFICIENTS 76
#define THIRD (1.0f / 3.0f)

// Beside corner i on the edge to j the control point is (2 Pi + Pj - bend) / 3; bend is what leaves the chord
typedef struct {
    float3 p[3], n[3];              // corners, and the normals there
    float3 bend01, bend10, bend12, bend21, bend20, bend02;
    float3 middle01, middle12, middle20; // control normals of the edges
    float3 inner;                   // b111 less P0
    bool from_p2;
} cubic_triangle;

static inline float cubic_dot(const float3 a, const float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// unit length; `otherwise` where there is no direction
static inline float3 cubic_unit(const float3 a, const float3 otherwise)
{
    const float square = cubic_dot(a, a);
    return square > 1e-24f ? a * (1.0f / sqrt(square)) : otherwise;
}

static inline float3 cubic_bend(const float3 a, const float3 b, const float3 normal)
{
    return normal * cubic_dot(b - a, normal);
}

// the control normal of an edge, the same from either end; `scale` brings the model's size near 1, for its square
static inline float3 cubic_middle(const float3 a, const float3 b, const float3 na, const float3 nb, const float scale)
{
    const float3 d = (b - a) * scale, sum = na + nb;
    const float square = cubic_dot(d, d);
    const float v = square > 0.0f ? 2.0f * cubic_dot(d, sum) / square : 0.0f;
    return cubic_unit(sum - d * v, cubic_unit(sum, na));
}

// the mean of the six control points on edges, less P0, each bend taken so far: by `share01` on edge P0 P1 ...
static inline float3 cubic_mean(const cubic_triangle *t, const float share01, const float share12, const float share20)
{
    const float3 q1 = t->p[1] - t->p[0], q2 = t->p[2] - t->p[0];
    const float3 bends = (t->bend01 + t->bend10) * share01 + (t->bend12 + t->bend21) * share12 +
                         (t->bend20 + t->bend02) * share20;
    return (q1 + q2) * THIRD - bends * (THIRD / 6.0f);
}

// b111 less P0: half as far again as the mean of those six is from that of the corners
static inline float3 cubic_inner(const cubic_triangle *t)
{
    const float3 mean = cubic_mean(t, 1.0f, 1.0f, 1.0f);
    const float3 corners = ((t->p[1] - t->p[0]) + (t->p[2] - t->p[0])) * THIRD;
    return mean + (mean - corners) * 0.5f;
}

// from a: t c[0] + t^2 c[1] + t^3 c[2]
static inline void cubic_edge(const float3 a, const float3 b, const float3 bend_a, const float3 bend_b, float3 *c)
{
    c[0] = (b - a) - bend_a;
    c[1] = bend_a * 2.0f - bend_b;
    c[2] = bend_b - bend_a;
}

// from na: t c[0] + t^2 c[1], of any length
static inline void cubic_edge_normals(const float3 na, const float3 nb, const float3 middle, float3 *c)
{
#if LINEAR
    c[0] = nb - na;
    c[1] = (float3)(0.0f);
#else
    c[0] = middle - na * 2.0f;
    c[1] = (na + nb) - middle;
#endif
}

static inline __global float *cubic_put(__global float *restrict out, const float3 *c, const uint count)
{
    for (uint i = 0; i < count; ++i) vstore3(c[i], i, out);
    return out + 3 * count;
}

static inline void cubic_store(const cubic_triangle *t, __global float *restrict out)
{
    const float3 p0 = t->p[0], n0 = t->n[0];
    const float3 begin = t->from_p2 ? t->p[2] : t->p[1], end = t->from_p2 ? t->p[1] : t->p[2];
    const float3 begin_n = t->from_p2 ? t->n[2] : t->n[1], end_n = t->from_p2 ? t->n[1] : t->n[2];
    float3 u[3], v[3], edge[3], mixed[3];
    cubic_edge(p0, t->p[1], t->bend01, t->bend10, u);
    cubic_edge(p0, t->p[2], t->bend02, t->bend20, v);
    cubic_edge(begin, end, t->from_p2 ? t->bend21 : t->bend12, t->from_p2 ? t->bend12 : t->bend21, edge);

    const float3 q1 = t->p[1] - p0, q2 = t->p[2] - p0, b111 = t->inner;
    const float3 b210 = (q1 - t->bend01) * THIRD, b120 = (q1 * 2.0f - t->bend10) * THIRD;
    const float3 b201 = (q2 - t->bend02) * THIRD, b102 = (q2 * 2.0f - t->bend20) * THIRD;
    const float3 b021 = (q1 * 2.0f + q2 - t->bend12) * THIRD, b012 = (q2 * 2.0f + q1 - t->bend21) * THIRD;
    mixed[0] = (b111 - b210 - b201) * 6.0f;
    mixed[1] = (b210 * 2.0f + b201 - b120 + b021 - b111 * 2.0f) * 3.0f;
    mixed[2] = (b201 * 2.0f + b210 - b102 + b012 - b111 * 2.0f) * 3.0f;

    float3 nu[2], nv[2], ne[2];
    cubic_edge_normals(n0, t->n[1], t->middle01, nu);
    cubic_edge_normals(n0, t->n[2], t->middle20, nv);
    cubic_edge_normals(begin_n, end_n, t->middle12, ne);
#if LINEAR
    const float3 mixed_n = (float3)(0.0f);
#else
    const float3 mixed_n = t->middle12 - t->middle20 - t->middle01 + n0 * 2.0f;
#endif

    out = cubic_put(out, &p0, 1);
    out = cubic_put(out, u, 3);
    out = cubic_put(out, v, 3);
    out = cubic_put(out, mixed, 3);
    out = cubic_put(out, &begin, 1);
    out = cubic_put(out, edge, 3);
    out = cubic_put(out, &end, 1);
    out = cubic_put(out, &n0, 1);
    out = cubic_put(out, nu, 2);
    out = cubic_put(out, nv, 2);
    out = cubic_put(out, &mixed_n, 1);
    out = cubic_put(out, &begin_n, 1);
    out = cubic_put(out, ne, 2);
    out = cubic_put(out, &end_n, 1);
    out[0] = t->from_p2 ? 1.0f : 0.0f;
}
