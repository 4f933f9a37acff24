// Unit normals of surfaces out of two tangents, one or eight at a time, and which of them have no direction.
//
// Source    none
// Work      functions only; what is fused says so with fma
// Reads     nothing
// Writes    nothing
// Needs     common/packed.cl

#pragma OPENCL FP_CONTRACT OFF

#define DEGENERATE 1e-11f // squared length of a scaled normal that is none; as in each family's reference.py
#define INWARDS 0x1p-10f  // how far towards the middle the normal is looked for then

static inline float3 normals_cross(const float3 a, const float3 b)
{
    return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline float normals_square(const float3 a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

// `n` as a unit; (0, 0, 1) where there is no direction left
static inline float3 normals_unit(const float3 n)
{
    const float square = normals_square(n);
    return square > 1e-30f ? n * (1.0f / sqrt(square)) : (float3)(0.0f, 0.0f, 1.0f);
}

// eight of any length as units; returns the lanes that have no direction
static inline int8 normals_unit8(planes8 *unit, const planes8 n)
{
    const float8 square = fma(n.z, n.z, fma(n.y, n.y, n.x * n.x)), scale = float8_rsqrt(square);
    unit->x = n.x * scale, unit->y = n.y * scale, unit->z = n.z * scale;
    return square <= DEGENERATE;
}

// units along a x b; returns the lanes that have no direction
static inline int8 normals_cross8(planes8 *unit, const planes8 a, const planes8 b)
{
    const planes8 n = {fma(a.y, b.z, -(a.z * b.y)), fma(a.z, b.x, -(a.x * b.z)), fma(a.x, b.y, -(a.y * b.x))};
    return normals_unit8(unit, n);
}

static inline bool normals_any(const int8 mask)
{
#if defined(__AVX__) && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_movmskps256)
#define NORMALS_ANY 1
    return __builtin_ia32_movmskps256(as_float8(mask)) != 0;
#endif
#endif
#ifndef NORMALS_ANY
    const ulong4 words = as_ulong4(mask);
    return (words.x | words.y | words.z | words.w) != 0;
#endif
}
