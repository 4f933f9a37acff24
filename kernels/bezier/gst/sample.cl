// Eight samples of two neighbouring rows of a patch, one row and the other in turn, by what is reused among them.
//
// Source    Concheiro 2013, chapter 2 (GST): U C V with C = N B N^T made once for a zone, U C once for a row
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     bezier/normal.cl
// Plain     bezier/gst/reference.py
// Defines   NORMALS (1: derivatives too), REUSE (0: each sample from the control points; 1: C of the zone; 2: and U C of
//           each row)

typedef struct {
    planes8 p, q, r; // point, Q_u and Q_v, these two over 3 and scaled
} gst_sampled;

#define EACH_AXIS(planes, FORMULA)                                                                                     \
    (planes).x = FORMULA(x);                                                                                           \
    (planes).y = FORMULA(y);                                                                                           \
    (planes).z = FORMULA(z);

#if REUSE == 0
typedef struct {
    float4 controls[16];
    float scale;
} gst_surface;
#else
typedef struct {
    float16 powers[4]; // of u - 1/2, each by four powers of v - 1/2: C
    float scale;
} gst_surface;
#endif

#if REUSE < 2
typedef struct {
    float8 u;
} gst_strip;

static inline void gst_strip_begin(gst_strip *strip, const gst_surface *surface, const float u) { }

static inline void gst_strip_next(gst_strip *strip, const gst_surface *surface, const float u, const float next)
{
    strip->u = (float8)(next, u, next, u, next, u, next, u);
}

#endif

#if REUSE == 0

static inline void gst_surface_of(gst_surface *surface, const bezier_patch *patch)
{
    for (uint i = 0; i < 4; ++i) {
        const float16 row = patch->rows[i];
        surface->controls[4 * i] = row.s0123, surface->controls[4 * i + 1] = row.s4567;
        surface->controls[4 * i + 2] = row.s89ab, surface->controls[4 * i + 3] = row.scdef;
    }
    surface->scale = patch->scale;
}

#define MIXED4(w, a, b, c, d) fma(w##3, d, fma(w##2, c, fma(w##1, b, w##0 * (a))))
#define MIXED3(e, a, b, c) fma(e##2, c, fma(e##1, b, e##0 * (a)))

static inline void gst_sample(gst_sampled *made, const gst_strip *strip, const gst_surface *surface, const float8 v)
{
    const float4 *c = surface->controls;
    const float8 t = strip->u + 0.5f, s = 1.0f - t, y = v + 0.5f, z = 1.0f - y;
    const float8 w0 = s * s * s, w1 = 3.0f * s * s * t, w2 = 3.0f * s * t * t, w3 = t * t * t;
    const float8 x0 = z * z * z, x1 = 3.0f * z * z * y, x2 = 3.0f * z * y * y, x3 = y * y * y;
#define CURVE(i, axis) MIXED4(x, c[4 * i].axis, c[4 * i + 1].axis, c[4 * i + 2].axis, c[4 * i + 3].axis)
#define POINT(axis) MIXED4(w, CURVE(0, axis), CURVE(1, axis), CURVE(2, axis), CURVE(3, axis))
    EACH_AXIS(made->p, POINT)
#if NORMALS
    const float scale = surface->scale;
    const float8 d0 = s * s * scale, d1 = 2.0f * s * t * scale, d2 = t * t * scale;
    const float8 e0 = z * z * scale, e1 = 2.0f * z * y * scale, e2 = y * y * scale;
#define RISE(i, axis) (CURVE((i + 1), axis) - CURVE(i, axis))
#define ALONG_U(axis) MIXED3(d, RISE(0, axis), RISE(1, axis), RISE(2, axis))
#define STEP(k, axis) (c[k + 1].axis - c[k].axis)
#define SLOPE(i, axis) MIXED3(e, STEP(4 * i, axis), STEP(4 * i + 1, axis), STEP(4 * i + 2, axis))
#define ALONG_V(axis) MIXED4(w, SLOPE(0, axis), SLOPE(1, axis), SLOPE(2, axis), SLOPE(3, axis))
    EACH_AXIS(made->q, ALONG_U)
    EACH_AXIS(made->r, ALONG_V)
#endif
}

#else

static inline void gst_surface_of(gst_surface *surface, const bezier_patch *patch)
{
    float16 along_u[4];
    const float16 a = patch->rows[0], b = patch->rows[1], c = patch->rows[2], d = patch->rows[3];
    BEZIER_TO_POWERS(along_u, a, b, c, d)
    for (uint k = 0; k < 4; ++k) {
        float4 powers[4];
        bezier_powers(powers, along_u[k]);
        surface->powers[k] = (float16)(powers[0], powers[1], powers[2], powers[3]);
    }
    surface->scale = patch->scale;
}

#if REUSE == 1

static inline void gst_sample(gst_sampled *made, const gst_strip *strip, const gst_surface *surface, const float8 v)
{
    const float8 u = strip->u;
    const float third = surface->scale * (1.0f / 3.0f);
    const float16 *c = surface->powers;
    planes8 rows[4];
#define ROW_X(k) fma(u, fma(u, fma(u, (float8)(c[3].k), (float8)(c[2].k)), (float8)(c[1].k)), (float8)(c[0].k))
    rows[0].x = ROW_X(s0), rows[0].y = ROW_X(s1), rows[0].z = ROW_X(s2);
    rows[1].x = ROW_X(s4), rows[1].y = ROW_X(s5), rows[1].z = ROW_X(s6);
    rows[2].x = ROW_X(s8), rows[2].y = ROW_X(s9), rows[2].z = ROW_X(sa);
    rows[3].x = ROW_X(sc), rows[3].y = ROW_X(sd), rows[3].z = ROW_X(se);
#define POINT(axis) fma(v, fma(v, fma(v, rows[3].axis, rows[2].axis), rows[1].axis), rows[0].axis)
    EACH_AXIS(made->p, POINT)
#if NORMALS
#define ALONG_V(axis) fma(v, fma(v, 3.0f * rows[3].axis, 2.0f * rows[2].axis), rows[1].axis) * third
    EACH_AXIS(made->r, ALONG_V)
#define SLOPE(k) fma(u, fma(u, (float8)(3.0f * c[3].k), (float8)(2.0f * c[2].k)), (float8)(c[1].k)) * third
    rows[0].x = SLOPE(s0), rows[0].y = SLOPE(s1), rows[0].z = SLOPE(s2);
    rows[1].x = SLOPE(s4), rows[1].y = SLOPE(s5), rows[1].z = SLOPE(s6);
    rows[2].x = SLOPE(s8), rows[2].y = SLOPE(s9), rows[2].z = SLOPE(sa);
    rows[3].x = SLOPE(sc), rows[3].y = SLOPE(sd), rows[3].z = SLOPE(se);
    EACH_AXIS(made->q, POINT)
#endif
}

#else

typedef struct {
    float16 p, q, r; // a row's curve by powers of v - 1/2; Q_u and Q_v along it over 3 and scaled, Q_v a power lower
} gst_row;

typedef struct {
    gst_row last;
    float p[32], q[32], r[32]; // numbers of the later row and the earlier in turn
} gst_strip;

static inline void gst_row_of(gst_row *row, const gst_surface *surface, const float u)
{
    const float16 *c = surface->powers;
    const float16 at = (float16)(u);
    row->p = fma(at, fma(at, fma(at, c[3], c[2]), c[1]), c[0]);
#if NORMALS
    const float third = surface->scale * (1.0f / 3.0f);
    row->q = fma(at, fma(at, 3.0f * c[3], 2.0f * c[2]), c[1]) * third;
    const float16 p = row->p * third;
    row->r = (float16)(p.s4567, 2.0f * p.s89ab, 3.0f * p.scdef, (float4)(0.0f));
#endif
}

static inline void gst_strip_begin(gst_strip *strip, const gst_surface *surface, const float u)
{
    gst_row_of(&strip->last, surface, u);
}

static inline void gst_in_turn(float *turns, const float16 a, const float16 b)
{
    vstore16((float16)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7), 0,
        turns);
    vstore16((float16)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf), 1,
        turns);
}

static inline void gst_strip_next(gst_strip *strip, const gst_surface *surface, const float u, const float next)
{
    gst_row row;
    gst_row_of(&row, surface, next);
    gst_in_turn(strip->p, row.p, strip->last.p);
#if NORMALS
    gst_in_turn(strip->q, row.q, strip->last.q);
    gst_in_turn(strip->r, row.r, strip->last.r);
#endif
    strip->last = row;
}

// both rows' numbers `k`, in turn over eight lanes
static inline float8 gst_both(const float *turns, const uint k)
{
    const float2 both = vload2(k, turns);
    return (float8)(both, both, both, both);
}

static inline void gst_sample(gst_sampled *made, const gst_strip *strip, const gst_surface *surface, const float8 v)
{
#define QUADRATIC(a, k) fma(v, fma(v, gst_both(a, k + 8), gst_both(a, k + 4)), gst_both(a, k))
#define CUBIC(a, k) fma(v, QUADRATIC(a, (k + 4)), gst_both(a, k))
    made->p.x = CUBIC(strip->p, 0), made->p.y = CUBIC(strip->p, 1), made->p.z = CUBIC(strip->p, 2);
#if NORMALS
    made->q.x = CUBIC(strip->q, 0), made->q.y = CUBIC(strip->q, 1), made->q.z = CUBIC(strip->q, 2);
    made->r.x = QUADRATIC(strip->r, 0), made->r.y = QUADRATIC(strip->r, 1), made->r.z = QUADRATIC(strip->r, 2);
#endif
}

#endif
#endif
