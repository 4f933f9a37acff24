// Fragment stage: the triangle that each pixel sees, lit by a key and a fill light under a pale sky.
//
// Source    Olano & Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates" (weights of the corners,
//           exact under perspective and for corners behind the eye); Blinn 1977 for the highlight
// Work      1-D, one item per few rows of 64 pixels of a tile, eight pixels at a time; what depends on a triangle alone,
//           once for each run of pixels that see it; long because each walk along a row reads what those before it left
// Reads     keys        long [map_count * tile_count * 4096]   depth above id; the smallest over the maps is seen
//           flags       uint [16 + map_count * tile_count]   from 16: tile is open
//           triangles   uint [3 * pattern_count]
//           screen      int  [4 * vertex_count]   x, y in sub-pixels | depth | 1 / w, negative where not to be used
//           positions   float[3 * vertex_count]   facets, and triangles that were clipped
//           normals     float[3 * vertex_count]   SMOOTH
//           values      float[value_count]        COLOUR 2 per triangle, 3 per vertex; 0..1 over the map; 4 colours
//           colour_map  float[4 * 256]            linear red, green, blue
// Writes    image       uint [height * 64 * tiles per row]   red, green, blue, 255; row 0 on top
// Needs     common/runs.cl
// Defines   SMOOTH 0 facets, 1 interpolated normals; COLOUR 0 one colour, 1 triangle id, 2 and 3 values, 4 vertices' own; WIRE, INSTANCED 0 or 1;
//           SEVERAL 1: a frame of several surfaces, each shaded by a launch of its own

#define FEW 50000 // vertices that caches hold anyway
// planes of what is known of a run: corners on the screen, then normals or the facet's, then values of corners
#define NORMALS (9 * RUN_ROOM)
#define VALUES (NORMALS + (SMOOTH ? 9 : 3) * RUN_ROOM)
#define PLANES (VALUES + (COLOUR == 4 ? 9 : 3) * RUN_ROOM)

__kernel void stages_fragment_shade(
    __global const long *restrict keys,
    __global const uint *restrict flags,
    __global const uint *restrict triangles,
    __global const int *restrict screen,
    __global const float *restrict positions,
    __global const float *restrict normals,
    __global const float *restrict values,
    __global const float *restrict colour_map,
    __global uint *restrict image,
    const float16 to_screen,
    const float4 key_light,   // xyz direction, w strength
    const float4 fill_light,
    const float4 sky_light,   // strength falls to a third below
    const float4 highlight,   // half way between key light and eye
    const float4 surface_colour,
    const float4 background_top,
    const float4 background_bottom,
    const float line_width,   // pixels, WIRE
    const uint instance_vertices,
    const uint first_id,      // of the frame's triangles: this surface's first
    const uint id_count,      // and how many are its own
    const uint behind,        // SEVERAL, 1: what is there already stays where this surface is not seen
    const uint triangles_per_value,
    const uint rows_per_item, // divides 64
    const int width,
    const int height,
    const uint pattern_count,
    const uint vertex_count,
    const uint map_count,
    const uint tile_count)
{
    const uint items_per_tile = TILE / rows_per_item;
    const uint tile = get_global_id(0) / items_per_tile;
    if (tile >= tile_count) return;
    const int tiles_per_row = (width + TILE - 1) / TILE;
    const int left = (int)(tile % tiles_per_row) * TILE, top = (int)(tile / tiles_per_row) * TILE;
    const int first = top + (int)(get_global_id(0) % items_per_tile * rows_per_item);
    const int end = min(first + (int)rows_per_item, height);
    if (first >= end) return;
    size_t maps[MAPS];
    uint opened = 0;
    for (uint map = 0; map < min(map_count, (uint)MAPS); ++map)
        if (flags[FLAGS_OPEN + map * tile_count + tile]) maps[opened++] = ((size_t)map * tile_count + tile) * TILE_PIXELS;
    uint instance_id = 0, instance_vertex = 0; // the first of the instance seen last
    Row rows[2];
    uint backgrounds[8];
    for (int row = opened ? first - 1 : first; row < end; ++row) {
        Row *shown = &rows[row & 1], *next = &rows[(row + 1) & 1];
        next->count = next->hits = 0;
        if (opened && row + 1 < end) {
            next->hits = row_ids(keys, maps, opened, next->ids, first_id, id_count, row + 1 - top);
            row_runs(next, triangles);
        }
        if (row < first) continue;
        const uint hits = opened ? shown->hits : 0;
        __global uint *out = image + (size_t)row * tiles_per_row * TILE + left;
        if (!((row - first) & 7)) { // of eight rows at once
            const float8 t = (convert_float8(row + LANE) + 0.5f) / (float)height;
            const float3 step = background_bottom.xyz - background_top.xyz;
            const planes8 colour = {background_top.x + step.x * t, background_top.y + step.y * t, background_top.z + step.z * t};
            vstore8(pixel_colour(colour), 0, backgrounds);
        }
        const uint8 background = backgrounds[(row - first) & 7];
        if (!hits) {
            for (int group = 0; group < GROUPS && !(SEVERAL && behind); ++group) vstore8(background, group, out);
            continue;
        }

        // short walks along the row rather than a long one: each leaves room for its own latencies to overlap
        uint corners[3][RUN_ROOM];
        const uint runs = shown->count;
        for (uint run = 0; run < runs; ++run) {
            const uint id = shown->shown[run];
            if (INSTANCED && id - instance_id >= pattern_count) { // a division takes longer than all the rest
                const uint instance = id / pattern_count;
                instance_id = instance * pattern_count, instance_vertex = instance * instance_vertices;
            }
            const uint3 c = vload3(id - instance_id, triangles) + instance_vertex;
            corners[0][run] = c.x;
            corners[1][run] = c.y;
            corners[2][run] = c.z;
            if (vertex_count < FEW) continue;
            prefetch(screen + 4 * (size_t)c.x, 1);
            prefetch(screen + 4 * (size_t)c.y, 1);
            prefetch(screen + 4 * (size_t)c.z, 1);
            if (SMOOTH) {
                prefetch(normals + 3 * (size_t)c.x, 1);
                prefetch(normals + 3 * (size_t)c.y, 1);
                prefetch(normals + 3 * (size_t)c.z, 1);
            }
        }
        for (uint run = runs; run & 7; ++run)
            for (int n = 0; n < 3; ++n) corners[n][run] = corners[n][runs - 1];

        float planes[PLANES];
        const float y = row * SUBPIXELS + SUBPIXELS / 2;
        for (uint run = 0; run < runs; run += 8) {
            planes8 facet[3];
            for (int n = 0; n < 3; ++n) {
                planes8 corner = gather_screen(screen, corners[n] + run);
                corner.y -= y;
                runs_store(corner, planes + 3 * n * RUN_ROOM + run);
                if (SMOOTH)
                    runs_store(gather(normals, corners[n] + run, vertex_count), planes + NORMALS + 3 * n * RUN_ROOM + run);
                else
                    facet[n] = gather(positions, corners[n] + run, vertex_count);
                if (COLOUR == 4)
                    runs_store(gather(values, corners[n] + run, vertex_count), planes + VALUES + 3 * n * RUN_ROOM + run);
                if (COLOUR == 3)
                    for (int lane = 0; lane < 8; ++lane)
                        planes[VALUES + n * RUN_ROOM + run + lane] = values[corners[n][run + lane]];
            }
            if (!SMOOTH)
                runs_store(facet_normal(difference(facet[1], facet[0]), difference(facet[2], facet[0])), planes + NORMALS + run);
            if (COLOUR == 2)
                for (uint lane = run; lane < min(run + 8, runs); ++lane)
                    planes[VALUES + lane] = values[shown->shown[lane] / triangles_per_value];
        }

        planes8 facing[GROUPS], colours[GROUPS];
        float8 inks[GROUPS];
        for (int group = 0; group < GROUPS; ++group) {
            if (!(hits >> group & 1)) continue;
            const float8 x = convert_float8((left + 8 * group + LANE) * SUBPIXELS + SUBPIXELS / 2);
            const int8 place = vload8(group, shown->places);
            const float *own = planes + shown->bases[group];
            planes8 a = runs_planes(own, place), b = runs_planes(own + 3 * RUN_ROOM, place);
            planes8 c = runs_planes(own + 6 * RUN_ROOM, place);
            float8 wa = a.z, wb = b.z, wc = c.z;
            if (lane_signs(as_int8(wa) | as_int8(wb) | as_int8(wc))) {
                planes8 p[3];
                for (int n = 0; n < 3; ++n) {
                    uint eight[8];
                    for (int lane = 0; lane < 8; ++lane)
                        eight[lane] = corners[n][shown->bases[group] + shown->places[8 * group + lane]];
                    p[n] = gather(positions, eight, vertex_count);
                }
                a = seen_from(p[0], to_screen, x, y), b = seen_from(p[1], to_screen, x, y), c = seen_from(p[2], to_screen, x, y);
                wa = wb = wc = 1.0f;
            } else {
                a.x -= x, b.x -= x, c.x -= x;
                a.z = b.z = c.z = 1.0f;
            }
            float8 u = b.x * c.y - c.x * b.y, v = c.x * a.y - a.x * c.y, w = a.x * b.y - b.x * a.y;
            if (WIRE) {
                const float8 edge = lesser(edge_distance(b, c, u), lesser(edge_distance(c, a, v), edge_distance(a, b, w)));
                inks[group] = 1.0f - 0.85f * clamp(line_width * 0.5f + 0.5f - edge, 0.0f, 1.0f);
            }
            // y grows downwards: a negative sum is the front. Snapped corners let a pixel fall just outside
            const float8 side = u + v + w > 0.0f ? (float8)(1.0f) : (float8)(-1.0f);
            const float8 zero = 0.0f;
            u = greater(u * side * wa, zero), v = greater(v * side * wb, zero), w = greater(w * side * wc, zero);
            const float8 inverse = 1.0f / greater(u + v + w, (float8)(1e-37f));
            u *= inverse, v *= inverse, w *= inverse;
            const float *known = own + VALUES;
            if (COLOUR == 2) colours[group].x = runs_at(known, place);
            if (COLOUR == 3) {
                const planes8 value = runs_planes(known, place);
                colours[group].x = u * value.x + v * value.y + w * value.z;
            }
            if (COLOUR == 4) {
                const planes8 ca = runs_planes(known, place), cb = runs_planes(known + 3 * RUN_ROOM, place);
                const planes8 cc = runs_planes(known + 6 * RUN_ROOM, place);
                colours[group].x = u * ca.x + v * cb.x + w * cc.x;
                colours[group].y = u * ca.y + v * cb.y + w * cc.y;
                colours[group].z = u * ca.z + v * cb.z + w * cc.z;
            }
            planes8 normal = runs_planes(own + NORMALS, place);
            if (SMOOTH) {
                const planes8 na = normal, nb = runs_planes(own + NORMALS + 3 * RUN_ROOM, place);
                const planes8 nc = runs_planes(own + NORMALS + 6 * RUN_ROOM, place);
                normal.x = u * na.x + v * nb.x + w * nc.x;
                normal.y = u * na.y + v * nb.y + w * nc.y;
                normal.z = u * na.z + v * nb.z + w * nc.z;
            }
            normal.x *= -side, normal.y *= -side, normal.z *= -side;
            facing[group] = normal;
        }

        for (int group = 0; group < GROUPS; ++group) {
            const planes8 normal = facing[group];
            const uint8 id = vload8(group, shown->ids);
            if (!(hits >> group & 1)) {
                if (!(SEVERAL && behind)) vstore8(background, group, out);
                continue;
            }
            planes8 colour = spread(surface_colour.xyz);
            if (COLOUR == 1) colour = scattered_colour(id + first_id);
            if (COLOUR == 2 || COLOUR == 3) colour = mapped_colour(colour_map, colours[group].x);
            if (COLOUR == 4) colour = colours[group];
            colour = lit_colour(colour, normal, key_light, fill_light, sky_light, highlight);
            if (WIRE) colour.x *= inks[group], colour.y *= inks[group], colour.z *= inks[group];
            const uint8 rest = SEVERAL && behind ? vload8(group, out) : background;
            vstore8(id != ID_EMPTY ? pixel_colour(colour) : rest, group, out);
        }
    }
}
