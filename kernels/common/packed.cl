// Eight 3-vectors at a time: planes of x, y and z in registers, packed x y z x y z in memory.
//
// Source    none; the order of shuffles is that of a transposition of eight rows of three in 128-bit halves
// Work      functions only; what is fused says so with fma, so that equal sums of equal numbers are equal to the bit
// Reads     nothing
// Writes    nothing
// Needs     common/transpose.cl
// Defines   STREAMING  1: stores go past the caches, for outputs that are larger than they are; else 0

#pragma OPENCL FP_CONTRACT OFF

typedef struct {
    float8 x, y, z;
} planes8;

#define PACKED_STORE(value, place) (*(__global float8 *)(place) = (value))
#if defined(STREAMING) && STREAMING && defined(__x86_64__) && defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#undef PACKED_STORE
#define PACKED_STORE(value, place) __builtin_nontemporal_store(value, (__global float8 *)(place))
#endif
#endif

typedef struct {
    float8 first, second, third;
} packed8;

static inline packed8 packed_rows(const planes8 a)
{
    const float8 xy = SHUFFLE8(a.x, a.y, 0, 2, 8, 10, 4, 6, 12, 14);
    const float8 yz = SHUFFLE8(a.y, a.z, 1, 3, 9, 11, 5, 7, 13, 15);
    const float8 zx = SHUFFLE8(a.z, a.x, 0, 2, 9, 11, 4, 6, 13, 15);
    const float8 r03 = SHUFFLE8(xy, zx, 0, 2, 8, 10, 4, 6, 12, 14);
    const float8 r14 = SHUFFLE8(yz, xy, 0, 2, 9, 11, 4, 6, 13, 15);
    const float8 r25 = SHUFFLE8(zx, yz, 1, 3, 9, 11, 5, 7, 13, 15);
    packed8 rows;
    rows.first = SHUFFLE8(r03, r14, 0, 1, 2, 3, 8, 9, 10, 11);
    rows.second = SHUFFLE8(r25, r03, 0, 1, 2, 3, 12, 13, 14, 15);
    rows.third = SHUFFLE8(r14, r25, 4, 5, 6, 7, 12, 13, 14, 15);
    return rows;
}

// whole vectors of memory, `packed` a multiple of 32 bytes
static inline void packed_store8(const planes8 a, __global float *packed)
{
    const packed8 rows = packed_rows(a);
    PACKED_STORE(rows.first, packed);
    PACKED_STORE(rows.second, packed + 8);
    PACKED_STORE(rows.third, packed + 16);
}

// Points and normals that are to be one vector of memory but come in parts, as where one primitive ends and the next
// begins: only whole vectors go past the caches, since a line that is written both ways costs a fetch.
typedef struct {
    float positions[48], normals[48]; // twice a vector: parts are stored as if they were whole
    uint first, end;                  // lanes that are the work-item's own
} packed_stage;

// lanes first .. end - 1 go to their places after `vector`, the vertex of lane 0
static inline void packed_stage_flush(
    packed_stage *stage, const ulong vector, __global float *positions, __global float *normals)
{
    positions += 3 * vector;
    normals += 3 * vector;
    if (stage->first == 0 && stage->end == 8) {
        for (uint i = 0; i < 3; ++i) PACKED_STORE(vload8(i, stage->positions), positions + 8 * i);
        for (uint i = 0; i < 3; ++i) PACKED_STORE(vload8(i, stage->normals), normals + 8 * i);
    } else {
        for (uint f = 3 * stage->first; f < 3 * stage->end; ++f) {
            positions[f] = stage->positions[f];
            normals[f] = stage->normals[f];
        }
    }
    stage->first = stage->end = 0;
}

// the first `count` of p and n are vertices v, v + 1 .. of the same vector; written when that is full
static inline void packed_stage_put(packed_stage *stage, const planes8 p, const planes8 n, const uint count,
    const ulong v, __global float *positions, __global float *normals)
{
    const uint lane = (uint)v & 7;
    const packed8 rows_p = packed_rows(p), rows_n = packed_rows(n);
    vstore8(rows_p.first, 0, stage->positions + 3 * lane);
    vstore8(rows_p.second, 1, stage->positions + 3 * lane);
    vstore8(rows_p.third, 2, stage->positions + 3 * lane);
    vstore8(rows_n.first, 0, stage->normals + 3 * lane);
    vstore8(rows_n.second, 1, stage->normals + 3 * lane);
    vstore8(rows_n.third, 2, stage->normals + 3 * lane);
    stage->end = lane + count;
    if (stage->end == 8) packed_stage_flush(stage, v - lane, positions, normals);
}

// origin + u a + v b, lane by lane
static inline planes8 planes8_span(const float8 u, const float8 v, const float3 origin, const float3 a, const float3 b)
{
    planes8 sum;
    sum.x = fma(v, (float8)(b.x), fma(u, (float8)(a.x), (float8)(origin.x)));
    sum.y = fma(v, (float8)(b.y), fma(u, (float8)(a.y), (float8)(origin.y)));
    sum.z = fma(v, (float8)(b.z), fma(u, (float8)(a.z), (float8)(origin.z)));
    return sum;
}

// a where the lane's mask is set, else b
static inline float8 float8_pick(const int8 mask, const float8 a, const float8 b)
{
    return as_float8((as_int8(a) & mask) | (as_int8(b) & ~mask));
}

static inline planes8 planes8_pick(const int8 mask, const planes8 a, const planes8 b)
{
    planes8 picked;
    picked.x = float8_pick(mask, a.x, b.x);
    picked.y = float8_pick(mask, a.y, b.y);
    picked.z = float8_pick(mask, a.z, b.z);
    return picked;
}

// 1 / sqrt(x) to 2 units in the last place, 1e-30 < x < 1e30: half the exponent, to 3 %, then a step of Halley's and one of
// Newton's. Root and division share one slow unit, and what processors have in their place rounds as each likes
static inline float8 float8_rsqrt(const float8 x)
{
    const float8 start = as_float8(0x5f375a86 - (as_int8(x) >> 1));
    const float8 h = fma(-(x * start), start, (float8)(1.0f));
    const float8 y = fma(start * h, fma(h, (float8)(0.375f), (float8)(0.5f)), start);
    return fma(0.5f * y, fma(-(x * y), y, (float8)(1.0f)), y);
}

// unit length; (0, 0, 1) where there is no direction left
static inline planes8 planes8_normalise(const planes8 a)
{
    const float8 square = fma(a.z, a.z, fma(a.y, a.y, a.x * a.x));
    const int8 has_length = square > 1e-30f;
    const float8 scale = as_float8(as_int8(float8_rsqrt(square)) & has_length);
    planes8 unit;
    unit.x = a.x * scale;
    unit.y = a.y * scale;
    unit.z = float8_pick(has_length, a.z * scale, (float8)(1.0f)); // and not -1 for a small negative z
    return unit;
}
