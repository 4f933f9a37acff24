// Eight triangles at a time into a canvas: small ones one per lane, others one after the other in rows of eight pixels.
//
// Source    Pineda 1988, "A parallel algorithm for polygon rasterization"
// Work      functions only; no bit differs from what canvas_draw gives
// Reads     nothing
// Writes    nothing
// Needs     common/canvas.cl
// Plain     stages/raster_reference.py
// Defines   COUNT, SHARED as in canvas.cl

// eight triangles of a few pixels each, planes in memory; edges and depths as in `Walk`, from pixel (left, top) on
typedef struct {
    int left[8], top[8], right[8], bottom[8], x[8], y[8];
    int edges[72];    // values at (left, top) | steps per row | steps per column, three of eight each
    float depth[40];  // at (x, y) | slopes in x and y | nearest and farthest corner
} Eight;

// pixels of a row in the order in which keys are put together from depths and ids, in two halves
#define PAIRED ((int8)(0, 1, 4, 5, 2, 3, 6, 7))

// one of them, in rows of eight pixels that begin at every fourth: so the next triangle loads what this one stores
static inline void canvas_walk(const Canvas *canvas, const Eight *eight, const uint lane, const uint first_id)
{
    const int from = max(eight->left[lane], 0), to = min(eight->right[lane], canvas->width - 1);
    const int above = max(eight->top[lane], 0), below = min(eight->bottom[lane], canvas->height - 1);
    const int *edges = eight->edges + lane;
    const float *depth = eight->depth + lane;
    const int8 dy0 = edges[48], dy1 = edges[56], dy2 = edges[64];
    const float8 near = depth[24], far = depth[32];
    const int8 id = (int)(first_id + lane);
    for (int tile_y = above / TILE; tile_y <= below / TILE; ++tile_y)
        for (int tile_x = from / TILE; tile_x <= to / TILE; ++tile_x) {
            const uint tile = tile_y * canvas->across + tile_x;
            tile_open(canvas, tile);
            const int first = max(above, tile_y * TILE), last = min(below, tile_y * TILE + TILE - 1);
            const int end = min(to, tile_x * TILE + TILE - 1);
            int x = max(from, tile_x * TILE) & ~3;
            x = min(x, tile_x * TILE + TILE - ((end - x) & ~7) - 8);
            for (; x <= end; x += 8) {
                const int across = x - eight->left[lane], down = first - eight->top[lane];
                int8 f0 = edges[0] + edges[24] * down - (across + PAIRED) * dy0;
                int8 f1 = edges[8] + edges[32] * down - (across + PAIRED) * dy1;
                int8 f2 = edges[16] + edges[40] * down - (across + PAIRED) * dy2;
                const float8 plane = depth[0] + depth[8] * convert_float8(x * SUBPIXELS + SUBPIXELS / 2 - eight->x[lane] + PAIRED * SUBPIXELS);
                float8 y = first * SUBPIXELS + SUBPIXELS / 2 - eight->y[lane];
                __global long4 *at = (__global long4 *)(canvas->keys + (size_t)tile * TILE_PIXELS + (first % TILE) * TILE + x % TILE);
                for (int row = first; row <= last; ++row) {
                    const int8 outside = f0 | f1 | f2; // negative
#ifdef COUNT
                    const int8 covered = ~(outside >> 31);
                    at[0] -= as_long4(SHUFFLE8(covered, covered, 0, 8, 1, 9, 4, 12, 5, 13));
                    at[1] -= as_long4(SHUFFLE8(covered, covered, 2, 10, 3, 11, 6, 14, 7, 15));
#else
                    const float8 inside = lesser(greater(plane + depth[16] * y, near), far);
                    const int8 z = outside < 0 ? (int8)(0x7fffffff) : as_int8(inside); // outside: behind everything
                    const long4 low = as_long4(SHUFFLE8(id, z, 0, 8, 1, 9, 4, 12, 5, 13));
                    const long4 high = as_long4(SHUFFLE8(id, z, 2, 10, 3, 11, 6, 14, 7, 15));
                    at[0] = low < at[0] ? low : at[0];
                    at[1] = high < at[1] ? high : at[1];
#endif
                    at += TILE / 4;
                    y += (float)SUBPIXELS;
                    f0 += edges[24], f1 += edges[32], f2 += edges[40];
                }
            }
        }
}

// corner `c` of eight triangles
#define EIGHT_CORNERS(c, t)                                                                                            \
    const fours8 t = transpose_fours(                                                                                  \
        as_float8((int8)(RECORD(0 + c), RECORD(12 + c))), as_float8((int8)(RECORD(3 + c), RECORD(15 + c))),            \
        as_float8((int8)(RECORD(6 + c), RECORD(18 + c))), as_float8((int8)(RECORD(9 + c), RECORD(21 + c))));           \
    const int8 x##c = as_int8(t.x), y##c = as_int8(t.y), z##c = as_int8(t.z), w##c = as_int8(t.w);
#ifdef SHARED
#define SMALL 8 // pixels
#define MEDIUM 16
#define ENOUGH 3 // of eight
#else
#define SMALL 6
#define MEDIUM 64 // whose edges fit in 32 bits with room to spare
#endif
#define RECORD(k) vload4(corners[k], screen)
#define EIGHT_EDGES(k, ax, ay, bx, by)                                                                                 \
    const int8 dx##k = ((bx - ax) ^ flip) - flip, dy##k = ((by - ay) ^ flip) - flip;                                   \
    const int8 owned##k = (dy##k < 0) | ((dy##k == 0) & (dx##k > 0));                                                  \
    int8 row##k = (dx##k * (centre_y - ay) - dy##k * (centre_x - ax) - 1 - owned##k) >> 8;

// triangles up to SMALL pixels wide and high: one per lane, all their pixel centres in step; those up to MEDIUM: rows of
// eight pixels, or, where a map is shared, in step too if enough are. Returns the others, to be drawn one by one, of which
// no bit differs. `id` is the first one's, `live` how many there are
static inline uint canvas_draw_eight(
    const Canvas *canvas, Waiting *waiting, __global const int *restrict screen, const uint *corners, const uint id,
    const uint live)
{
    EIGHT_CORNERS(0, a)
    EIGHT_CORNERS(1, b)
    EIGHT_CORNERS(2, c)
    const int8 low_x = min(x0, min(x1, x2)), high_x = max(x0, max(x1, x2));
    const int8 low_y = min(y0, min(y1, y2)), high_y = max(y0, max(y1, y2));
    const int8 left = (low_x + (SUBPIXELS / 2 - 1)) >> 8, right = (high_x - SUBPIXELS / 2) >> 8;
    const int8 top = (low_y + (SUBPIXELS / 2 - 1)) >> 8, bottom = (high_y - SUBPIXELS / 2) >> 8;
    const int8 clipped = w0 | w1 | w2, gone = w0 & w1 & w2; // negative: any, all
    const int8 missed = (left > right) | (top > bottom) | (right < 0) | (bottom < 0) | (left >= canvas->width) | (top >= canvas->height);
    const int8 rejected = (LANE >= (int)live) | ((gone < 0) & ((gone & OUTSIDE_ANY) != 0)) | (missed & (clipped >= 0));
    const uint seen = ~lane_signs(rejected) & 255;
    if (!seen) return 0;

    const int8 whole = (left >= 0) & (top >= 0) & (right < canvas->width) & (bottom < canvas->height);
    const int8 size = max(high_x - low_x, high_y - low_y);
    const int8 medium = (clipped >= 0) & (size < MEDIUM * SUBPIXELS), tiny = whole & medium & (size < SMALL * SUBPIXELS);
#ifdef SHARED
    // a few larger ones would keep the rest waiting
    const int8 fits = popcount(lane_signs(whole & medium & ~tiny)) < ENOUGH ? tiny : whole & medium, small = fits;
#else
    const int8 fits = medium, small = tiny;
#endif
    const int8 area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    const int8 flip = area >> 31;
    const uint others = seen & ~lane_signs(fits);
    uint drawn = seen & ~others & lane_signs(area != 0);
    if (canvas->cull) drawn &= lane_signs(flip);
    if (!drawn) return others;

    const int8 centre_x = left * SUBPIXELS + SUBPIXELS / 2, centre_y = top * SUBPIXELS + SUBPIXELS / 2;
    EIGHT_EDGES(0, x0, y0, x1, y1)
    EIGHT_EDGES(1, x1, y1, x2, y2)
    EIGHT_EDGES(2, x2, y2, x0, y0)
    const float8 za = as_float8(z0), zb = as_float8(z1), zc = as_float8(z2);
    const float8 fx1 = convert_float8(x1 - x0), fy1 = convert_float8(y1 - y0), fz1 = zb - za;
    const float8 fx2 = convert_float8(x2 - x0), fy2 = convert_float8(y2 - y0), fz2 = zc - za;
    const float8 inverse = 1.0f / convert_float8(area);
    const float8 zx = (fz1 * fy2 - fz2 * fy1) * inverse, zy = (fz2 * fx1 - fz1 * fx2) * inverse;
    const float8 near = lesser(za, lesser(zb, zc)), far = greater(za, greater(zb, zc));

#ifndef SHARED
    uint walked = drawn & ~lane_signs(small);
    if (walked) {
        Eight eight;
        vstore8(left, 0, eight.left);
        vstore8(top, 0, eight.top);
        vstore8(right, 0, eight.right);
        vstore8(bottom, 0, eight.bottom);
        vstore8(x0, 0, eight.x);
        vstore8(y0, 0, eight.y);
        const int8 edges[9] = {row0, row1, row2, dx0, dx1, dx2, dy0, dy1, dy2};
        for (int n = 0; n < 9; ++n) vstore8(edges[n], n, eight.edges);
        const float8 planes[5] = {za, zx, zy, near, far};
        for (int n = 0; n < 5; ++n) vstore8(planes[n], n, eight.depth);
        for (; walked; walked &= walked - 1) canvas_walk(canvas, &eight, 31 - clz(walked & -walked), id);
        drawn &= lane_signs(small);
        if (!drawn) return others;
    }
#endif
    uint pixels[64], depths[64], round = 0;
    ulong bits = 0;
    const int8 extent = small & (area != 0);
    const int columns = largest_lane((right - left) & extent), rows = largest_lane((bottom - top) & extent);
    for (int row = 0; row <= rows; ++row) {
        const int8 y = top + row;
        const int8 line = ((y >> 6) * canvas->across << 12) + ((y & 63) << 6);
        const float8 depth_y = zy * convert_float8(centre_y - y0 + row * SUBPIXELS);
        int8 f0 = row0, f1 = row1, f2 = row2;
        for (int column = 0; column <= columns; ++column) {
            const int8 x = left + column;
            const float8 plane = (za + zx * convert_float8(centre_x - x0 + column * SUBPIXELS)) + depth_y;
            vstore8(as_uint8(lesser(greater(plane, near), far)), round, depths);
            vstore8(as_uint8(line + x + (x >> 6) * (TILE_PIXELS - TILE)), round, pixels);
            bits |= (ulong)(~lane_signs(f0 | f1 | f2) & drawn) << (8 * round);
            if (++round == 8) {
                canvas_put(canvas, waiting, bits, pixels, depths, id);
                bits = 0, round = 0;
            }
            f0 -= dy0, f1 -= dy1, f2 -= dy2;
        }
        row0 += dx0, row1 += dx1, row2 += dx2;
    }
    canvas_put(canvas, waiting, bits, pixels, depths, id);
    return others;
}
