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
//           flags      uint [16 + map_count * tile_count]     1: large triangles found | from 8: next block of each range | from 16: tile is open
//           large      int  [16 * large_capacity]   box in pixels, then three corners; id after the first
// Needs     common/eight.cl
// Plain     stages/raster_reference.py
// Defines   COUNT, SHARED as in canvas.cl

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
    // a map begins with a range of its own, so that the maps' tiles are few, and then helps with the others'
    const uint blocks = (count + block - 1) / block, ranges = min(map_count, (uint)FLAGS_RANGES);
    Waiting waiting;
    waiting.count = 0;
    for (uint tried = 0; tried < ranges;) {
        const uint range = (map + tried) % ranges;
        const uint start = (uint)((ulong)blocks * range / ranges), stop = (uint)((ulong)blocks * (range + 1) / ranges);
        const uint taken = atomic_inc(flags + FLAGS_NEXT + range);
        if (taken >= stop - start) {
            ++tried;
            continue;
        }
        const ulong first = (ulong)(start + taken) * block;
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
