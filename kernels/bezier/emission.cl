// What a cell's two coarse triangles emit: the vertices of their masks, points and normals.
//
// Source    Concheiro 2013, section 3.3 (the geometry shader emits what was inserted)
// Work      functions only
// Reads     controls, sources          as bezier/cell.cl has them
// Writes    positions  float[3 * vertex_room]  packed; triangle after triangle, row after row
//           normals    float[3 * vertex_room]  packed, unit length; nothing where NORMALS is 0
// Needs     bezier/cell.cl
// Plain     bezier/candidates.py
// Defines   NORMALS (1: normals too)

// the rows of the cell's samples that a mask has a node in
static inline uint bezier_rows_used(const uint4 corners, const ulong mask)
{
    uint rows = 0;
    for (uint r = 0; r <= CELL; ++r)
        for (uint left = bezier_row_bits(mask, r); left; left &= left - 1)
            rows |= 1u << bezier_sample(corners, r, bezier_lowest(left)) / CELL_SIDE;
    return rows;
}

// vertices of both masks, from vertex v on
static inline void bezier_emit(__global float *restrict positions, __global float *restrict normals,
    __global const float *restrict controls, __global const uint *restrict sources, const bezier_map map,
    const bezier_cell cell, const ulong2 masks, uint v, const uint side)
{
    bezier_patch patch;
    bezier_patch_at(&patch, controls, cell.patch);
    float points[CELL_FLOATS], directions[NORMALS ? CELL_FLOATS : 1];
    const uint4 ways[2] = {bezier_corners(bezier_way(masks.x)), bezier_corners(bezier_way(masks.y))};
    const uint rows = bezier_rows_used(ways[0], masks.x) | bezier_rows_used(ways[1], masks.y);
    bezier_cell_rows(points, directions, &patch, map, cell, rows, side);
    const uint last = side - 1;
    const bool is_outer = cell.i == 0 || cell.j == 0 || cell.i + CELL == last || cell.j + CELL == last;
    for (uint t = 0; t < 2; ++t) {
        const ulong mask = t ? masks.y : masks.x;
        for (uint r = 0; r <= CELL; ++r) {
            for (uint left = bezier_row_bits(mask, r); left; left &= left - 1, ++v) {
                const uint c = bezier_lowest(left), at = bezier_sample(ways[t], r, c);
                vstore3(vload3(at, points), v, positions);
#if NORMALS
                float3 n = vload3(at, directions);
                if (is_outer) {
                    const uint i = cell.i + at / CELL_SIDE, j = cell.j + at % CELL_SIDE;
                    if (i == 0 || i == last || j == 0 || j == last)
                        n = bezier_border_normal(controls, sources, cell.patch, i, j, last);
                }
                vstore3(n, v, normals);
#endif
            }
        }
    }
}
