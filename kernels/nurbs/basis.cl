// The basis functions of B-splines at samples, eight of one span at a time: by the stair strategy, and two ways to compare.
//
// Source    Concheiro 2013, section 6.5 (stair strategy; its formulas were not at hand: a reconstruction); Piegl & Tiller,
//           The NURBS Book, 1997, algorithms A2.2 (triangular table) and A2.4 (Cox-de Boor, one function at a time)
// Work      1-D, one item per octet of samples; all of an octet lie on one span
// Reads     octets   uint [4 * octet_count]   first sample, how many, span record, degree
//           spans    float[48 * records]      as nurbs/triangle.cl has them
//           places   float[2 * stride]        t and 1 - t of each sample, 0..1 on its span
// Writes    weights  float[15 * stride]       planes N_{i-p} .. N_i, then from plane 8 on the p weights of the differences
//                                             of control points that make the slope
// Needs     nurbs/triangle.cl
// Plain     nurbs/reference.py
// Defines   BASIS (0: stair, 1: triangle, 2: Cox-de Boor), NORMALS (1: slopes too), MOST_DEGREE
//           (3, 5, 7: what is more is not built)

#pragma OPENCL FP_CONTRACT OFF

#define PLANES 8 // of values; those of slopes follow

#if BASIS == 0
// sums of products: each path climbs from degree d with r steps down, and what it has is its own; no loop, no table
#define NURBS_CLIMB(height, next)                                                                                      \
    static inline __attribute__((always_inline)) void nurbs_climb##height(float8 *values, float8 *slopes,              \
        __global const float *span, const float8 t, const float8 s, const float8 product, const uint d, const uint r)  \
    {                                                                                                                  \
        const float inverse = span[16 + NURBS_WIDTH(d, r)];                                                            \
        if (height == 1) slopes[r] += product;                                                                         \
        next(values, slopes, span, t, s, product * ((t + span[r]) * inverse), d + 1, r);                               \
        next(values, slopes, span, t, s, product * ((s + span[7 + d - r]) * inverse), d + 1, r + 1);                   \
    }
#define NURBS_ARRIVED(values, slopes, span, t, s, product, d, r) values[r] += product
NURBS_CLIMB(1, NURBS_ARRIVED)
NURBS_CLIMB(2, nurbs_climb1)
NURBS_CLIMB(3, nurbs_climb2)
NURBS_CLIMB(4, nurbs_climb3)
NURBS_CLIMB(5, nurbs_climb4)
NURBS_CLIMB(6, nurbs_climb5)
NURBS_CLIMB(7, nurbs_climb6)

static inline void nurbs_basis8(
    float8 *values, float8 *slopes, __global const float *span, const float8 t, const float8 s, const uint p)
{
    const float8 one = (float8)(1.0f);
    for (uint k = 0; k < 8; ++k) values[k] = slopes[k] = (float8)(0.0f);
    switch (p) {
    case 1: nurbs_climb1(values, slopes, span, t, s, one, 1, 0); break;
    case 2: nurbs_climb2(values, slopes, span, t, s, one, 1, 0); break;
    case 3: nurbs_climb3(values, slopes, span, t, s, one, 1, 0); break;
#if MOST_DEGREE > 3
    case 4: nurbs_climb4(values, slopes, span, t, s, one, 1, 0); break;
    case 5: nurbs_climb5(values, slopes, span, t, s, one, 1, 0); break;
#endif
#if MOST_DEGREE > 5
    case 6: nurbs_climb6(values, slopes, span, t, s, one, 1, 0); break;
    case 7: nurbs_climb7(values, slopes, span, t, s, one, 1, 0); break;
#endif
    }
    for (uint r = 0; r < p; ++r) slopes[r] *= (float)p * span[16 + NURBS_WIDTH(p, r)];
}
#elif BASIS == 1
#define nurbs_basis8 nurbs_triangle8
#else
// knot x_{i+a} less x_i over h
static inline float nurbs_knot(__global const float *span, const int a) { return a > 0 ? 1.0f + span[7 + a] : -span[-a]; }

// N_{i-k,degree} by the recursion's own cells, each function by itself, 0 / 0 being 0
static inline float8 nurbs_one(__global const float *span, const float8 t, const int k, const int degree)
{
    float8 cells[8];
    for (int j = 0; j <= degree; ++j) cells[j] = (float8)(j == k ? 1.0f : 0.0f);
    for (int d = 1; d <= degree; ++d)
        for (int j = 0; j <= degree - d; ++j) {
            const int a = j - k;
            const float low = nurbs_knot(span, a), high = nurbs_knot(span, a + d + 1);
            const float left = nurbs_knot(span, a + d) - low, right = high - nurbs_knot(span, a + 1);
            const float8 first = left > 0.0f ? (t - low) / left * cells[j] : (float8)(0.0f);
            const float8 second = right > 0.0f ? (high - t) / right * cells[j + 1] : (float8)(0.0f);
            cells[j] = first + second;
        }
    return cells[0];
}

static inline void nurbs_basis8(
    float8 *values, float8 *slopes, __global const float *span, const float8 t, const float8 s, const uint p)
{
    for (uint k = 0; k <= p; ++k) values[k] = nurbs_one(span, t, (int)k, (int)p);
#if NORMALS
    for (uint r = 0; r < p; ++r)
        slopes[r] = nurbs_one(span, t, (int)r, (int)p - 1) * ((float)p * span[16 + NURBS_WIDTH(p, r)]);
#endif
}
#endif

static inline void nurbs_basis_put(__global float *place, const float8 values, const uint count)
{
    if (count == 8) {
        vstore8(values, 0, place);
    } else {
        float some[8];
        vstore8(values, 0, some);
        for (uint k = 0; k < count; ++k) place[k] = some[k];
    }
}

__kernel void nurbs_basis(
    __global const uint *restrict octets,
    __global const float *restrict spans,
    __global const float *restrict places,
    __global float *restrict weights,
    const uint stride,
    const uint octet_count)
{
    const uint octet = get_global_id(0);
    if (octet >= octet_count) return;

    const uint4 row = vload4(octet, octets);
    const uint first = row.x, count = row.y, p = row.w;
    float8 values[8], slopes[8];
    __global const float *span = spans + SPAN_FLOATS * row.z;
    const float8 t = vload8(0, places + first), s = vload8(0, places + stride + first);
    nurbs_basis8(values, slopes, span, t, s, p);
    for (uint k = 0; k <= p; ++k) nurbs_basis_put(weights + (p - k) * stride + first, values[k], count);
#if NORMALS
    for (uint r = 0; r < p; ++r) nurbs_basis_put(weights + (PLANES + p - 1 - r) * stride + first, slopes[r], count);
#endif
}
