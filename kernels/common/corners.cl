// The three corners of a triangle as a key: which triangles have the same ones, whichever way they face.
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
