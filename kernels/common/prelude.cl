// The standard built-ins as operators and inline functions, joined in front on CPUs: one result on every driver.
//
// Source    none: OpenCL leaves open what mad, mix, dot, rsqrt and their like round to, and drivers differ in it; and some
//           PoCL builds cannot inline their library into kernels: a call per built-in costs 5 to 60 times
// Work      functions only; names, argument types and results are OpenCL's, except that NaN ordering is unspecified
// Reads     nothing
// Writes    nothing
// Defines   LB_KEEPS_EXACT: built-ins that have one right result stay the driver's, which inlines them

#if __has_builtin(__builtin_elementwise_min)  // clang 14 or later
#define LB_INLINE static inline __attribute__((overloadable, always_inline))

#ifndef LB_KEEPS_EXACT
// comparison and arithmetic, one body for every width; mixed vector-scalar forms where OpenCL has them
#define LB_ORDER(T)                                                                                                    \
    LB_INLINE T lb_min(T a, T b) { return __builtin_elementwise_min(a, b); }                                           \
    LB_INLINE T lb_max(T a, T b) { return __builtin_elementwise_max(a, b); }                                           \
    LB_INLINE T lb_clamp(T x, T low, T high) { return lb_min(lb_max(x, low), high); }
#define LB_ORDER_SCALAR(V, S)                                                                                          \
    LB_INLINE V lb_min(V a, S b) { return lb_min(a, (V)(b)); }                                                         \
    LB_INLINE V lb_max(V a, S b) { return lb_max(a, (V)(b)); }                                                         \
    LB_INLINE V lb_clamp(V x, S low, S high) { return lb_clamp(x, (V)(low), (V)(high)); }
#define LB_ORDER_ALL(S)                                                                                                \
    LB_ORDER(S) LB_ORDER(S##2) LB_ORDER(S##3) LB_ORDER(S##4) LB_ORDER(S##8) LB_ORDER(S##16)                            \
    LB_ORDER_SCALAR(S##2, S) LB_ORDER_SCALAR(S##3, S) LB_ORDER_SCALAR(S##4, S)                                         \
    LB_ORDER_SCALAR(S##8, S) LB_ORDER_SCALAR(S##16, S)
LB_ORDER_ALL(float)
LB_ORDER_ALL(int)
LB_ORDER_ALL(uint)
LB_ORDER_ALL(long)
LB_ORDER_ALL(ulong)

#define LB_FLOAT(T)                                                                                                    \
    LB_INLINE T lb_fabs(T a) { return __builtin_elementwise_abs(a); }                                                  \
    LB_INLINE T lb_floor(T a) { return __builtin_elementwise_floor(a); }                                               \
    LB_INLINE T lb_ceil(T a) { return __builtin_elementwise_ceil(a); }                                                 \
    LB_INLINE T lb_trunc(T a) { return __builtin_elementwise_trunc(a); }
LB_FLOAT(float) LB_FLOAT(float2) LB_FLOAT(float3) LB_FLOAT(float4) LB_FLOAT(float8) LB_FLOAT(float16)
// fma keeps its single rounding: where the target has the instruction, a contracted sum of the whole vector is one.
// Elsewhere, and for the root below, all lanes in one list: the compiler makes half-width instructions of two halves
#ifdef __FMA__
#define LB_FMA(T)                                                                                                      \
    LB_INLINE T lb_fma(T a, T b, T c)                                                                                  \
    {                                                                                                                  \
        _Pragma("OPENCL FP_CONTRACT ON") return a * b + c;                                                             \
    }
LB_FMA(float) LB_FMA(float2) LB_FMA(float3) LB_FMA(float4) LB_FMA(float8) LB_FMA(float16)
#else
LB_INLINE float lb_fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
LB_INLINE float2 lb_fma(float2 a, float2 b, float2 c) { return (float2)(lb_fma(a.x, b.x, c.x), lb_fma(a.y, b.y, c.y)); }
LB_INLINE float3 lb_fma(float3 a, float3 b, float3 c) { return (float3)(lb_fma(a.xy, b.xy, c.xy), lb_fma(a.z, b.z, c.z)); }
LB_INLINE float4 lb_fma(float4 a, float4 b, float4 c)
{
    return (float4)(__builtin_fmaf(a.s0, b.s0, c.s0), __builtin_fmaf(a.s1, b.s1, c.s1),
        __builtin_fmaf(a.s2, b.s2, c.s2), __builtin_fmaf(a.s3, b.s3, c.s3));
}
LB_INLINE float8 lb_fma(float8 a, float8 b, float8 c)
{
    return (float8)(__builtin_fmaf(a.s0, b.s0, c.s0), __builtin_fmaf(a.s1, b.s1, c.s1),
        __builtin_fmaf(a.s2, b.s2, c.s2), __builtin_fmaf(a.s3, b.s3, c.s3), __builtin_fmaf(a.s4, b.s4, c.s4),
        __builtin_fmaf(a.s5, b.s5, c.s5), __builtin_fmaf(a.s6, b.s6, c.s6), __builtin_fmaf(a.s7, b.s7, c.s7));
}
LB_INLINE float16 lb_fma(float16 a, float16 b, float16 c)
{
    return (float16)(__builtin_fmaf(a.s0, b.s0, c.s0), __builtin_fmaf(a.s1, b.s1, c.s1),
        __builtin_fmaf(a.s2, b.s2, c.s2), __builtin_fmaf(a.s3, b.s3, c.s3), __builtin_fmaf(a.s4, b.s4, c.s4),
        __builtin_fmaf(a.s5, b.s5, c.s5), __builtin_fmaf(a.s6, b.s6, c.s6), __builtin_fmaf(a.s7, b.s7, c.s7),
        __builtin_fmaf(a.s8, b.s8, c.s8), __builtin_fmaf(a.s9, b.s9, c.s9), __builtin_fmaf(a.sa, b.sa, c.sa),
        __builtin_fmaf(a.sb, b.sb, c.sb), __builtin_fmaf(a.sc, b.sc, c.sc), __builtin_fmaf(a.sd, b.sd, c.sd),
        __builtin_fmaf(a.se, b.se, c.se), __builtin_fmaf(a.sf, b.sf, c.sf));
}
#endif

// unaligned vector memory: a vector type that promises only its scalar's alignment, so that one move does it
#define LB_MEMORY_SPACE(S, N, SPACE)                                                                                   \
    LB_INLINE S##N lb_vload##N(size_t i, const SPACE S *p) { return *(const SPACE lb_##S##N *)(p + i * N); }
#define LB_MEMORY(S, N)                                                                                                \
    typedef S##N lb_##S##N __attribute__((aligned(sizeof(S))));                                                        \
    LB_MEMORY_SPACE(S, N, __global) LB_MEMORY_SPACE(S, N, __local)                                                     \
    LB_MEMORY_SPACE(S, N, __constant) LB_MEMORY_SPACE(S, N, __private)                                                 \
    LB_INLINE void lb_vstore##N(S##N v, size_t i, __global S *p) { *(__global lb_##S##N *)(p + i * N) = v; }           \
    LB_INLINE void lb_vstore##N(S##N v, size_t i, __local S *p) { *(__local lb_##S##N *)(p + i * N) = v; }             \
    LB_INLINE void lb_vstore##N(S##N v, size_t i, __private S *p) { *(__private lb_##S##N *)(p + i * N) = v; }
// three lanes have no vector move of their own size
#define LB_MEMORY_THREE_SPACE(S, SPACE)                                                                                \
    LB_INLINE S##3 lb_vload3(size_t i, const SPACE S *p) { return (S##3)(p[3 * i], p[3 * i + 1], p[3 * i + 2]); }
#define LB_STORE_THREE_SPACE(S, SPACE)                                                                                 \
    LB_INLINE void lb_vstore3(S##3 v, size_t i, SPACE S *p) { p[3 * i] = v.x; p[3 * i + 1] = v.y; p[3 * i + 2] = v.z; }
#define LB_MEMORY_ALL(S)                                                                                               \
    LB_MEMORY(S, 2) LB_MEMORY(S, 4) LB_MEMORY(S, 8) LB_MEMORY(S, 16)                                                   \
    LB_MEMORY_THREE_SPACE(S, __global) LB_MEMORY_THREE_SPACE(S, __local)                                               \
    LB_MEMORY_THREE_SPACE(S, __constant) LB_MEMORY_THREE_SPACE(S, __private)                                           \
    LB_STORE_THREE_SPACE(S, __global) LB_STORE_THREE_SPACE(S, __local) LB_STORE_THREE_SPACE(S, __private)
LB_MEMORY_ALL(float)
LB_MEMORY_ALL(int)
LB_MEMORY_ALL(uint)
LB_MEMORY_ALL(long)
LB_MEMORY_ALL(ulong)
LB_MEMORY_ALL(uchar)

LB_INLINE uint lb_popcount(uint a) { return (uint)__builtin_popcount(a); }
LB_INLINE ulong lb_popcount(ulong a) { return (ulong)__builtin_popcountl(a); }
LB_INLINE uint lb_clz(uint a) { return a ? (uint)__builtin_clz(a) : 32u; }
LB_INLINE ulong lb_clz(ulong a) { return a ? (ulong)__builtin_clzl(a) : 64ul; }

// PoCL drops its own; the line that holds the address is what a CPU can ask for, whatever the count
#define lb_prefetch(address, count) __builtin_prefetch((const void *)(size_t)(address))
#endif
#define LB_SUMS(T)                                                                                                     \
    LB_INLINE T lb_mad(T a, T b, T c) { return a * b + c; }                                                            \
    LB_INLINE T lb_mix(T a, T b, T t) { return a + (b - a) * t; }
LB_SUMS(float) LB_SUMS(float2) LB_SUMS(float3) LB_SUMS(float4) LB_SUMS(float8) LB_SUMS(float16)
#define LB_MIX_SCALAR(V) LB_INLINE V lb_mix(V a, V b, float t) { return a + (b - a) * t; }
LB_MIX_SCALAR(float2) LB_MIX_SCALAR(float3) LB_MIX_SCALAR(float4) LB_MIX_SCALAR(float8) LB_MIX_SCALAR(float16)

LB_INLINE float lb_sqrt(float a) { return __builtin_sqrtf(a); }
#ifdef cl_khr_fp64
LB_INLINE double lb_sqrt(double a) { return __builtin_sqrt(a); }
#endif
LB_INLINE float2 lb_sqrt(float2 a) { return (float2)(lb_sqrt(a.x), lb_sqrt(a.y)); }
LB_INLINE float3 lb_sqrt(float3 a) { return (float3)(lb_sqrt(a.x), lb_sqrt(a.y), lb_sqrt(a.z)); }
LB_INLINE float4 lb_sqrt(float4 a)
{
    return (float4)(__builtin_sqrtf(a.s0), __builtin_sqrtf(a.s1), __builtin_sqrtf(a.s2), __builtin_sqrtf(a.s3));
}
LB_INLINE float8 lb_sqrt(float8 a)
{
    return (float8)(__builtin_sqrtf(a.s0), __builtin_sqrtf(a.s1), __builtin_sqrtf(a.s2), __builtin_sqrtf(a.s3),
        __builtin_sqrtf(a.s4), __builtin_sqrtf(a.s5), __builtin_sqrtf(a.s6), __builtin_sqrtf(a.s7));
}
LB_INLINE float16 lb_sqrt(float16 a)
{
    return (float16)(__builtin_sqrtf(a.s0), __builtin_sqrtf(a.s1), __builtin_sqrtf(a.s2), __builtin_sqrtf(a.s3),
        __builtin_sqrtf(a.s4), __builtin_sqrtf(a.s5), __builtin_sqrtf(a.s6), __builtin_sqrtf(a.s7),
        __builtin_sqrtf(a.s8), __builtin_sqrtf(a.s9), __builtin_sqrtf(a.sa), __builtin_sqrtf(a.sb),
        __builtin_sqrtf(a.sc), __builtin_sqrtf(a.sd), __builtin_sqrtf(a.se), __builtin_sqrtf(a.sf));
}
#define LB_RSQRT(T) LB_INLINE T lb_rsqrt(T a) { return (T)(1.0f) / lb_sqrt(a); }
LB_RSQRT(float) LB_RSQRT(float2) LB_RSQRT(float3) LB_RSQRT(float4) LB_RSQRT(float8) LB_RSQRT(float16)

LB_INLINE float lb_dot(float2 a, float2 b) { return a.x * b.x + a.y * b.y; }
LB_INLINE float lb_dot(float3 a, float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
LB_INLINE float lb_dot(float4 a, float4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
LB_INLINE float3 lb_cross(float3 a, float3 b) { return a.yzx * b.zxy - a.zxy * b.yzx; }
#define LB_LENGTH(V)                                                                                                   \
    LB_INLINE float lb_length(V a) { return lb_sqrt(lb_dot(a, a)); }                                                   \
    LB_INLINE float lb_distance(V a, V b) { return lb_length(a - b); }                                                 \
    LB_INLINE V lb_normalize(V a)                                                                                      \
    {                                                                                                                  \
        const float square = lb_dot(a, a); /* a vector without a direction stays as it is */                           \
        return square > 0.0f ? a * (1.0f / lb_sqrt(square)) : a;                                                       \
    }
LB_LENGTH(float2) LB_LENGTH(float3) LB_LENGTH(float4)

// the names that kernels use
#define mad lb_mad
#define mix lb_mix
#define sqrt lb_sqrt
#define native_sqrt lb_sqrt
#define half_sqrt lb_sqrt
#define rsqrt lb_rsqrt
#define native_rsqrt lb_rsqrt
#define half_rsqrt lb_rsqrt
#define native_divide(a, b) ((a) / (b))
#define native_recip(a) (1.0f / (a))
#define dot lb_dot
#define cross lb_cross
#define length lb_length
#define fast_length lb_length
#define distance lb_distance
#define normalize lb_normalize
#define fast_normalize lb_normalize
#ifndef LB_KEEPS_EXACT
#undef min
#undef max
#define min lb_min
#define max lb_max
#define fmin lb_min
#define fmax lb_max
#define clamp lb_clamp
#define fma lb_fma
#define fabs lb_fabs
#define floor lb_floor
#define ceil lb_ceil
#define trunc lb_trunc
#define popcount lb_popcount
#define prefetch lb_prefetch
#define clz lb_clz
#define vload2 lb_vload2
#define vload3 lb_vload3
#define vload4 lb_vload4
#define vload8 lb_vload8
#define vload16 lb_vload16
#define vstore2 lb_vstore2
#define vstore3 lb_vstore3
#define vstore4 lb_vstore4
#define vstore8 lb_vstore8
#define vstore16 lb_vstore16
#endif
#endif
