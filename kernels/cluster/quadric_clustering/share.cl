// The cluster map: which triangles belong to which private map, and what stands where in a cell's row.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     cluster/quadric_clustering/reference.py

// floats of a cell in a private map
#define LANES 16
#define LANE_XX 0 // xx xy xz yy yz zz
#define LANE_BX 6 // b: x y z
#define LANE_SURVIVING 9 // corners of triangles that survive
#define LANE_CORNER_X 12 // sum of the corners: x y z
#define LANE_CORNERS 15
// words of a cell in the one map of fixed-point sums
#define WORDS 14
#define WORD_XX 0
#define WORD_BX 6
#define WORD_CORNER_X 9
#define WORD_CORNERS 12
#define WORD_SURVIVING 13

static inline uint2 geometry_share(const uint map, const uint map_count, const uint triangle_count)
{
    return (uint2)((ulong)triangle_count * map / map_count, (ulong)triangle_count * (map + 1) / map_count);
}
