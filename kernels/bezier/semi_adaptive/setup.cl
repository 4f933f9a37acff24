// Semi-adaptive tessellation, set-up: the vertices and triangles of a coarse triangle by its three edges.
//
// Source    Concheiro 2013, section 4.2 (one level, rows that are whole or empty); that all patterns are kept is a
//           reconstruction
// Work      1-D, one item per combination of edges
// Reads     nothing
// Writes    shapes   ulong[patterns]            nodes of each pattern, bits as bezier/cell.cl has them
//           lists    uint [48 * patterns]       ranks of the corners of its triangles, four in a word
// Needs     bezier/strips.cl, bezier/candidates.cl, bezier/semi_adaptive/edges.cl
// Plain     bezier/semi_adaptive/reference.py
// Defines   TEST (bezier/measures.cl), NORMALS, STREAMING (common/output.cl, 1), HALVES
//           (bezier/semi_adaptive/edges.cl)

__kernel void semi_adaptive_setup_patterns(
    __global ulong *restrict shapes, __global uint *restrict lists)
{
    const uint number = get_global_id(0);
    if (number >= PATTERN_COUNT) return;

    const uint left = semi_edge(number / (EDGE_KINDS * EDGE_KINDS));
    const uint right = semi_edge(number / EDGE_KINDS % EDGE_KINDS), base = semi_edge(number % EDGE_KINDS);
    const uint step = CELL >> bezier_edge_level(base);
    ulong mask = bezier_edge_mask(left, right, base);
    for (uint r = 1; r < CELL; ++r)
        for (uint c = step; c < r && ((left | right) >> r & 1); c += step) mask |= 1ul << bezier_node(r, c);
    uchar list[4 * LIST_WORDS];
    const uint count = 3 * bezier_strips(list, mask);
    for (uint k = count; k < 4 * LIST_WORDS; ++k) list[k] = 0;
    for (uint k = 0; k < LIST_WORDS; ++k)
        lists[(size_t)number * LIST_WORDS + k] = (uint)list[4 * k] | (uint)list[4 * k + 1] << 8 |
            (uint)list[4 * k + 2] << 16 | (uint)list[4 * k + 3] << 24;
    shapes[number] = mask;
}
