// The three corners of a triangle as a key: which triangles have the same ones, whichever way they face; and of eight.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

#define NO_TRIANGLE 0xFFFFFFFFu

// in ascending order
static inline uint3 corners_sorted(const uint3 c)
{
    const uint low = min(c.x, min(c.y, c.z)), high = max(c.x, max(c.y, c.z));
    return (uint3)(low, c.x ^ c.y ^ c.z ^ low ^ high, high);
}

static inline bool corners_same(const uint3 a, const uint3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// where a table of slot_mask + 1 rows, a power of two, is looked at first
static inline uint corners_slot(const uint3 key, const uint slot_mask)
{
    uint hash = key.x * 0x9E3779B1u ^ key.y * 0x85EBCA77u ^ key.z * 0xC2B2AE3Du;
    hash = (hash ^ (hash >> 15)) * 0x2C1B3C6Du;
    return (hash ^ (hash >> 13)) & slot_mask;
}

typedef struct { uint8 a, b, c; } corners8;

// the corners of triangles t .. t + 7, of which those from `end` on are vertex 0 three times
static inline corners8 corners_load8(__global const uint *restrict triangles, const uint t, const uint end)
{
    corners8 corners;
    if (t + 8 <= end) {
        const uint8 x = vload8(3 * (size_t)(t / 8), triangles);
        const uint8 y = vload8(3 * (size_t)(t / 8) + 1, triangles);
        const uint8 z = vload8(3 * (size_t)(t / 8) + 2, triangles);
        corners.a = (uint8)(x.s036, y.s147, z.s25);
        corners.b = (uint8)(x.s147, y.s25, z.s036);
        corners.c = (uint8)(x.s25, y.s036, z.s147);
    } else {
        uint a[8], b[8], c[8];
        for (uint j = 0; j < 8; ++j) {
            const uint3 v = t + j < end ? vload3(t + j, triangles) : (uint3)(0);
            a[j] = v.x;
            b[j] = v.y;
            c[j] = v.z;
        }
        corners.a = vload8(0, a);
        corners.b = vload8(0, b);
        corners.c = vload8(0, c);
    }
    return corners;
}
