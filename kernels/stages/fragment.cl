// Fragment stage: the triangle that each pixel sees, lit by a key and a fill light under a pale sky.
//
// Source    Olano & Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates" (weights of the corners,
//           exact under perspective and for corners behind the eye); Blinn 1977 for the highlight
// Work      1-D, one item per few rows of 64 pixels of a tile, eight pixels at a time
// Reads     keys        long [map_count * tile_count * 4096]   depth above id; the smallest over the maps is seen
//           flags       uint [16 + map_count * tile_count]   from 16: tile is open
//           triangles   uint [3 * pattern_count]
//           screen      int  [4 * vertex_count]   x, y in sub-pixels | depth | 1 / w, negative where not to be used
//           positions   float[3 * vertex_count]   facets, and triangles that were clipped
//           normals     float[3 * vertex_count]   SMOOTH
//           values      float[value_count]        COLOUR 2 per triangle, 3 per vertex; 0..1 over the map; 4 colours
//           colour_map  float[4 * 256]            linear red, green, blue
// Writes    image       uint [height * 64 * tiles per row]   red, green, blue, 255; row 0 on top
// Needs     common/shading.cl
// Defines   SMOOTH 0 facets, 1 interpolated normals; COLOUR 0 one colour, 1 triangle id, 2 and 3 values, 4 vertices' own; WIRE, INSTANCED 0 or 1;
//           SEVERAL 1: a frame of several surfaces, each shaded by a launch of its own

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
    uint rows[2][TILE];
    uint next_hits = row_ids(
        keys, flags, triangles, rows[0], first_id, id_count, first - top, tile, tile_count, map_count);
    for (int row = first; row < end; ++row) {
        __global uint *out = image + (size_t)row * tiles_per_row * TILE + left;
        const float t = (row + 0.5f) / height;
        const uint8 background = pixel_colour(spread(background_top.xyz + (background_bottom.xyz - background_top.xyz) * t));

        // four short walks along the row rather than a long one: each leaves room for its own latencies to overlap
        const uint hits = next_hits;
        uint *ids = rows[(row - first) & 1];
        if (row + 1 < end)
            next_hits = row_ids(
                keys, flags, triangles, rows[(row + 1 - first) & 1], first_id, id_count, row + 1 - top, tile, tile_count,
                map_count);

        uint corners[3][TILE];
        uint twos = 0; // one bit per eight pixels: they see the triangle of the first or that of the last, no third
        for (int group = 0; group < GROUPS; ++group) {
            if (!(hits >> group & 1)) continue;
            const uint8 id = vload8(group, ids);
            const uint some = smallest_lane(id); // where nothing was hit, a neighbour's is looked at and thrown away
            const int8 second = id != id.s0;
            const bool two = !lane_signs(second & (id != id.s7));
            twos |= (uint)two << group;
            for (int lane = 0; lane < 8; lane += two ? 7 : 1) {
                const uint shown = ids[8 * group + lane] == ID_EMPTY ? some : ids[8 * group + lane];
                const uint3 c = triangle_corners(triangles, shown, pattern_count, instance_vertices);
                corners[0][8 * group + lane] = c.x;
                corners[1][8 * group + lane] = c.y;
                corners[2][8 * group + lane] = c.z;
                prefetch(screen + 4 * (size_t)c.x, 1);
                prefetch(screen + 4 * (size_t)c.y, 1);
                prefetch(screen + 4 * (size_t)c.z, 1);
                if (SMOOTH) {
                    prefetch(normals + 3 * (size_t)c.x, 1);
                    prefetch(normals + 3 * (size_t)c.y, 1);
                    prefetch(normals + 3 * (size_t)c.z, 1);
                }
            }
        }

        planes8 facing[GROUPS], weights[GROUPS];
        float8 inks[GROUPS];
        const float y = row * SUBPIXELS + SUBPIXELS / 2;
        for (int group = 0; group < GROUPS; ++group) {
            if (!(hits >> group & 1)) continue;
            const float8 x = convert_float8((left + 8 * group + LANE) * SUBPIXELS + SUBPIXELS / 2);
            const uint8 id = vload8(group, ids);
            const bool two = twos >> group & 1;
            const int8 second = id != id.s0;
            const uint *ra = corners[0] + 8 * group, *rb = corners[1] + 8 * group, *rc = corners[2] + 8 * group;
            planes8 a = gather_screen(screen, ra, two, second), b = gather_screen(screen, rb, two, second);
            planes8 c = gather_screen(screen, rc, two, second);
            planes8 pa, pb, pc;
            float8 wa = a.z, wb = b.z, wc = c.z;
            const bool clipped = lane_signs(as_int8(wa) | as_int8(wb) | as_int8(wc));
            if (clipped || !SMOOTH) {
                pa = gather(positions, ra, two, second, vertex_count);
                pb = gather(positions, rb, two, second, vertex_count);
                pc = gather(positions, rc, two, second, vertex_count);
            }
            if (clipped) {
                a = seen_from(pa, to_screen, x, y), b = seen_from(pb, to_screen, x, y), c = seen_from(pc, to_screen, x, y);
                wa = wb = wc = 1.0f;
            } else {
                a.x -= x, a.y -= y, b.x -= x, b.y -= y, c.x -= x, c.y -= y;
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
            if (COLOUR == 3) {
                const planes8 kept = {u, v, w};
                weights[group] = kept;
            }
            if (COLOUR == 4) {
                const planes8 ca = gather(values, ra, two, second, vertex_count);
                const planes8 cb = gather(values, rb, two, second, vertex_count);
                const planes8 cc = gather(values, rc, two, second, vertex_count);
                weights[group].x = u * ca.x + v * cb.x + w * cc.x;
                weights[group].y = u * ca.y + v * cb.y + w * cc.y;
                weights[group].z = u * ca.z + v * cb.z + w * cc.z;
            }
            planes8 normal;
            if (SMOOTH) {
                const planes8 na = gather(normals, ra, two, second, vertex_count);
                const planes8 nb = gather(normals, rb, two, second, vertex_count);
                const planes8 nc = gather(normals, rc, two, second, vertex_count);
                normal.x = u * na.x + v * nb.x + w * nc.x;
                normal.y = u * na.y + v * nb.y + w * nc.y;
                normal.z = u * na.z + v * nb.z + w * nc.z;
            } else
                normal = facet_normal(difference(pb, pa), difference(pc, pa));
            normal.x *= -side, normal.y *= -side, normal.z *= -side;
            facing[group] = normal;
        }

        for (int group = 0; group < GROUPS; ++group) {
            const planes8 normal = facing[group];
            const uint8 id = vload8(group, ids);
            if (!(hits >> group & 1)) {
                if (!(SEVERAL && behind)) vstore8(background, group, out);
                continue;
            }
            planes8 colour = spread(surface_colour.xyz);
            if (COLOUR == 1) colour = scattered_colour(id + first_id);
            if (COLOUR == 4) colour = weights[group];
            if (COLOUR == 2 || COLOUR == 3) {
                float value[3][8];
                for (int lane = 0; lane < 8; ++lane) {
                    const uint *shown = ids + 8 * group;
                    if (COLOUR == 2) value[0][lane] = shown[lane] == ID_EMPTY ? 0.0f : values[shown[lane] / triangles_per_value];
                    const int from = 8 * group + (twos >> group & 1 ? (shown[lane] == shown[0] ? 0 : 7) : lane);
                    if (COLOUR == 3)
                        for (int n = 0; n < 3; ++n) value[n][lane] = values[corners[n][from]];
                }
                const planes8 kept = weights[group];
                const float8 first = vload8(0, value[0]);
                colour = mapped_colour(
                    colour_map, COLOUR == 2 ? first : kept.x * first + kept.y * vload8(0, value[1]) + kept.z * vload8(0, value[2]));
            }
            colour = lit_colour(colour, normal, key_light, fill_light, sky_light, highlight);
            if (WIRE) colour.x *= inks[group], colour.y *= inks[group], colour.z *= inks[group];
            const uint8 rest = SEVERAL && behind ? vload8(group, out) : background;
            vstore8(id != ID_EMPTY ? pixel_colour(colour) : rest, group, out);
        }
    }
}
