// Screen space shared by the frame's stages: sub-pixels, tiles, and the depth-and-id key of a pixel.
//
// Source    Burns & Hunt 2013, "The visibility buffer", section 3 (one key per pixel, shading afterwards)
// Work      functions only; contraction is off, so that every stage and the reference round alike
// Reads     nothing
// Writes    nothing
// Needs     common/transpose.cl

#pragma OPENCL FP_CONTRACT OFF

#define SUBPIXELS 256         // per pixel and axis
#define GUARD 4194304.0f      // 2^22 sub-pixels: beyond it a triangle is clipped, so that edges fit in 32 bits
// the fourth word of a corner: 1 / w as float bits, or, where the corner must not be used as it is, a negative outcode
#define OUTSIDE (-0x7fffffff - 1)
#define OUTSIDE_NEAR 1
#define OUTSIDE_LEFT 2
#define OUTSIDE_RIGHT 4
#define OUTSIDE_TOP 8
#define OUTSIDE_BOTTOM 16
#define OUTSIDE_ANY 31

#define TILE 64               // pixels per side; a tile's keys are contiguous, rows of 64
#define TILE_PIXELS 4096
#define MAPS 16               // private maps at most, of one image
#define FLAGS_NEXT 8          // the next block of each range of triangles
#define FLAGS_RANGES 8
#define FLAGS_OPEN 16         // where the tiles' flags begin; the frame's counters stand before them
// depth 1.0 and an id that no triangle has: whatever lies beyond the far plane loses against it
#define KEY_EMPTY ((0x3f800000L << 32) | 0xffffffffL)

#define ID_EMPTY 0xffffffffu
#define LANE ((int8)(0, 1, 2, 3, 4, 5, 6, 7))

static inline int8 screen_round(const float8 a) { return convert_int8(floor(a + 0.5f)); }

// one instruction each: the built-ins take care of NaN, which is not needed here
#define LESSER(T) static inline T __attribute__((overloadable)) lesser(const T a, const T b) { return a < b ? a : b; }
#define GREATER(T) static inline T __attribute__((overloadable)) greater(const T a, const T b) { return a > b ? a : b; }
LESSER(float) LESSER(float8)
GREATER(float) GREATER(float8)

// bit k is set where lane k is negative, as a true comparison is
static inline uint lane_signs(const int8 a)
{
#ifdef __AVX__
    return (uint)__builtin_ia32_movmskps256(as_float8(a));
#else
    const ulong bytes = as_ulong(convert_uchar8(a >> 31)) & 0x0101010101010101UL;
    return (uint)((bytes * 0x0102040810204080UL) >> 56);
#endif
}

static inline int largest_lane(const int8 a)
{
    const int4 four = max(a.lo, a.hi);
    const int2 two = max(four.lo, four.hi);
    return max(two.x, two.y);
}

static inline uint smallest_lane(const uint8 a)
{
    const uint4 four = min(a.lo, a.hi);
    const uint2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
}
