// Fragment stage: the triangle that each pixel sees, lit by a key and a fill light under a pale sky.
//
// Source    Olano & Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates" (weights of the corners,
//           exact under perspective and for corners behind the eye); Blinn 1977 for the highlight
// Work      1-D, one item per row of 64 pixels of a tile, eight pixels at a time
// Reads     keys        long [map_count * tile_count * 4096]   depth above id; the smallest over the maps is seen
//           flags       uint [16 + map_count * tile_count]   from 16: tile is open
//           triangles   uint [3 * pattern_count]
//           positions   float[3 * vertex_count]
//           normals     float[3 * vertex_count]   SMOOTH
//           values      float[value_count]        COLOUR 2 per triangle, 3 per vertex; 0..1 over the map
//           colour_map  float[4 * 256]            linear red, green, blue
// Writes    image       uint [height * 64 * tiles per row]   red, green, blue, 255; row 0 on top
// Needs     common/screen.cl
// Defines   SMOOTH 0 facets, 1 interpolated normals; COLOUR 0 one colour, 1 triangle id, 2 and 3 values; WIRE, INSTANCED 0 or 1

#pragma OPENCL FP_CONTRACT ON

typedef struct {
    float8 x, y, z;
} Eight;

// three floats as four: one load, also for the last row, where the fourth does not exist
static inline float4 row_of_three(__global const float *restrict rows, const uint row, const uint count)
{
    return row + 1 < count ? vload4(0, rows + 3 * (size_t)row) : (float4)(vload3(row, rows), 0.0f);
}

static inline Eight gather(__global const float *restrict rows, const uint *r, const uint count)
{
    const float8 p = (float8)(row_of_three(rows, r[0], count), row_of_three(rows, r[4], count));
    const float8 q = (float8)(row_of_three(rows, r[1], count), row_of_three(rows, r[5], count));
    const float8 s = (float8)(row_of_three(rows, r[2], count), row_of_three(rows, r[6], count));
    const float8 t = (float8)(row_of_three(rows, r[3], count), row_of_three(rows, r[7], count));
    const float8 pq = LANES(p, q, 0, 8, 1, 9, 4, 12, 5, 13), st = LANES(s, t, 0, 8, 1, 9, 4, 12, 5, 13);
    const float8 pqz = LANES(p, q, 2, 10, 2, 10, 6, 14, 6, 14), stz = LANES(s, t, 2, 10, 2, 10, 6, 14, 6, 14);
    Eight e;
    e.x = LANES(pq, st, 0, 1, 8, 9, 4, 5, 12, 13);
    e.y = LANES(pq, st, 2, 3, 10, 11, 6, 7, 14, 15);
    e.z = LANES(pqz, stz, 0, 1, 8, 9, 4, 5, 12, 13);
    return e;
}

static inline Eight spread(const float3 a)
{
    const Eight e = {a.x, a.y, a.z};
    return e;
}

static inline float8 toward(const Eight a, const float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline Eight across(const Eight a, const Eight b)
{
    const Eight e = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return e;
}

static inline Eight difference(const Eight a, const Eight b)
{
    const Eight e = {a.x - b.x, a.y - b.y, a.z - b.z};
    return e;
}

// clip-space x and y of a corner, moved so that the pixel is the origin; w beside it
static inline Eight seen_from(const Eight p, const float16 m, const float8 x, const float y)
{
    Eight e;
    e.z = m.sc * p.x + m.sd * p.y + m.se * p.z + m.sf;
    e.x = (m.s0 * p.x + m.s1 * p.y + m.s2 * p.z + m.s3) - x * e.z;
    e.y = (m.s4 * p.x + m.s5 * p.y + m.s6 * p.z + m.s7) - y * e.z;
    return e;
}

// pixels between the pixel's centre and the edge from a to b; `weight` is the corner opposite, before normalisation
static inline float8 edge_distance(const Eight a, const Eight b, const float8 weight)
{
    const float8 x = a.y * b.z - b.y * a.z, y = b.x * a.z - a.x * b.z;
    return fabs(weight) / (sqrt(x * x + y * y) * SUBPIXELS + 1e-30f);
}

static inline uint8 channel(const float8 linear)
{
    return convert_uint8(convert_int8(min(sqrt(max(linear, 0.0f)) * 255.0f + 0.5f, 255.0f)));
}

static inline uint8 pixel_colour(const Eight linear)
{
    return channel(linear.x) | (channel(linear.y) << 8) | (channel(linear.z) << 16) | 0xff000000u;
}

// a scattered colour per triangle: neighbours in number are far apart in hue
static inline Eight scattered_colour(const uint8 id)
{
    uint8 h = id * 0x9e3779b1u;
    h = (h ^ (h >> 15)) * 0x85ebca77u;
    h ^= h >> 13;
    const Eight e = {0.15f + convert_float8(convert_int8(h & 255u)) * (0.75f / 255.0f),
                     0.15f + convert_float8(convert_int8((h >> 8) & 255u)) * (0.75f / 255.0f),
                     0.15f + convert_float8(convert_int8((h >> 16) & 255u)) * (0.75f / 255.0f)};
    return e;
}

static inline Eight mapped_colour(__global const float *restrict colour_map, const float8 value)
{
    uint rows[8];
    vstore8(convert_uint8(convert_int8(clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f)), 0, rows);
    float4 c[8];
    for (int k = 0; k < 8; ++k) c[k] = vload4(rows[k], colour_map);
    const Eight e = {(float8)(c[0].x, c[1].x, c[2].x, c[3].x, c[4].x, c[5].x, c[6].x, c[7].x),
                     (float8)(c[0].y, c[1].y, c[2].y, c[3].y, c[4].y, c[5].y, c[6].y, c[7].y),
                     (float8)(c[0].z, c[1].z, c[2].z, c[3].z, c[4].z, c[5].z, c[6].z, c[7].z)};
    return e;
}

__kernel void stages_fragment_shade(
    __global const long *restrict keys,
    __global const uint *restrict flags,
    __global const uint *restrict triangles,
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
    const uint triangles_per_value,
    const int width,
    const int height,
    const uint pattern_count,
    const uint vertex_count,
    const uint map_count,
    const uint tile_count)
{
    const size_t item = get_global_id(0);
    const uint tile = item / TILE;
    if (tile >= tile_count) return;
    const int tiles_per_row = (width + TILE - 1) / TILE;
    const int left = (int)(tile % tiles_per_row) * TILE, row = (int)(tile / tiles_per_row) * TILE + (int)(item % TILE);
    if (row >= height) return;
    __global uint *out = image + (size_t)row * tiles_per_row * TILE + left;
    const float t = (row + 0.5f) / height;
    const uint8 background = pixel_colour(spread(background_top.xyz + (background_bottom.xyz - background_top.xyz) * t));

    for (int column = 0; column < TILE; column += 8) {
        long8 key = KEY_EMPTY;
        for (uint map = 0; map < map_count; ++map)
            if (flags[FLAGS_OPEN + map * tile_count + tile]) {
                const size_t pixel = ((size_t)map * tile_count + tile) * TILE_PIXELS + item % TILE * TILE + column;
                const long8 other = *(__global const long8 *)(keys + pixel);
                key = other < key ? other : key;
            }
        const uint8 id = as_uint16(key).even; // convert_uint8 of a long8 breaks PoCL 3.0's cached programs
        const int8 hit = id != 0xffffffffu;
        if (!any_lane(hit)) {
            vstore8(background, 0, out + column);
            continue;
        }
        // where nothing was hit, a triangle that a neighbour hit is looked at and thrown away
        const uint some = smallest_lane(id);
        const uint8 shown = hit ? id : (uint8)(some);
        const bool single = !any_lane(shown != some);
        uint corners[3][8];
        uint ids[8];
        vstore8(shown, 0, ids);
        Eight p[3], n[3];
        for (int lane = 0; lane < (single ? 1 : 8); ++lane) {
            const uint instance = INSTANCED ? ids[lane] / pattern_count : 0;
            const uint k = ids[lane] - instance * pattern_count, base = instance * instance_vertices;
            for (int c = 0; c < 3; ++c) corners[c][lane] = triangles[3 * (size_t)k + c] + base;
        }
        for (int c = 0; c < 3; ++c)
            if (single) {
                p[c] = spread(vload3(corners[c][0], positions));
                if (SMOOTH) n[c] = spread(vload3(corners[c][0], normals));
            } else {
                p[c] = gather(positions, corners[c], vertex_count);
                if (SMOOTH) n[c] = gather(normals, corners[c], vertex_count);
            }

        const float8 x = convert_float8((left + column + LANE) * SUBPIXELS + SUBPIXELS / 2);
        const float y = row * SUBPIXELS + SUBPIXELS / 2;
        const Eight a = seen_from(p[0], to_screen, x, y), b = seen_from(p[1], to_screen, x, y);
        const Eight c = seen_from(p[2], to_screen, x, y);
        float8 u = b.x * c.y - c.x * b.y, v = c.x * a.y - a.x * c.y, w = a.x * b.y - b.x * a.y;
        const float8 whole = u + v + w; // y grows downwards: negative is the front
        const float8 edge = WIRE ? min(edge_distance(b, c, u), min(edge_distance(c, a, v), edge_distance(a, b, w))) : (float8)(0.0f);
        const float8 side = whole > 0.0f ? (float8)(-1.0f) : (float8)(1.0f);
        // snapped corners let a pixel fall just outside
        u = max(u * -side, 0.0f), v = max(v * -side, 0.0f), w = max(w * -side, 0.0f);
        const float8 inverse = 1.0f / max(u + v + w, 1e-37f);
        u *= inverse, v *= inverse, w *= inverse;

        Eight normal;
        if (SMOOTH) {
            normal.x = u * n[0].x + v * n[1].x + w * n[2].x;
            normal.y = u * n[0].y + v * n[1].y + w * n[2].y;
            normal.z = u * n[0].z + v * n[1].z + w * n[2].z;
        } else
            normal = across(difference(p[1], p[0]), difference(p[2], p[0]));
        const float8 scale = side / sqrt(max((normal.x * normal.x + normal.y * normal.y + normal.z * normal.z), 1e-37f));

        Eight colour = spread(surface_colour.xyz);
        if (COLOUR == 1) colour = scattered_colour(shown);
        if (COLOUR == 2 || COLOUR == 3) {
            float first[8], second[8], third[8];
            for (int lane = 0; lane < 8; ++lane) {
                const int from = single ? 0 : lane;
                first[lane] = values[COLOUR == 2 ? ids[from] / triangles_per_value : corners[0][from]];
                second[lane] = COLOUR == 2 ? 0.0f : values[corners[1][from]];
                third[lane] = COLOUR == 2 ? 0.0f : values[corners[2][from]];
            }
            const float8 value = vload8(0, first);
            colour = mapped_colour(colour_map, COLOUR == 2 ? value : u * value + v * vload8(0, second) + w * vload8(0, third));
        }

        const float8 lit = max(toward(normal, key_light.xyz) * scale, 0.0f) * key_light.w +
                           max(toward(normal, fill_light.xyz) * scale, 0.0f) * fill_light.w +
                           (toward(normal, sky_light.xyz) * scale * 0.33f + 0.67f) * sky_light.w;
        float8 shine = max(toward(normal, highlight.xyz) * scale, 0.0f);
        shine *= shine, shine *= shine, shine *= shine, shine *= shine, shine *= shine;
        shine *= highlight.w;
        // lines darken what they cross, fading over one pixel
        const float8 ink = WIRE ? 1.0f - 0.85f * clamp(line_width * 0.5f + 0.5f - edge, 0.0f, 1.0f) : (float8)(1.0f);
        colour.x = (colour.x * lit + shine) * ink;
        colour.y = (colour.y * lit + shine) * ink;
        colour.z = (colour.z * lit + shine) * ink;
        vstore8(hit ? pixel_colour(colour) : background, 0, out + column);
    }
}
