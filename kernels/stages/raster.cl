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
// Needs     common/coverage.cl common/clip.cl

typedef struct {
    __global long *keys;
    __global uint *open, *queue;
    __global int *large;
    int width, height, across; // pixels, pixels, tiles per row
    uint large_capacity, large_pixels, cull;
} Canvas;

static inline void tile_open(const Canvas *canvas, const uint tile)
{
#ifndef SHARED
    if (canvas->open[tile]) return;
    canvas->open[tile] = 1;
    __global long8 *keys = (__global long8 *)(canvas->keys + (size_t)tile * TILE_PIXELS);
#ifdef COUNT
    for (int k = 0; k < TILE_PIXELS / 8; ++k) keys[k] = 0;
#else
    for (int k = 0; k < TILE_PIXELS / 8; ++k) keys[k] = KEY_EMPTY;
#endif
#endif
}

// a triangle of any size: into this item's map, or to the tiles when it would keep one item busy for too long
static void canvas_draw(const Canvas *canvas, const int4 a, const int4 b, const int4 c, const uint id)
{
    Walk walk;
    if (!walk_start(&walk, a, b, c, id, canvas->width, canvas->height, canvas->cull)) return;
    const int4 box = walk.box;
    if ((uint)(box.z - box.x + 1) * (uint)(box.w - box.y + 1) > canvas->large_pixels) {
        const uint slot = atomic_inc(&canvas->queue[1]);
        if (slot < canvas->large_capacity) {
            vstore16((int16)(box, a.xyz, (int)id, b, c), slot, canvas->large);
            return;
        }
    }
    for (int y = box.y / TILE; y <= box.w / TILE; ++y)
        for (int x = box.x / TILE; x <= box.z / TILE; ++x) {
            const uint tile = y * canvas->across + x;
            tile_open(canvas, tile);
            walk_tile(&walk, canvas->keys + (size_t)tile * TILE_PIXELS, x * TILE, y * TILE);
        }
}

static void canvas_clip(const Canvas *canvas, const float3 a, const float3 b, const float3 c, const float16 m, const uint id)
{
    float4 corners[CLIP_CORNERS];
    corners[0] = screen_transform(a, m);
    corners[1] = screen_transform(b, m);
    corners[2] = screen_transform(c, m);
    const int count = clip_polygon(corners);
    for (int k = 2; k < count; ++k)
        canvas_draw(canvas, clip_corner(corners[0]), clip_corner(corners[k - 1]), clip_corner(corners[k]), id);
}

// corner `c` of eight triangles, four 4 x 4 transposes at once
#define EIGHT_CORNERS(c, x, y, z, w)                                                                                   \
    int8 x, y, z, w;                                                                                                   \
    {                                                                                                                  \
        const int8 p = (int8)(RECORD(0 + c), RECORD(12 + c)), q = (int8)(RECORD(3 + c), RECORD(15 + c));               \
        const int8 r = (int8)(RECORD(6 + c), RECORD(18 + c)), s = (int8)(RECORD(9 + c), RECORD(21 + c));               \
        const int8 pq = LANES(p, q, 0, 8, 1, 9, 4, 12, 5, 13), rs = LANES(r, s, 0, 8, 1, 9, 4, 12, 5, 13);             \
        const int8 pq2 = LANES(p, q, 2, 10, 3, 11, 6, 14, 7, 15), rs2 = LANES(r, s, 2, 10, 3, 11, 6, 14, 7, 15);       \
        x = LANES(pq, rs, 0, 1, 8, 9, 4, 5, 12, 13);                                                                   \
        y = LANES(pq, rs, 2, 3, 10, 11, 6, 7, 14, 15);                                                                 \
        z = LANES(pq2, rs2, 0, 1, 8, 9, 4, 5, 12, 13);                                                                 \
        w = LANES(pq2, rs2, 2, 3, 10, 11, 6, 7, 14, 15);                                                               \
    }
#define RECORD(k) vload4(corners[k], screen)
#define EIGHT_EDGES(k, ax, ay, bx, by)                                                                                 \
    const int8 dx##k = ((bx - ax) ^ flip) - flip, dy##k = ((by - ay) ^ flip) - flip;                                   \
    const int8 owned##k = (dy##k < 0) | ((dy##k == 0) & (dx##k > 0));                                                  \
    int8 row##k = (dx##k * (centre_y - ay) - dy##k * (centre_x - ax) - 1 - owned##k) >> 8;

// triangles up to four pixels wide and high: one per lane, all their pixel centres in step
static inline int8 canvas_draw_eight(
    const Canvas *canvas, __global const int *restrict screen, const uint *corners, const uint t, const uint end)
{
    EIGHT_CORNERS(0, x0, y0, z0, w0)
    EIGHT_CORNERS(1, x1, y1, z1, w1)
    EIGHT_CORNERS(2, x2, y2, z2, w2)
    const int8 low_x = min(x0, min(x1, x2)), high_x = max(x0, max(x1, x2));
    const int8 low_y = min(y0, min(y1, y2)), high_y = max(y0, max(y1, y2));
    const int8 left = max((low_x + (SUBPIXELS / 2 - 1)) >> 8, 0), right = min((high_x - SUBPIXELS / 2) >> 8, canvas->width - 1);
    const int8 top = max((low_y + (SUBPIXELS / 2 - 1)) >> 8, 0), bottom = min((high_y - SUBPIXELS / 2) >> 8, canvas->height - 1);
    const int8 clipped = (w0 | w1 | w2) != 0;
    const int8 exists = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int)min(end - t, 8u);
    const int8 seen = exists & ((w0 & w1 & w2) == 0) & (clipped | ((left <= right) & (top <= bottom)));
    if (!any_lane(seen)) return 0;

    const int8 small = ((high_x - low_x) < 4 * SUBPIXELS) & ((high_y - low_y) < 4 * SUBPIXELS) & ~clipped;
    const int8 area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    const int8 flip = area >> 31;
    int8 drawn = seen & small & (area != 0);
    if (canvas->cull) drawn &= flip;
    const int8 others = seen & ~small;
    if (!any_lane(drawn)) return others;

    const int8 centre_x = left * SUBPIXELS + SUBPIXELS / 2, centre_y = top * SUBPIXELS + SUBPIXELS / 2;
    EIGHT_EDGES(0, x0, y0, x1, y1)
    EIGHT_EDGES(1, x1, y1, x2, y2)
    EIGHT_EDGES(2, x2, y2, x0, y0)
    const float8 za = as_float8(z0), zb = as_float8(z1), zc = as_float8(z2);
    const float8 fx1 = convert_float8(x1 - x0), fy1 = convert_float8(y1 - y0), fz1 = zb - za;
    const float8 fx2 = convert_float8(x2 - x0), fy2 = convert_float8(y2 - y0), fz2 = zc - za;
    const float8 inverse = 1.0f / convert_float8(area);
    const float8 zx = (fz1 * fy2 - fz2 * fy1) * inverse, zy = (fz2 * fx1 - fz1 * fx2) * inverse;
    const float8 near = min(za, min(zb, zc)), far = max(za, max(zb, zc));

    const int columns = largest_lane((right - left) & drawn), rows = largest_lane((bottom - top) & drawn);
    for (int row = 0; row <= rows; ++row) {
        const int8 y = top + row;
        const float8 depth_y = zy * convert_float8(centre_y - y0 + row * SUBPIXELS);
        const int8 line = ((y >> 6) * canvas->across << 12) + ((y & 63) << 6);
        const int8 in_rows = drawn & (y <= bottom);
        int8 f0 = row0, f1 = row1, f2 = row2;
        for (int column = 0; column <= columns; ++column) {
            const int8 x = left + column;
            const int8 covered = ((f0 | f1 | f2) >= 0) & in_rows & (x <= right);
            // one bit in eight per lane
            ulong bits = as_ulong(convert_uchar8(covered)) & 0x0101010101010101UL;
            if (bits) {
                const float8 depth_x = zx * convert_float8(centre_x - x0 + column * SUBPIXELS);
                const float8 z = clamp((za + depth_x) + depth_y, near, far);
                uint depths[8], pixels[8];
                vstore8(as_uint8(z), 0, depths);
                vstore8(as_uint8(line + ((x >> 6) << 12) + (x & 63)), 0, pixels);
                do {
                    const uint lane = (uint)(63 - clz(bits)) >> 3;
                    bits ^= 1UL << (8 * lane);
                    tile_open(canvas, pixels[lane] >> 12);
                    key_put(canvas->keys + pixels[lane], ((long)depths[lane] << 32) | (t + lane));
                } while (bits);
            }
            f0 -= dy0;
            f1 -= dy1;
            f2 -= dy2;
        }
        row0 += dx0;
        row1 += dx1;
        row2 += dx2;
    }
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
    for (;;) {
        const ulong first = (ulong)atomic_inc(flags) * block;
        if (first >= count) return;
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
            const int8 others = canvas_draw_eight(&canvas, screen, corners, t, end);
            ulong bits = as_ulong(convert_uchar8(others)) & 0x0101010101010101UL;
            while (bits) {
                const uint lane = (uint)(63 - clz(bits)) >> 3;
                bits ^= 1UL << (8 * lane);
                const uint a = corners[3 * lane], b = corners[3 * lane + 1], c = corners[3 * lane + 2];
                const int4 u = vload4(a, screen), v = vload4(b, screen), w = vload4(c, screen);
                if (u.w | v.w | w.w)
                    canvas_clip(&canvas, vload3(a, positions), vload3(b, positions), vload3(c, positions), to_screen, t + lane);
                else
                    canvas_draw(&canvas, u, v, w, t + lane);
            }
        }
    }
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
