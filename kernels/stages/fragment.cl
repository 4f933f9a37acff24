// Fragment stage: the triangle that each pixel sees, lit by a key and a fill light under a pale sky.
//
// Source    Olano & Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates" (weights of the corners,
//           exact under perspective and for corners behind the eye); Blinn 1977 for the highlight
// Work      1-D, one item per few rows of 64 pixels of a tile, eight pixels at a time; what lies evenly along a triangle,
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
// lines of what is known of a run: its normal, distances from its edges, values times weights and the sum of these
#define INKS (3 * LINE)
#define VALUES (INKS + (WIRE ? 3 : 0) * LINE)
#define TOTAL (VALUES + (COLOUR == 4 ? 3 : 1) * LINE)
#define LINES (TOTAL + LINE)

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
            const planes8 colour = {fma(t, (float8)(step.x), (float8)(background_top.x)),
                fma(t, (float8)(step.y), (float8)(background_top.y)), fma(t, (float8)(step.z), (float8)(background_top.z))};
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
            __global const uint *own = triangles + 3 * (size_t)(id - instance_id);
            const uint a = own[0] + instance_vertex, b = own[1] + instance_vertex, c = own[2] + instance_vertex;
            corners[0][run] = a, corners[1][run] = b, corners[2][run] = c;
            if (vertex_count < FEW) continue;
            prefetch(screen + 4 * (size_t)a, 1);
            prefetch(screen + 4 * (size_t)b, 1);
            prefetch(screen + 4 * (size_t)c, 1);
            if (SMOOTH) {
                prefetch(normals + 3 * (size_t)a, 1);
                prefetch(normals + 3 * (size_t)b, 1);
                prefetch(normals + 3 * (size_t)c, 1);
            }
        }
        for (int n = 0; n < 3; ++n) vstore8((uint8)(corners[n][runs - 1]), 0, corners[n] + runs); // fills the last eight

        float lines[LINES];
        const float y = row * SUBPIXELS + SUBPIXELS / 2;
        for (uint run = 0; run < runs; run += 8) {
            const int8 first = vload8(0, shown->firsts + run);
            const float8 x = convert_float8((left + first) * SUBPIXELS + SUBPIXELS / 2), start = convert_float8(first);
            planes8 a = gather_screen(screen, corners[0] + run), b = gather_screen(screen, corners[1] + run);
            planes8 c = gather_screen(screen, corners[2] + run);
            float8 wa = a.z, wb = b.z, wc = c.z;
            const bool unplaced = lane_signs(as_int8(wa) | as_int8(wb) | as_int8(wc));
            planes8 p[3];
            if (!SMOOTH || unplaced)
                for (int n = 0; n < 3; ++n) p[n] = gather(positions, corners[n] + run, vertex_count);
            if (unplaced) {
                a = seen_from(p[0], to_screen, x, y), b = seen_from(p[1], to_screen, x, y), c = seen_from(p[2], to_screen, x, y);
                wa = wb = wc = 1.0f;
            } else {
                a.x -= x, b.x -= x, c.x -= x;
                a.y -= y, b.y -= y, c.y -= y;
                a.z = b.z = c.z = 1.0f;
            }
            // weights of the corners before normalisation: from pixel to pixel x falls by z
            planes8 weight = {minor(b.x, c.y, c.x, b.y), minor(c.x, a.y, a.x, c.y), minor(a.x, b.y, b.x, a.y)};
            planes8 step = {minor(c.z, b.y, b.z, c.y), minor(a.z, c.y, c.z, a.y), minor(b.z, a.y, a.z, b.y)};
            step = times(step, (float8)(SUBPIXELS));
            // y grows downwards: a negative sum is the front
            const float8 side = weight.x + weight.y + weight.z > 0.0f ? (float8)(1.0f) : (float8)(-1.0f);
            if (WIRE) {
                const planes8 over = {side * edge_inverse(b, c), side * edge_inverse(c, a), side * edge_inverse(a, b)};
                runs_lines(product(weight, over), product(step, over), start, lines + INKS + run);
            }
            const planes8 near = {wa, wb, wc};
            const planes8 seen = times(near, side / greater(inner(weight, near) * side, (float8)(1e-37f)));
            weight = product(weight, seen), step = product(step, seen);
            if (SMOOTH) {
                const planes8 na = gather(normals, corners[0] + run, vertex_count), nb = gather(normals, corners[1] + run, vertex_count);
                const planes8 nc = gather(normals, corners[2] + run, vertex_count);
                runs_lines(times(weighted(weight, na, nb, nc), -side), times(weighted(step, na, nb, nc), -side), start, lines + run);
            } else {
                const planes8 facet = facet_normal(difference(p[1], p[0]), difference(p[2], p[0]));
                runs_lines(times(facet, -side), spread((float3)(0.0f)), start, lines + run);
            }
            if (COLOUR == 2)
                for (uint lane = run; lane < min(run + 8, runs); ++lane)
                    lines[VALUES + lane] = values[shown->shown[lane] / triangles_per_value];
            if (COLOUR == 3) {
                float known[24];
                for (int k = 0; k < 24; ++k) known[k] = values[corners[k / 8][run + k % 8]];
                const planes8 value = {vload8(0, known), vload8(1, known), vload8(2, known)};
                runs_line(inner(weight, value), inner(step, value), start, lines + VALUES + run);
            }
            if (COLOUR == 4) {
                const planes8 ca = gather(values, corners[0] + run, vertex_count), cb = gather(values, corners[1] + run, vertex_count);
                const planes8 cc = gather(values, corners[2] + run, vertex_count);
                runs_lines(weighted(weight, ca, cb, cc), weighted(step, ca, cb, cc), start, lines + VALUES + run);
            }
            if (COLOUR >= 3) runs_line(weight.x + weight.y + weight.z, step.x + step.y + step.z, start, lines + TOTAL + run);
        }

        for (int group = 0; group < GROUPS; ++group) {
            if (!(hits >> group & 1)) {
                if (!(SEVERAL && behind)) vstore8(background, group, out);
                continue;
            }
            const float8 pixel = convert_float8(8 * group + LANE);
            const int8 place = vload8(group, shown->places);
            const float *own = lines + shown->bases[group];
            const uint8 id = vload8(group, shown->ids);
            planes8 colour = spread(surface_colour.xyz);
            if (COLOUR == 1) colour = scattered_colour(id + first_id);
            if (COLOUR == 2) colour = mapped_colour(colour_map, runs_at(own + VALUES, place));
            if (COLOUR >= 3) {
                const float8 over = 1.0f / greater(runs_along(own + TOTAL, place, pixel), (float8)(1e-37f));
                if (COLOUR == 3) colour = mapped_colour(colour_map, runs_along(own + VALUES, place, pixel) * over);
                if (COLOUR == 4) colour = times(runs_along3(own + VALUES, place, pixel), over);
            }
            const planes8 normal = runs_along3(own, place, pixel);
            colour = lit_colour(colour, normal, key_light, fill_light, sky_light, highlight);
            if (WIRE) {
                const planes8 edges = runs_along3(own + INKS, place, pixel);
                const float8 edge = fabs(lesser(edges.x, lesser(edges.y, edges.z)));
                colour = times(colour, 1.0f - 0.85f * clamp(line_width * 0.5f + 0.5f - edge, 0.0f, 1.0f));
            }
            const uint8 rest = SEVERAL && behind ? vload8(group, out) : background;
            vstore8(id != ID_EMPTY ? pixel_colour(colour) : rest, group, out);
        }
    }
}
