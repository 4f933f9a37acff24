// Shuffles of eight lanes, and the 4 x 4 transposes that turn records into planes and back.
//
// Source    none; two steps of shuffles within 128-bit halves, as the registers have them
// Work      functions only
// Reads     nothing
// Writes    nothing

// single shuffles where the compiler has a name for them: it does not find its way back from lists of lanes
#ifdef __clang__
#define SHUFFLE8(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#define SHUFFLE16 SHUFFLE8
#else
#define SHUFFLE8(a, b, ...) shuffle2(a, b, (uint8)(__VA_ARGS__))
#define SHUFFLE16(a, b, ...) shuffle2(a, b, (uint16)(__VA_ARGS__))
#endif

typedef struct {
    float8 x, y, z, w;
} fours8;

// Two transposes at once, one in each half. Rows p q r s hold records 0 4 | 1 5 | 2 6 | 3 7: out come the planes of eight
// records, lanes 0 to 7. It is its own inverse: planes x y z w in, rows of records 0 4 | 1 5 | 2 6 | 3 7 out
static inline __attribute__((always_inline)) fours8 transpose_fours(
    const float8 p, const float8 q, const float8 r, const float8 s)
{
    const float8 pq = SHUFFLE8(p, q, 0, 8, 1, 9, 4, 12, 5, 13), pq2 = SHUFFLE8(p, q, 2, 10, 3, 11, 6, 14, 7, 15);
    const float8 rs = SHUFFLE8(r, s, 0, 8, 1, 9, 4, 12, 5, 13), rs2 = SHUFFLE8(r, s, 2, 10, 3, 11, 6, 14, 7, 15);
    fours8 t;
    t.x = SHUFFLE8(pq, rs, 0, 1, 8, 9, 4, 5, 12, 13);
    t.y = SHUFFLE8(pq, rs, 2, 3, 10, 11, 6, 7, 14, 15);
    t.z = SHUFFLE8(pq2, rs2, 0, 1, 8, 9, 4, 5, 12, 13);
    t.w = SHUFFLE8(pq2, rs2, 2, 3, 10, 11, 6, 7, 14, 15);
    return t;
}
