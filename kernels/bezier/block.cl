// Eight neighbouring rows of a patch's parametric map, a lane each: what their points and normals are polynomials of.
//
// Source    Concheiro 2013, section 1.2 and chapter 2; that a row's normals are made as one polynomial of degree five,
//           Q_u x Q_v by powers of v - 1/2, is a reconstruction
// Work      functions only. Normals at both borders, where Q_u may vanish exactly, and in the middle are made here
// Reads     map  float[8 * map_stride]  at i / n: planes J_{3,0..3}, J_{2,0..2}, t - 1/2; eight more than side
// Writes    nothing
// Needs     bezier/normal.cl
// Plain     bezier/reference.py
// Defines   NORMALS (1: normals too)

#pragma OPENCL FP_CONTRACT OFF

#define BEZIER_ROWS 8 // of a block

typedef struct {
    float8 controls[12]; // of each row's own curve, four of each axis
    float8 point[12];    // by powers of v - 1/2, likewise
#if NORMALS
    float8 normal[18]; // likewise, six of each axis; of any length
    planes8 first, middle, last; // unit normals at v = 0, 1/2 and 1
#endif
} bezier_block;

typedef struct {
    __global const float *weights;
    uint stride;
} bezier_map;

#if NORMALS
// eight unit normals a little nearer to the middle, where those at (u, v) are bad
static inline void bezier_mend8(planes8 *n, const int8 is_bad, const bezier_patch *patch, float8 u, float8 v)
{
    u += INWARDS * (0.5f - u), v += INWARDS * (0.5f - v);
    const float8 s = 1.0f - u, t = 1.0f - v;
    planes8 along_u, along_v;
    float8 *across_of = &along_u.x, *along_of = &along_v.x;
    const float *P = (const float *)patch->rows;
    for (uint axis = 0; axis < 3; ++axis) {
        float8 r[4], q[4];
        for (uint j = 0; j < 4; ++j) {
            const float *p = P + 4 * j + axis;
            const float a = p[0] * patch->scale, b = p[16] * patch->scale, c = p[32] * patch->scale;
            const float d = p[48] * patch->scale;
            r[j] = BEZIER_CUBIC(s * s * s, 3.0f * s * s * u, 3.0f * s * u * u, u * u * u, a, b, c, d);
            q[j] = BEZIER_QUADRATIC(s * s, 2.0f * s * u, u * u, b - a, c - b, d - c);
        }
        across_of[axis] =
            BEZIER_CUBIC(t * t * t, 3.0f * t * t * v, 3.0f * t * v * v, v * v * v, q[0], q[1], q[2], q[3]);
        along_of[axis] = BEZIER_QUADRATIC(t * t, 2.0f * t * v, v * v, r[1] - r[0], r[2] - r[1], r[3] - r[2]);
    }
    const planes8 inner = {along_u.y * along_v.z - along_u.z * along_v.y, along_u.z * along_v.x - along_u.x * along_v.z,
        along_u.x * along_v.y - along_u.y * along_v.x};
    *n = planes8_pick(is_bad, planes8_normalise(inner), *n);
}

// one axis of a cross product by powers: a cubic and a quadratic of one axis each, and of the other
static inline void bezier_crossed(
    float8 *n, const float8 *q_one, const float8 *r_other, const float8 *q_other, const float8 *r_one)
{
    for (uint k = 0; k < 6; ++k) n[k] = 0.0f;
    for (uint i = 0; i < 4; ++i)
        for (uint j = 0; j < 3; ++j)
            n[i + j] = fma(q_one[i], r_other[j], fma(-q_other[i], r_one[j], n[i + j]));
}

static inline void bezier_block_unit(
    planes8 *unit, const planes8 q, const planes8 r, const bezier_patch *patch, const float8 u, const float v)
{
    const int8 is_bad = normals_cross8(unit, q, r);
    if (normals_any(is_bad)) bezier_mend8(unit, is_bad, patch, u, (float8)(v));
}
#endif

// the rows from i on; those past the last are of no use
static inline void bezier_block_of(bezier_block *block, const bezier_patch *patch, const bezier_map map, const uint i)
{
    __global const float *w = map.weights + i;
    const uint s = map.stride;
    const float8 w0 = vload8(0, w), w1 = vload8(0, w + s), w2 = vload8(0, w + 2 * s), w3 = vload8(0, w + 3 * s);
    const float *P = (const float *)patch->rows;
#if NORMALS
    const float8 d0 = vload8(0, w + 4 * s), d1 = vload8(0, w + 5 * s), d2 = vload8(0, w + 6 * s);
    const float scale = patch->scale;
    const float16 steps[3] = {(patch->rows[1] - patch->rows[0]) * scale, (patch->rows[2] - patch->rows[1]) * scale,
        (patch->rows[3] - patch->rows[2]) * scale};
    const float *D = (const float *)steps;
    float8 q[12], r[9]; // Q_u and Q_v over 3, scaled, by powers
    planes8 q_first, q_last, r_first, r_last;
    float8 *const ends[4] = {&q_first.x, &q_last.x, &r_first.x, &r_last.x};
#endif
    for (uint axis = 0; axis < 3; ++axis) {
        float8 curve[4];
        for (uint j = 0; j < 4; ++j) {
            const float *p = P + 4 * j + axis;
            curve[j] = BEZIER_CUBIC(w0, w1, w2, w3, (float8)(p[0]), (float8)(p[16]), (float8)(p[32]), (float8)(p[48]));
            block->controls[4 * axis + j] = curve[j];
        }
        BEZIER_TO_POWERS(block->point + 4 * axis, curve[0], curve[1], curve[2], curve[3])
#if NORMALS
        float8 across[4];
        for (uint j = 0; j < 4; ++j) {
            const float *d = D + 4 * j + axis;
            across[j] = BEZIER_QUADRATIC(d0, d1, d2, (float8)(d[0]), (float8)(d[16]), (float8)(d[32]));
        }
        BEZIER_TO_POWERS(q + 4 * axis, across[0], across[1], across[2], across[3])
        const float8 *m = block->point + 4 * axis;
        r[3 * axis] = m[1] * (scale * (1.0f / 3.0f));
        r[3 * axis + 1] = m[2] * (scale * (2.0f / 3.0f));
        r[3 * axis + 2] = m[3] * scale;
        ends[0][axis] = across[0], ends[1][axis] = across[3];
        ends[2][axis] = (curve[1] - curve[0]) * scale, ends[3][axis] = (curve[3] - curve[2]) * scale;
#endif
    }
#if NORMALS
    bezier_crossed(block->normal, q + 4, r + 6, q + 8, r + 3);
    bezier_crossed(block->normal + 6, q + 8, r, q, r + 6);
    bezier_crossed(block->normal + 12, q, r + 3, q + 4, r);
    const float8 u = vload8(0, w + 7 * s) + 0.5f;
    bezier_block_unit(&block->first, q_first, r_first, patch, u, 0.0f);
    bezier_block_unit(&block->last, q_last, r_last, patch, u, 1.0f);
    const planes8 q_middle = {q[0], q[4], q[8]}, r_middle = {r[0], r[3], r[6]};
    bezier_block_unit(&block->middle, q_middle, r_middle, patch, u, 0.5f);
#endif
}
