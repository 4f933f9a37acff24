// What shading a pixel needs, for eight pixels at a time: corners gathered, distances, colours, lights' sums.
//
// Source    Olano & Greer 1997 for corners that have no place on the screen
// Work      functions only; what is fused says so with fma, so that every driver rounds alike
// Reads     nothing
// Writes    nothing
// Needs     common/screen.cl common/packed.cl
// Defines   INSTANCED, SEVERAL, SMOOTH as in stages/fragment.cl

#pragma OPENCL FP_CONTRACT OFF
#define GROUPS (TILE / 8) // of pixels in a tile's row

// eight corners, transposed: x, y and 1 / w
static inline planes8 gather_screen(__global const int *restrict screen, const uint *r)
{
#define RECORDS(j) as_float8((int8)(vload4(r[j], screen), vload4(r[j + 4], screen)))
    const fours8 f = transpose_fours(RECORDS(0), RECORDS(1), RECORDS(2), RECORDS(3));
#undef RECORDS
    const planes8 e = {convert_float8(as_int8(f.x)), convert_float8(as_int8(f.y)), f.w};
    return e;
}

// likewise rows of three floats; a row is loaded with the first of the next, which the last row does not have
static inline planes8 gather(__global const float *restrict rows, const uint *r, const uint count)
{
    float4 f[8];
    if (lane_signs(vload8(0, r) + 1 >= count))
        for (int k = 0; k < 8; ++k) f[k] = (float4)(vload3(r[k], rows), 0.0f);
    else
        for (int k = 0; k < 8; ++k) f[k] = vload4(0, rows + 3 * (size_t)r[k]);
    const fours8 t = transpose_fours(
        (float8)(f[0], f[4]), (float8)(f[1], f[5]), (float8)(f[2], f[6]), (float8)(f[3], f[7]));
    const planes8 e = {t.x, t.y, t.z};
    return e;
}

static inline planes8 spread(const float3 a)
{
    const planes8 e = {a.x, a.y, a.z};
    return e;
}

static inline planes8 times(const planes8 a, const float8 b)
{
    const planes8 e = {a.x * b, a.y * b, a.z * b};
    return e;
}

static inline planes8 product(const planes8 a, const planes8 b)
{
    const planes8 e = {a.x * b.x, a.y * b.y, a.z * b.z};
    return e;
}

static inline float8 inner(const planes8 a, const planes8 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }

static inline float8 toward(const planes8 a, const float3 b) { return inner(a, spread(b)); }

// a, b and c by their weights x, y and z
static inline planes8 weighted(const planes8 weight, const planes8 a, const planes8 b, const planes8 c)
{
    const planes8 x = {a.x, b.x, c.x}, y = {a.y, b.y, c.y}, z = {a.z, b.z, c.z};
    const planes8 e = {inner(weight, x), inner(weight, y), inner(weight, z)};
    return e;
}

// a b - c d
static inline float8 minor(const float8 a, const float8 b, const float8 c, const float8 d) { return fma(a, b, -(c * d)); }

static inline planes8 across(const planes8 a, const planes8 b)
{
    const planes8 e = {minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x)};
    return e;
}

static inline planes8 difference(const planes8 a, const planes8 b)
{
    const planes8 e = {a.x - b.x, a.y - b.y, a.z - b.z};
    return e;
}

// along the normal of the facet with these two edges, of a length that float holds however small or large they are
static inline planes8 facet_normal(planes8 a, planes8 b)
{
    float8 longest = greater(greater(fabs(a.x), fabs(a.y)), fabs(a.z));
    longest = greater(longest, greater(greater(fabs(b.x), fabs(b.y)), fabs(b.z)));
    const int8 power = as_int8(longest) & 0x7F800000;
    const float8 scale = as_float8(0x7F000000 - (power < 0x7E800000 ? power : 0x7E800000)); // one over it, nearly
    a.x *= scale, a.y *= scale, a.z *= scale;
    b.x *= scale, b.y *= scale, b.z *= scale;
    return across(a, b);
}

// a corner that the vertex stage could not place: clip-space x and y, moved so that the pixel is the origin
static inline planes8 seen_from(const planes8 p, const float16 m, const float8 x, const float y)
{
    const float8 w = toward(p, m.scde) + m.sf;
    const planes8 e = {fma(-x, w, toward(p, m.s012) + m.s3), fma((float8)(-y), w, toward(p, m.s456) + m.s7), w};
    return e;
}

// one over the length of the edge from a to b: a weight of the corner opposite times this is a distance in pixels
static inline float8 edge_inverse(const planes8 a, const planes8 b)
{
    const float8 x = minor(a.y, b.z, b.y, a.z), y = minor(b.x, a.z, a.x, b.z);
    return 1.0f / (sqrt(fma(x, x, y * y)) * SUBPIXELS + 1e-30f);
}

static inline uint8 channel(const float8 linear)
{
    const float8 byte = fma(sqrt(greater(linear, (float8)(0.0f))), (float8)(255.0f), (float8)(0.5f));
    return as_uint8(convert_int8(lesser(byte, (float8)(255.0f))));
}

static inline uint8 pixel_colour(const planes8 linear)
{
    return channel(linear.x) | (channel(linear.y) << 8) | (channel(linear.z) << 16) | 0xff000000u;
}

// a scattered colour per triangle: neighbours in number are far apart in hue
static inline planes8 scattered_colour(const uint8 id)
{
    uint8 h = id * 0x9e3779b1u;
    h = (h ^ (h >> 15)) * 0x85ebca77u;
    h ^= h >> 13;
    const planes8 e = {0.15f + convert_float8(convert_int8(h & 255u)) * (0.75f / 255.0f),
                     0.15f + convert_float8(convert_int8((h >> 8) & 255u)) * (0.75f / 255.0f),
                     0.15f + convert_float8(convert_int8((h >> 16) & 255u)) * (0.75f / 255.0f)};
    return e;
}

static inline planes8 mapped_colour(__global const float *restrict colour_map, const float8 value)
{
    uint rows[8];
    // & 255: no value, not even a NaN, names a row outside the map
    vstore8(as_uint8(convert_int8(clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f)) & 255u, 0, rows);
    float4 c[8];
    for (int k = 0; k < 8; ++k) c[k] = vload4(rows[k], colour_map);
    const planes8 e = {(float8)(c[0].x, c[1].x, c[2].x, c[3].x, c[4].x, c[5].x, c[6].x, c[7].x),
                     (float8)(c[0].y, c[1].y, c[2].y, c[3].y, c[4].y, c[5].y, c[6].y, c[7].y),
                     (float8)(c[0].z, c[1].z, c[2].z, c[3].z, c[4].z, c[5].z, c[6].z, c[7].z)};
    return e;
}

// which triangle each pixel of a row sees, in the maps whose keys of the row's tile begin at `maps`; one bit is set per
// eight pixels that see any
static inline uint row_ids(
    __global const long *restrict keys,
    const size_t *maps,
    const uint map_count,
    uint *ids,
    const uint first_id,
    const uint id_count,
    const int row)
{
    uint hits = 0;
    for (int group = 0; group < GROUPS; ++group) {
        long8 key = KEY_EMPTY;
        for (uint map = 0; map < map_count; ++map) {
            const long8 other = *(__global const long8 *)(keys + maps[map] + row * TILE + 8 * group);
            key = other < key ? other : key;
        }
        uint8 id = as_uint16(key).even; // convert_uint8 of a long8 breaks the programs that PoCL 3.0 caches
#if SEVERAL
        id -= first_id;
        id = id < id_count ? id : ID_EMPTY; // what other surfaces drew is none of this one's
#endif
        vstore8(id, group, ids);
        hits |= (uint)(lane_signs(id != ID_EMPTY) != 0) << group;
    }
    return hits;
}

static inline uint3 triangle_corners(
    __global const uint *restrict triangles, const uint id, const uint pattern_count, const uint instance_vertices)
{
    const uint instance = INSTANCED ? id / pattern_count : 0;
    return vload3(id - instance * pattern_count, triangles) + instance * instance_vertices;
}

// a colour under the lights, `normal` of any length; each light's strength in w, the sky's falls to a third below
static inline planes8 lit_colour(planes8 colour, const planes8 normal, const float4 key_light, const float4 fill_light,
    const float4 sky_light, const float4 highlight)
{
    const float8 square = inner(normal, normal);
    const float8 scale = 1.0f / sqrt(greater(square, (float8)(1e-37f)));
    const float8 zero = 0.0f;
    const float8 key = greater(toward(normal, key_light.xyz) * scale, zero) * key_light.w;
    const float8 fill = fma(greater(toward(normal, fill_light.xyz) * scale, zero), (float8)(fill_light.w), key);
    const float8 sky = fma(toward(normal, sky_light.xyz) * scale, (float8)(0.33f), (float8)(0.67f));
    const float8 lit = fma(sky, (float8)(sky_light.w), fill);
    float8 shine = greater(toward(normal, highlight.xyz) * scale, zero);
    shine *= shine, shine *= shine, shine *= shine, shine *= shine, shine *= shine;
    shine *= highlight.w;
    colour.x = fma(colour.x, lit, shine);
    colour.y = fma(colour.y, lit, shine);
    colour.z = fma(colour.z, lit, shine);
    return colour;
}
