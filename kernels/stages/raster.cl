// Raster stage: triangles to one key per pixel, depth above id, the smallest wins.
//
// Source    Burns & Hunt 2013, "The visibility buffer"; Laine & Karras 2011 for splitting work by tiles (reconstruction)
// Work      triangles: 1-D, one item per map, each fetching blocks of triangles until none is left; large: 1-D, one item
//           per tile. Minimum does not care for order: any number of maps, any schedule, any group size, the same bits
// Reads     screen     int  [4 * vertex_count]   x, y in sub-pixels | depth bits | outcode
//           triangles  uint [3 * pattern_count]  of one instance; instance i adds i * instance_vertices
//           positions  float[3 * vertex_count]   for triangles that cross the near plane or leave the guard band
//           live       uint [2]                  live vertices, live triangles
// Writes    keys       long [map_count * tile_count * 4096]   tiles of 64 x 64
//           flags      uint [16 + map_count * tile_count]     next block | large triangles found | from 16: tile is open
//           large      int  [16 * large_capacity]   box in pixels, then three corners; id after the first
// Needs     common/canvas.cl
// Plain     stages/raster_reference.py
// Defines   COUNT, SHARED as in canvas.cl

// corner `c` of eight triangles
#define EIGHT_CORNERS(c, t)                                                                                            \
    const fours8 t = transpose_fours(                                                                                  \
        as_float8((int8)(RECORD(0 + c), RECORD(12 + c))), as_float8((int8)(RECORD(3 + c), RECORD(15 + c))),            \
        as_float8((int8)(RECORD(6 + c), RECORD(18 + c))), as_float8((int8)(RECORD(9 + c), RECORD(21 + c))));           \
    const int8 x##c = as_int8(t.x), y##c = as_int8(t.y), z##c = as_int8(t.z), w##c = as_int8(t.w);
#define SMALL 8 // pixels
#define MEDIUM 16
#define ENOUGH 3 // of eight
#define RECORD(k) vload4(corners[k], screen)
#define EIGHT_EDGES(k, ax, ay, bx, by)                                                                                 \
    const int8 dx##k = ((bx - ax) ^ flip) - flip, dy##k = ((by - ay) ^ flip) - flip;                                   \
    const int8 owned##k = (dy##k < 0) | ((dy##k == 0) & (dx##k > 0));                                                  \
    int8 row##k = (dx##k * (centre_y - ay) - dy##k * (centre_x - ax) - 1 - owned##k) >> 8;

// triangles up to SMALL pixels wide and high, or MEDIUM where enough are: one per lane, all their pixel centres in step;
// returns the others, to be drawn one by one, of which no bit differs. `id` is the first one's, `live` how many there are
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
    const int8 size = max(high_x - low_x, high_y - low_y), fits = whole & (clipped >= 0);
    const int8 tiny = fits & (size < SMALL * SUBPIXELS), medium = fits & (size < MEDIUM * SUBPIXELS);
    // a few larger ones would keep the rest waiting
    const int8 small = popcount(lane_signs(medium & ~tiny)) < ENOUGH ? tiny : medium;
    const int8 area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    const int8 flip = area >> 31;
    const uint others = seen & ~lane_signs(small);
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

__kernel void stages_raster_triangles(
    __global const int *restrict screen,
    __global const uint *restrict triangles,
    __global const float *restrict positions,
    __global const uint *restrict live,
    __global long *restrict keys,
    __global uint *flags,
    __global int *restrict large,
    const float16 to_screen,
    const uint instance_vertices,
    const uint first_id, // of the frame's triangles: this surface's first
    const uint cull,
    const int width,
    const int height,
    const uint large_pixels,
    const uint large_capacity,
    const uint pattern_count,
    const uint triangle_count,
    const uint map_count,
    const uint item_count)
{
    const uint item = get_global_id(0);
    if (item >= item_count) return;
    const int across = (width + TILE - 1) / TILE;
    const size_t tiles = (size_t)across * ((height + TILE - 1) / TILE);
    const uint map = item % map_count;
    const Canvas canvas = {keys + map * tiles * TILE_PIXELS, flags + FLAGS_OPEN + map * tiles, flags, large,
                           width, height, across, large_capacity, large_pixels, cull};
    const uint count = min(live[1], triangle_count);
    const uint block = clamp(count / (64 * item_count) / 8 * 8, 32u, 4096u); // small enough to share out evenly
    Waiting waiting;
    waiting.count = 0;
    for (;;) {
        const ulong first = (ulong)atomic_inc(flags) * block;
        if (first >= count) break;
        const uint end = (uint)min(first + block, (ulong)count);
        uint k = (uint)first % pattern_count, base = (uint)first / pattern_count * instance_vertices;
        for (uint t = first; t < end; t += 8) {
            uint corners[24];
            if (k >= pattern_count) k -= pattern_count, base += instance_vertices;
            if (t + 8 <= end && k + 8 <= pattern_count) {
                for (int n = 0; n < 3; ++n) vstore8(vload8(n, triangles + 3 * (size_t)k) + base, n, corners);
                k += 8;
            } else { // across two instances, or past the end, where the last triangle stands in
                for (uint lane = 0; lane < 8; ++lane) {
                    if (k == pattern_count) k = 0, base += instance_vertices;
                    for (uint n = 0; n < 3; ++n) corners[3 * lane + n] = triangles[3 * (size_t)k + n] + base;
                    k += t + lane + 1 < end;
                }
            }
            uint others = canvas_draw_eight(&canvas, &waiting, screen, corners, first_id + t, end - t);
            while (others) {
                const uint lane = 31 - clz(others);
                others ^= 1u << lane;
                const uint a = corners[3 * lane], b = corners[3 * lane + 1], c = corners[3 * lane + 2];
                const int4 u = vload4(a, screen), v = vload4(b, screen), w = vload4(c, screen);
                if ((u.w | v.w | w.w) < 0)
                    canvas_clip(&canvas, vload3(a, positions), vload3(b, positions), vload3(c, positions), to_screen,
                        first_id + t + lane);
                else
                    canvas_draw(&canvas, u, v, w, first_id + t + lane);
            }
        }
    }
    waiting_put(&canvas, &waiting);
}

__kernel void stages_raster_large(
    __global const int *restrict large,
    __global long *restrict keys,
    __global uint *restrict flags,
    const int width,
    const int height,
    const uint cull,
    const uint large_capacity,
    const uint tile_count)
{
    const uint tile = get_global_id(0);
    if (tile >= tile_count) return;
    const uint count = min(flags[1], large_capacity);
    const int across = (width + TILE - 1) / TILE;
    const int left = (int)(tile % across) * TILE, top = (int)(tile / across) * TILE;
    const Canvas canvas = {keys, flags + FLAGS_OPEN, 0, 0, width, height, across, 0, 0, cull};
    for (uint k = 0; k < count; ++k) {
        const int4 box = vload4(4 * (size_t)k, large);
        if (box.x >= left + TILE || box.y >= top + TILE || box.z < left || box.w < top) continue;
        const int4 a = vload4(4 * (size_t)k + 1, large);
        Walk walk;
        walk_start(&walk, a, vload4(4 * (size_t)k + 2, large), vload4(4 * (size_t)k + 3, large), (uint)a.w, width, height, cull);
        tile_open(&canvas, tile);
        walk_tile(&walk, keys + (size_t)tile * TILE_PIXELS, left, top);
    }
}
