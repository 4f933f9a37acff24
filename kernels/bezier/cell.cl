// A cell of a patch's parametric map, 8 x 8, and the two coarse triangles in it: what is sampled, and which nodes they have.
//
// Source    Concheiro 2013, chapter 3: a patch begins as coarse triangles, and a fixed pattern says where vertices may be
// Work      functions only. Samples are those of vst, by bezier/row.cl
// Reads     controls  float[64 * patches]  as bezier/patch.cl has it
//           sources   uint [8 * patches]   of each edge (2 (4 patch + edge) + [it runs against it]) and corner (4 patch +
//                                          corner) of a patch the one whose normals it has
// Writes    nothing
// Needs     bezier/row.cl
// Plain     bezier/candidates.py
// Defines   NORMALS (1: normals too), STREAMING (common/output.cl; 1: rows are written to a work-item's own store)

// node (r, c) of a triangle, 0 <= c <= r <= 8, is bit r (r + 1) / 2 + c of its mask: left c = 0, right c = r, base r = 8.
// Which corner of the cell is row 0, and which are the ends of the base, is the triangle's way, 0 to 11, from bit 60 on.
// Ways 12 to 15 are halves of the cell: node (r, c), r <= 4, c <= 8, is bit 9 r + c; rows along j or, of 14 and 15, along i

#define CELL 8
#define CELL_SIDE 9
#define HALF_ROWS 5
#define FIRST_HALF 12
#define CELL_FLOATS (3 * (CELL_SIDE * CELL_SIDE + 8)) // a row's last vector reaches into the next

typedef struct {
    uint patch, i, j; // the patch's number, and the cell's first row and column in its map
} bezier_cell;

static inline bezier_cell bezier_cell_of(const uint cell, const uint across)
{
    const uint each = across * across, within = cell % each;
    bezier_cell found;
    found.patch = cell / each, found.i = within / across * CELL, found.j = within % across * CELL;
    return found;
}

static inline uint bezier_node(const uint r, const uint c) { return r * (r + 1) / 2 + c; }

// of the cell's 81 samples, 9 i + j, those at a triangle's corners: row 0, left and right end of the base
static inline uint4 bezier_corners(const uint way)
{
    const uint turn = way % 3;
    const uint3 all = way < 3 ? (uint3)(0, 72, 80) : way < 6 ? (uint3)(0, 80, 8) : way < 9 ? (uint3)(0, 72, 8) : (uint3)(72, 80, 8);
    return turn == 0 ? (uint4)(all.x, all.y, all.z, 0) : turn == 1 ? (uint4)(all.y, all.z, all.x, 0) : (uint4)(all.z, all.x, all.y, 0);
}

// the sample of a node
static inline uint bezier_sample(const uint4 corners, const uint r, const uint c)
{
    return (corners.x * (CELL - r) + corners.y * (r - c) + corners.z * c) / CELL;
}

// of a half's node
static inline uint bezier_half_sample(const uint way, const uint r, const uint c)
{
    const uint row = (way & 1) * (HALF_ROWS - 1) + r;
    return way < FIRST_HALF + 2 ? CELL_SIDE * row + c : CELL_SIDE * (CELL - c) + row;
}

static inline uint bezier_half_row(const ulong mask, const uint r) { return (uint)(mask >> CELL_SIDE * r) & 0x1ff; }

// the nodes of row r, from column 0 on
static inline uint bezier_row_bits(const ulong mask, const uint r)
{
    return (uint)(mask >> bezier_node(r, 0)) & ((2u << r) - 1);
}

static inline uint bezier_way(const ulong mask) { return (uint)(mask >> 60); }

static inline ulong bezier_nodes(const ulong mask) { return mask & (1ul << 45) - 1; }

// vertices on edges, bits 1 .. 7 from row 0 or the left on, as a mask with the corners
static inline ulong bezier_edge_mask(const uint left, const uint right, const uint base)
{
    ulong mask = 1ul | 1ul << bezier_node(CELL, 0) | 1ul << bezier_node(CELL, CELL) | (ulong)base << bezier_node(CELL, 0);
    for (uint k = 1; k < CELL; ++k)
        mask |= (ulong)(left >> k & 1) << bezier_node(k, 0) | (ulong)(right >> k & 1) << bezier_node(k, k);
    return mask;
}

static inline uint bezier_lowest(const uint bits) { return 31 - clz(bits & (0u - bits)); }

static inline uint bezier_highest(const uint bits) { return 31 - clz(bits); }

// row i of the cell, which is number `lane` of the block: points, and normals where NORMALS is 1
static inline void bezier_cell_row(float *points, float *normals, const bezier_block *block, const uint lane,
    const bezier_patch *patch, const bezier_map map, const bezier_cell cell, const uint i, const uint side)
{
    const uint row = cell.i + i, at = 3 * CELL_SIDE * i;
    if (row == 0 || row == side - 1) bezier_border(points + at, block, lane, map, cell.j, CELL_SIDE, 16);
    else bezier_points(points + at, block, lane, map, cell.j, CELL_SIDE, 16, side);
#if NORMALS
    bezier_normals(normals + at, block, lane, patch, map, row, cell.j, CELL_SIDE, 16, side);
#endif
}

// the cell's rows whose bit is set in `rows`
static inline void bezier_cell_rows(float *points, float *normals, const bezier_patch *patch, const bezier_map map,
    const bezier_cell cell, const uint rows, const uint side)
{
    for (uint first = 0; first < CELL_SIDE; first += BEZIER_ROWS) {
        if (!(rows >> first & 0xff)) continue;
        bezier_block block;
        bezier_block_of(&block, patch, map, cell.i + first);
        for (uint i = first; i < min(first + BEZIER_ROWS, (uint)CELL_SIDE); ++i)
            if (rows >> i & 1) bezier_cell_row(points, normals, &block, i - first, patch, map, cell, i, side);
    }
}

// the patch whose normal vertex (i, j) of a patch's border has, and where on it: of the first of all that meet smoothly there
static inline uint bezier_source(float2 *where, __global const uint *restrict sources, const uint p, const uint i,
    const uint j, const uint segments)
{
    const bool is_corner = (i == 0 || i == segments) && (j == 0 || j == segments);
    const uint edge = i == 0 ? 0 : i == segments ? 1 : j == 0 ? 2 : 3;
    if (is_corner) {
        const uint found = sources[8 * (size_t)p + 4 + (i ? 2 : 0) + (j ? 1 : 0)];
        *where = (float2)((float)(found >> 1 & 1), (float)(found & 1));
        return found / 4;
    }
    const uint found = sources[8 * (size_t)p + edge], there = found >> 1 & 3;
    const uint k = edge < 2 ? j : i;
    const float t = (float)(found & 1 ? segments - k : k) / (float)segments; // exact: segments are a power of two
    *where = there < 2 ? (float2)((float)there, t) : (float2)(t, (float)(there - 2));
    return found >> 3;
}
