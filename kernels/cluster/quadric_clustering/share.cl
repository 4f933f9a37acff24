// Which triangles belong to which private map.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing

static inline uint2 geometry_share(const uint map, const uint map_count, const uint triangle_count)
{
    return (uint2)((ulong)triangle_count * map / map_count, (ulong)triangle_count * (map + 1) / map_count);
}
