// Quadtree over a geometry image, fragment stage: which nodes are drawn?
//
// Source    Wang et al., section 3.2, steps 1-4; that the parent must itself be too coarse, not merely not drawn, and
//           the rule in pixels per node are a reconstruction
// Work      1-D, one item per run of RUN packed texels of one row; texels do not depend on each other
// Reads     errors  float[texel_count]           packed, never smaller than a child's
//           bounds  float[4 * texel_count / 3]   packed, upper part, four planes: x, y, z, radius; hold the children's
// Writes    states  uchar[texel_count]           0 too coarse: its children are looked at; 1 nothing to draw; 2 drawn
// Needs     common/quadtree.cl
// Plain     geometry_image/quadtree_lod/reference.py
// Defines   RUN   1, or a power of two from 16 to 2^n

// exactly one texel on each way from the root to a leaf is drawn: the first that is fine enough, or the leaf.
// The four nodes of depth 1 are the coarsest: the root's corners are one point

typedef struct {
    __global const float *errors, *bounds;
    float4 eye_scale; // xyz = eye, w = pixels per model unit at distance 1, per pixel of tolerance; 0 for one threshold
    float2 near_slack; // smallest distance, slack per depth
    float threshold;
    uint leaves, plane;
} Detail;

// error < threshold; or error * scale < distance to the node's sphere: its size on screen is below the tolerance.
// The slack outweighs the rounding of two distances, so that no node looks farther away than its own parts
#define FINE(NAME, FLOATS, INTS, LOAD)                                                                                 \
    static inline INTS NAME(const Detail detail, const uint texel, const uint depth)                                   \
    {                                                                                                                  \
        _Pragma("OPENCL FP_CONTRACT OFF") const FLOATS error = LOAD(detail.errors + texel);                            \
        if (detail.eye_scale.w == 0.0f) return error < detail.threshold;                                               \
        __global const float *bound = detail.bounds + (texel - detail.leaves);                                         \
        const FLOATS x = LOAD(bound) - detail.eye_scale.x, y = LOAD(bound + detail.plane) - detail.eye_scale.y;        \
        const FLOATS z = LOAD(bound + 2 * detail.plane) - detail.eye_scale.z;                                          \
        const FLOATS square = x * x + y * y + z * z;                                                                   \
        const FLOATS away = (sqrt(square) - LOAD(bound + 3 * detail.plane)) + (float)depth * detail.near_slack.y;      \
        return error * detail.eye_scale.w < fmax(away, (FLOATS)(detail.near_slack.x));                                 \
    }
#define ONE(p) (*(p))
#define EIGHT(p) vload8(0, (p))
FINE(fine_one, float, int, ONE)
FINE(fine_eight, float8, int8, EIGHT)

static inline uchar state_at(const Detail detail, const uint x, const uint y, const uint n)
{
    const uint side = 1u << n;
    if (y < side)
        return n > 1 && fine_one(detail, ((side + y / 2) << n) + side / 2 + x / 2, n - 1) ? 1 : 2;
    const uint row = y - side;
    if (x == 0) return 1;
    const uint depth = quadtree_column_depth(x);
    if (row >> depth != 0) return 1; // above the level's own square
    if (depth == 0) return 0;
    if (depth > 1 && fine_one(detail, ((side + row / 2) << n) + x / 2, depth - 1)) return 1;
    return fine_one(detail, (y << n) + x, depth) ? 2 : 0;
}

#if RUN >= 16
// lowest bytes, by reinterpretation: convert_uchar8 of int8 breaks the programs that PoCL 3.0 caches
static inline uchar8 bytes_of(const int8 v) { return (uchar8)(as_uchar16(v.lo).s048c, as_uchar16(v.hi).s048c); }

// sixteen texels of one level, with their eight parents beside each other; comparisons give -1 for true
static inline uchar16 states_at(const Detail detail, const uint x, const uint y, const uint n)
{
    const uint side = 1u << n;
    if (y < side) {
        const int8 above = fine_eight(detail, ((side + y / 2) << n) + side / 2 + x / 2, n - 1);
        return bytes_of(above + 2).s0011223344556677;
    }
    const uint row = y - side, depth = quadtree_column_depth(x), texel = (y << n) + x;
    if (row >> depth != 0) return 1;
    const uchar16 above = bytes_of(fine_eight(detail, ((side + row / 2) << n) + x / 2, depth - 1)).s0011223344556677;
    const uchar16 own = (uchar16)(bytes_of(fine_eight(detail, texel, depth)), bytes_of(fine_eight(detail, texel + 8, depth)));
    return (above & (uchar16)1) | (~above & own & (uchar16)2);
}
#endif

__kernel void quadtree_lod_fragment_filter(
    __global const float *restrict errors,
    __global const float *restrict bounds,
    __global uchar *restrict states,
    const float4 eye_scale,
    const float2 near_slack,
    const float threshold, // model units
    const uint n,
    const uint run_count)
{
    const uint run = get_global_id(0);
    if (run >= run_count) return;

    const uint first = run * RUN, x = first & ((1u << n) - 1), y = first >> n;
    const Detail detail = {errors, bounds, eye_scale, near_slack, threshold, 1u << (2 * n), 1u << (2 * n - 1)};
    uint done = 0;
#if RUN >= 16
    // the first sixteen columns of the upper part hold several levels
    done = y >> n != 0 && x == 0 ? 16 : 0;
    for (uint k = done; k < RUN; k += 16) vstore16(states_at(detail, x + k, y, n), 0, states + first + k);
    for (uint k = 0; k < done; ++k) states[first + k] = state_at(detail, x + k, y, n);
#else
    for (uint k = 0; k < RUN; ++k) states[first + k] = state_at(detail, x + k, y, n);
#endif
}
