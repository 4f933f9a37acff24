// Rows of a patch's parametric map, eight virtual vertices at a time: points and unit normals.
//
// Source    Concheiro 2013, section 1.2 and chapter 2
// Work      functions only. A row is a polynomial of t = v - 1/2, split into its even and its odd part: whole rows are
//           walked from both ends, since t and -t share them. What lies on a border is summed as bezier/patch.cl says,
//           where all control points off it weigh nothing
// Reads     map  float[8 * map_stride]  as bezier/block.cl has it
// Writes    nothing
// Needs     bezier/block.cl
// Plain     bezier/reference.py
// Defines   NORMALS (1: normals too), STREAMING (common/output.cl)

#pragma OPENCL FP_CONTRACT OFF

#define BEZIER_STEPS ((int8)(0, 1, 2, 3, 4, 5, 6, 7))

typedef struct {
    planes8 even, odd; // the latter times t
} bezier_halves;

// number k of row `lane`
#define BEZIER_OF(numbers, k, lane) ((float8)(((const float *)(numbers))[8 * (k) + (lane)]))
#define BEZIER_HALF2(tt, m, k, lane) fma(tt, BEZIER_OF(m, (k) + 2, lane), BEZIER_OF(m, k, lane))
#define BEZIER_HALF3(tt, m, k, lane) fma(tt, BEZIER_HALF2(tt, m, (k) + 2, lane), BEZIER_OF(m, k, lane))
#define BEZIER_HALVES(halves, HALF, each, t, m, lane)                                                                  \
    {                                                                                                                  \
        const float8 tt = t * t;                                                                                       \
        (halves).even.x = HALF(tt, m, 0, lane), (halves).odd.x = t * HALF(tt, m, 1, lane);                             \
        (halves).even.y = HALF(tt, m, each, lane), (halves).odd.y = t * HALF(tt, m, each + 1, lane);                   \
        (halves).even.z = HALF(tt, m, 2 * each, lane), (halves).odd.z = t * HALF(tt, m, 2 * each + 1, lane);           \
    }

static inline planes8 bezier_sum(const bezier_halves h)
{
    const planes8 sum = {h.even.x + h.odd.x, h.even.y + h.odd.y, h.even.z + h.odd.z};
    return sum;
}

// at -t, the lanes turned round
static inline planes8 bezier_mirrored(const bezier_halves h)
{
    const float8 x = h.even.x - h.odd.x, y = h.even.y - h.odd.y, z = h.even.z - h.odd.z;
    const planes8 turned = {SHUFFLE8(x, x, 7, 6, 5, 4, 3, 2, 1, 0), SHUFFLE8(y, y, 7, 6, 5, 4, 3, 2, 1, 0),
        SHUFFLE8(z, z, 7, 6, 5, 4, 3, 2, 1, 0)};
    return turned;
}

static inline float3 bezier_lane(const planes8 *a, const uint lane)
{
    const float *of = (const float *)a + lane;
    return (float3)(of[0], of[8], of[16]);
}

// number k of each axis, four of which there are
static inline float3 bezier_three(const float8 *numbers, const uint k, const uint lane)
{
    const float *of = (const float *)(numbers + k) + lane;
    return (float3)(of[0], of[32], of[64]);
}

#define BEZIER_BASIS(m, k, lane)                                                                                       \
    BEZIER_CUBIC(w0, w1, w2, w3, BEZIER_OF(m, k, lane), BEZIER_OF(m, (k) + 1, lane), BEZIER_OF(m, (k) + 2, lane),      \
        BEZIER_OF(m, (k) + 3, lane))

// a row that is a border, exact: `count` points from column j on; up to `room` may be written
static inline void bezier_border(OUTPUT float *out, const bezier_block *block, const uint lane,
    const bezier_map map, const uint j, const uint count, const uint room)
{
    const float8 *c = block->controls;
    const uint s = map.stride;
    for (uint k = 0; k < count; k += 8) {
        __global const float *w = map.weights + j + k;
        const float8 w0 = vload8(0, w), w1 = vload8(0, w + s), w2 = vload8(0, w + 2 * s), w3 = vload8(0, w + 3 * s);
        const planes8 p = {BEZIER_BASIS(c, 0, lane), BEZIER_BASIS(c, 4, lane), BEZIER_BASIS(c, 8, lane)};
        output_put(out + 3 * k, p, room - k);
    }
}

// points of a row, which is number `lane` of the block: `count` from column j on; up to `room` may be written
static inline void bezier_points(OUTPUT float *out, const bezier_block *block, const uint lane,
    const bezier_map map, const uint j, const uint count, const uint room, const uint side)
{
    __global const float *t = map.weights + 7 * map.stride + j;
    const float8 *m = block->point;
    const uint n = side - 1;
    const bool is_last = j + count == side;
    bezier_halves h;
    if (count == side && n % 16 == 0) {
        for (uint k = 0; k < n / 2; k += 8) {
            const float8 v = vload8(0, t + k);
            BEZIER_HALVES(h, BEZIER_HALF2, 4, v, m, lane)
            output_put(out + 3 * k, bezier_sum(h), 8);
            output_put(out + 3 * (n - 7 - k), bezier_mirrored(h), 8);
        }
        vstore3(bezier_three(m, 0, lane), n / 2, out);
    } else {
        for (uint k = 0; k < (is_last ? count - 1 : count); k += 8) {
            const float8 v = vload8(0, t + k);
            BEZIER_HALVES(h, BEZIER_HALF2, 4, v, m, lane)
            output_put(out + 3 * k, bezier_sum(h), room - k);
        }
    }
    // where the row crosses a border its own control points are the border's
    if (j == 0) vstore3(bezier_three(block->controls, 0, lane), 0, out);
    if (is_last) vstore3(bezier_three(block->controls, 3, lane), count - 1, out);
}

#if NORMALS
// units of what was evaluated at these columns of a row; at both borders they are of no use
static inline planes8 bezier_units(
    const planes8 n, const int8 columns, const bezier_patch *patch, const float u, const uint side)
{
    planes8 unit;
    int8 is_bad = normals_unit8(&unit, n);
    if (normals_any(is_bad)) {
        is_bad &= columns > 0 & columns < (int8)(side - 1);
        const float8 v = convert_float8(columns) * (1.0f / (float)(side - 1));
        if (normals_any(is_bad)) bezier_mend8(&unit, is_bad, patch, (float8)(u), v);
    }
    return unit;
}

// unit normals of row i, which is number `lane` of the block: as bezier_points
static inline void bezier_normals(OUTPUT float *out, const bezier_block *block, const uint lane,
    const bezier_patch *patch, const bezier_map map, const uint i, const uint j, const uint count, const uint room,
    const uint side)
{
    __global const float *t = map.weights + 7 * map.stride + j;
    const float8 *m = block->normal;
    const uint n = side - 1;
    const float u = (float)i * (1.0f / (float)n);
    const bool is_last = j + count == side;
    bezier_halves h;
    if (count == side && n % 16 == 0) {
        for (uint k = 0; k < n / 2; k += 8) {
            const float8 v = vload8(0, t + k);
            const int8 columns = (int8)(k) + BEZIER_STEPS;
            BEZIER_HALVES(h, BEZIER_HALF3, 6, v, m, lane)
            output_put(out + 3 * k, bezier_units(bezier_sum(h), columns, patch, u, side), 8);
            const int8 others = (int8)(n - 7 - k) + BEZIER_STEPS;
            output_put(out + 3 * (n - 7 - k), bezier_units(bezier_mirrored(h), others, patch, u, side), 8);
        }
        vstore3(bezier_lane(&block->middle, lane), n / 2, out);
    } else {
        for (uint k = 0; k < (is_last ? count - 1 : count); k += 8) {
            const float8 v = vload8(0, t + k);
            BEZIER_HALVES(h, BEZIER_HALF3, 6, v, m, lane)
            const int8 columns = (int8)(j + k) + BEZIER_STEPS;
            output_put(out + 3 * k, bezier_units(bezier_sum(h), columns, patch, u, side), room - k);
        }
        const uint middle = n / 2;
        if (n > 1 && j <= middle && middle < j + count) vstore3(bezier_lane(&block->middle, lane), middle - j, out);
    }
    if (j == 0) vstore3(bezier_lane(&block->first, lane), 0, out);
    if (is_last) vstore3(bezier_lane(&block->last, lane), count - 1, out);
}
#endif

// the patch's vertices from number `vertex` on, `most` of them or all that are left; returns how many
static inline uint bezier_rows(OUTPUT float *points, OUTPUT float *normals, const bezier_patch *patch,
    const bezier_map map, const uint vertex, const uint most, const uint side)
{
    uint i = vertex / side, j = vertex % side, done = 0;
    while (i < side && done < most) {
        bezier_block block;
        bezier_block_of(&block, patch, map, i);
        for (uint lane = 0; lane < BEZIER_ROWS && i < side && done < most; ++lane, ++i, j = 0) {
            const uint here = min(side - j, most - done), room = most - done;
            if (i == 0 || i == side - 1)
                bezier_border(points + 3 * done, &block, lane, map, j, here, room);
            else
                bezier_points(points + 3 * done, &block, lane, map, j, here, room, side);
#if NORMALS
            bezier_normals(normals + 3 * done, &block, lane, patch, map, i, j, here, room, side);
#endif
            done += here;
        }
    }
    return done;
}

// block number `block` of the rows of a patch whose vertices begin with number `first`
static inline void bezier_block_rows(OUTPUT float *points, OUTPUT float *normals, const bezier_patch *patch,
    const bezier_map map, const uint first, const uint block, const uint side)
{
    const uint vertex = block * BEZIER_ROWS * side, count = min(BEZIER_ROWS * side, side * side - vertex);
    const size_t at = 3 * ((size_t)first + vertex);
    bezier_rows(points + at, normals + (NORMALS ? at : 0), patch, map, vertex, count, side);
}
