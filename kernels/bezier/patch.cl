// A bicubic patch: its control points, and sums and powers of cubics.
//
// Source    Concheiro 2013, section 1.2: Q(u, v) = sum B_ij J_{3,i}(u) J_{3,j}(v)
// Work      functions only. Nothing of a sum is fused, and it pairs what lies opposite: a curve comes out alike from
//           either end, and at its ends is the control point there, so that neighbours agree to the bit
// Reads     controls  float[64 * patches]  of each patch 16 points x y z _, v fastest; the first one's fourth number is
//                                          the power of two that brings the patch's size near 1
// Writes    nothing
// Needs     common/output.cl
// Plain     bezier/reference.py

#pragma OPENCL FP_CONTRACT OFF

#define CONTROL_FLOATS 64

typedef struct {
    float16 rows[4];
    float scale;
} bezier_patch;

// sums that are the same from either end
#define BEZIER_CUBIC(w0, w1, w2, w3, a, b, c, d) (((w0) * (a) + (w3) * (d)) + ((w1) * (b) + (w2) * (c)))
#define BEZIER_QUADRATIC(w0, w1, w2, a, b, c) (((w0) * (a) + (w2) * (c)) + (w1) * (b))

static inline void bezier_patch_of(
    bezier_patch *patch, const float16 a, const float16 b, const float16 c, const float16 d)
{
    patch->rows[0] = a, patch->rows[1] = b, patch->rows[2] = c, patch->rows[3] = d;
    patch->scale = a.s3;
}

// patch p
static inline void bezier_patch_at(bezier_patch *patch, __global const float *restrict controls, const size_t p)
{
    __global const float *c = controls + CONTROL_FLOATS * p;
    bezier_patch_of(patch, vload16(0, c), vload16(1, c), vload16(2, c), vload16(3, c));
}

// a cubic's four control points as powers of t - 1/2, of any width; exact zeros where they are one
#define BEZIER_TO_POWERS(powers, a, b, c, d)                                                                           \
    (powers)[0] = 0.125f * ((a) + (d)) + 0.375f * ((b) + (c));                                                         \
    (powers)[1] = 0.75f * (((d) - (a)) + ((c) - (b)));                                                                 \
    (powers)[2] = 1.5f * (((a) - (b)) + ((d) - (c)));                                                                  \
    (powers)[3] = ((d) - (a)) - 3.0f * ((c) - (b));

static inline void bezier_powers(float4 *powers, const float16 controls)
{
    const float4 a = controls.s0123, b = controls.s4567, c = controls.s89ab, d = controls.scdef;
    BEZIER_TO_POWERS(powers, a, b, c, d)
}
