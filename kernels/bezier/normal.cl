// Unit normals of a bicubic patch, also where Q_u x Q_v vanishes, as at a collapsed edge.
//
// Source    Concheiro 2013, section 1.2; where there is no normal, that of a place a little nearer to the patch's middle is
//           taken (reconstruction)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     bezier/patch.cl
// Plain     bezier/reference.py

#pragma OPENCL FP_CONTRACT OFF

#define DEGENERATE 1e-11f // as in reference.py
#define INWARDS 0x1p-10f

static inline float3 bezier_cross(const float3 a, const float3 b)
{
    return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// Q_u x Q_v at one place, scaled
static inline float3 bezier_cross_at(const bezier_patch *patch, const float u, const float v)
{
    const float s = 1.0f - u, t = 1.0f - v;
    const float16 a = patch->rows[0] * patch->scale, b = patch->rows[1] * patch->scale;
    const float16 c = patch->rows[2] * patch->scale, d = patch->rows[3] * patch->scale;
    const float16 r = BEZIER_CUBIC(s * s * s, 3.0f * s * s * u, 3.0f * s * u * u, u * u * u, a, b, c, d);
    const float16 q = BEZIER_QUADRATIC(s * s, 2.0f * s * u, u * u, b - a, c - b, d - c);
    const float4 along_u = BEZIER_CUBIC(
        t * t * t, 3.0f * t * t * v, 3.0f * t * v * v, v * v * v, q.s0123, q.s4567, q.s89ab, q.scdef);
    const float4 along_v = BEZIER_QUADRATIC(
        t * t, 2.0f * t * v, v * v, r.s4567 - r.s0123, r.s89ab - r.s4567, r.scdef - r.s89ab);
    return bezier_cross(along_u.xyz, along_v.xyz);
}

static inline float bezier_square(const float3 a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

// `n` as a unit; where it is none, that of a place nearer to the middle
static inline float3 bezier_unit(float3 n, const bezier_patch *patch, const float u, const float v)
{
    float square = bezier_square(n);
    if (square <= DEGENERATE) {
        n = bezier_cross_at(patch, u + INWARDS * (0.5f - u), v + INWARDS * (0.5f - v));
        square = bezier_square(n);
    }
    return square > 1e-30f ? n * (1.0f / sqrt(square)) : (float3)(0.0f, 0.0f, 1.0f);
}

// units along q x r; returns the lanes that have none
static inline int8 bezier_unit8(planes8 *unit, const planes8 q, const planes8 r)
{
    const planes8 n = {fma(q.y, r.z, -(q.z * r.y)), fma(q.z, r.x, -(q.x * r.z)), fma(q.x, r.y, -(q.y * r.x))};
    const float8 square = fma(n.z, n.z, fma(n.y, n.y, n.x * n.x)), scale = float8_rsqrt(square);
    unit->x = n.x * scale, unit->y = n.y * scale, unit->z = n.z * scale;
    return square <= DEGENERATE;
}

static inline bool bezier_any(const int8 mask)
{
#if defined(__AVX__) && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_movmskps256)
#define BEZIER_ANY 1
    return __builtin_ia32_movmskps256(as_float8(mask)) != 0;
#endif
#endif
#ifndef BEZIER_ANY
    const ulong4 words = as_ulong4(mask);
    return (words.x | words.y | words.z | words.w) != 0;
#endif
}
