// Lengths on the screen of curves across eight KSQuads of a row, a KSQuad to a lane: their sides, and their middles.
//
// Source    Concheiro 2013, section 6.3 (KSDice sampling; its formulas were not at hand: a reconstruction): the polyline
//           through five points of a curve
// Work      functions only; what is fused says so with fma
// Reads     fives   float[64 * records]  as nurbs/rpns/curves.cl has them
//           places  float[5 * 8 * stride]  the same by place, control point and record: eight records are a vector
// Writes    nothing
// Needs     common/transpose.cl
// Plain     nurbs/rpns/sampling.py
// Defines   UNIFORM (1: places are even, and breaks are not asked for)

#pragma OPENCL FP_CONTRACT OFF

#define LOW 0 // places
#define MIDDLE 2
#define HIGH 4
#define ALONG_V 0 // which way curves go
#define ALONG_U 1
#define PLACES 5
#define NEAREST_W 1e-20f // in front of the eye

typedef struct {
    float8 x, y, w; // pixels times w
} screen8;

static inline void rpns_screen_add(screen8 *sum, const float8 share, const screen8 a)
{
    sum->x = fma(share, a.x, sum->x), sum->y = fma(share, a.y, sum->y), sum->w = fma(share, a.w, sum->w);
}

// basis function of control point l at a place, of eight spans
static inline float8 rpns_share(__global const float *places, const uint stride, const uint place, const uint l)
{
    return vload8(0, places + (8 * place + l) * stride);
}

// segments that the curves of `along` + 1 control points ask for, and the breaks of each at three places: of those along u
// all basis functions are alike, those along v have their own
static inline __attribute__((always_inline)) fours8 rpns_measured(const screen8 *curve, __global const float *five,
    __global const float *places, const uint stride, const uint along, const float side, const float finest)
{
    const float8 zero = (float8)(0.0f);
    float8 before_x = zero, before_y = zero, ends[PLACES];
    int8 seen = (int8)(-1);
    ends[0] = zero;
    for (uint place = 0; place < PLACES; ++place) {
        screen8 at = {zero, zero, zero};
        for (uint l = 0; l <= along; ++l)
            rpns_screen_add(&at, five ? (float8)(five[8 * l + place]) : rpns_share(places, stride, place, l), curve[l]);
        seen &= at.w > NEAREST_W;
        const float8 inverse = 1.0f / at.w, x = at.x * inverse, y = at.y * inverse, a = x - before_x, b = y - before_y;
        if (place) ends[place] = ends[place - 1] + sqrt(a * a + b * b);
        before_x = x, before_y = y;
    }
    const float8 total = ends[4];
    seen &= total < 1e30f;
    fours8 found = {zero, (float8)(0.25f), (float8)(0.5f), (float8)(0.75f)};
    // where some of it is behind the eye the length is infinite
    const int8 fits = seen & (total < side * finest);
    const float8 wanted = fmax(ceil(as_float8(fits & as_int8(total)) / side), (float8)(1.0f));
    found.x = as_float8((fits & as_int8(wanted)) | (~fits & as_int8((float8)(finest))));
#if !UNIFORM
    // each part has some share at the least, so that no place is at the end of two
    const int8 shared = seen & (total > 1e-20f);
    const float8 part = 0.05f * total, share = 1.0f / (1.2f * total);
    float8 breaks[3] = {found.y, found.z, found.w};
    for (uint k = 0; k < 3; ++k) {
        const float8 end = (ends[k + 1] + (float)(k + 1) * part) * share;
        breaks[k] = as_float8((shared & as_int8(end)) | (~shared & as_int8(breaks[k])));
    }
    found.y = breaks[0], found.z = breaks[1], found.w = breaks[2];
#endif
    return found;
}

// of the curves along u at a place of v, or along v at a place of u
static inline __attribute__((always_inline)) fours8 rpns_along(const screen8 *net, __global const float *five,
    __global const float *places, const uint stride, const bool by_u, const uint place, const uint p, const uint q,
    const float side, const float finest)
{
    const uint along = by_u ? p : q, across = by_u ? q : p, row = by_u ? 8 : 1, column = by_u ? 1 : 8;
    screen8 curve[8];
    for (uint k = 0; k <= along; ++k) {
        const screen8 none = {(float8)(0.0f), (float8)(0.0f), (float8)(0.0f)};
        curve[k] = none;
        for (uint l = 0; l <= across; ++l) {
            const float8 share = by_u ? rpns_share(places, stride, place, l) : (float8)(five[8 * l + place]);
            rpns_screen_add(&curve[k], share, net[row * k + column * l]);
        }
    }
    return rpns_measured(curve, by_u ? five : 0, places, stride, along, side, finest);
}

// rows of four of the first `count` lanes, `apart` rows from each other
static inline void rpns_put_fours(__global float *rows, const uint apart, const fours8 found, const uint count)
{
    const fours8 t = transpose_fours(found.x, found.y, found.z, found.w);
    const float4 lanes[8] = {t.x.lo, t.y.lo, t.z.lo, t.w.lo, t.x.hi, t.y.hi, t.z.hi, t.w.hi};
    for (uint lane = 0; lane < count; ++lane) vstore4(lanes[lane], (size_t)lane * apart, rows);
}
