// An octree's cells: their numbers along a Morton curve, on which the eight children of a cell follow each other.
//
// Source    Morton 1966 for the curve; DeCoro & Tatarchuk 2007, slides 29-31, for the tree
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     common/grid.cl
// Plain     cluster/octree/reference.py

#define LANES 16 // floats of a node's sums, about the node's centre
#define LANE_XX 0 // xx xy xz yy yz zz
#define LANE_BX 6 // b: x y z
#define LANE_C 9
#define LANE_CORNER_X 12 // sum of the corners: x y z
#define LANE_CORNERS 15
#define LEVELS 10 // most levels, the root's among them
#define RULE_TOTAL 0
#define RULE_RMS 1

// ten bits, two zeros before each
static inline uint8 octree_spread8(uint8 x)
{
    x = (x | (x << 16)) & 0x030000FFu;
    x = (x | (x << 8)) & 0x0300F00Fu;
    x = (x | (x << 4)) & 0x030C30C3u;
    return (x | (x << 2)) & 0x09249249u;
}

// every third bit
static inline uint octree_gather(uint x)
{
    x &= 0x09249249u;
    x = (x | (x >> 2)) & 0x030C30C3u;
    x = (x | (x >> 4)) & 0x0300F00Fu;
    x = (x | (x >> 8)) & 0x030000FFu;
    return (x | (x >> 16)) & 0x3FFu;
}

// where eight points in units of the finest cell are along one axis; clamped as in common/grid.cl
static inline int8 octree_steps8(const float8 q, const float per_axis, const uint cells)
{
    return clamp(convert_int8(q * per_axis), (int8)0, (int8)((int)cells - 1));
}

static inline uint8 octree_code8(const grid_points8 q, const float4 per_axis, const uint4 cells)
{
    return octree_spread8(as_uint8(octree_steps8(q.x, per_axis.x, cells.x))) |
        (octree_spread8(as_uint8(octree_steps8(q.y, per_axis.y, cells.y))) << 1) |
        (octree_spread8(as_uint8(octree_steps8(q.z, per_axis.z, cells.z))) << 2);
}
