// The triangles of half a cell that is cut into a grid: rows that have all columns are strips, sides fan out to finer edges.
//
// Source    reconstruction; strips as in Concheiro 2013, section 3.1.2
// Work      functions only; whole numbers alone
// Reads     nothing
// Writes    nothing
// Needs     bezier/strips.cl
// Plain     bezier/half_strips.py
// Defines   NORMALS, STREAMING (common/output.cl, 1)

#define COLUMNS_BIT 57 // and the next, of a mask: log2 of its columns
#define OTHER_CUT 59   // this bit: cut along the other diagonal

// nine places of which every 8 >> level has a vertex, from bit 0 on
static inline uint half_on(const uint level)
{
    return 0x101 | (level > 0 ? 0x10 : 0) | (level > 1 ? 0x44 : 0) | (level > 2 ? 0xaa : 0);
}

static inline uint half_rank(const ulong mask, const uint r, const uint c)
{
    return (uint)popcount(mask & ((1ul << (CELL_SIDE * r + c)) - 1));
}

// from a row to the one below, along a side, each piece with the vertex that it faces
static inline uint half_fan(uchar *list, uint count, const ulong mask, const uint above, const uint below, const uint c, const uint facing)
{
    uint at = half_rank(mask, above, c);
    for (uint r = above + 1; r <= below; ++r) {
        if (r < below && !(bezier_half_row(mask, r) >> c & 1)) continue;
        const uint next = half_rank(mask, r, c);
        count = c ? bezier_triangle(list, count, facing, next, at) : bezier_triangle(list, count, at, next, facing);
        at = next;
    }
    return count;
}

// the triangles of a half, as ranks of its vertices; returns how many
static inline uint half_strips(uchar *list, const ulong mask)
{
    const uint columns = half_on((uint)(mask >> COLUMNS_BIT) & 3);
    const int other = (int)(mask >> OTHER_CUT & 1);
    uint count = 0, above = 0;
    for (uint below = 1; below < HALF_ROWS; ++below) {
        const uint upper = bezier_half_row(mask, above), lower = bezier_half_row(mask, below);
        if (columns & ~lower) continue;
        uint up = upper & (upper - 1), low = lower & (lower - 1);
        uint a = half_rank(mask, above, 0), b = half_rank(mask, below, 0);
        int c = 0, d = 0;
        bool is_first = true;
        while (up | low) {
            const int next_c = up ? (int)bezier_lowest(up) : 99, next_d = low ? (int)bezier_lowest(low) : 99;
            const int to_low = next_d - c, to_up = next_c - d;
            const bool down = low && (!up || to_low * to_low + other <= to_up * to_up);
            const uint tip = (down ? b : a) + 1;
            if (down) d = next_d, low &= low - 1;
            else c = next_c, up &= up - 1;
            if (is_first) count = half_fan(list, count, mask, above, below, 0, tip);
            else if (!(up | low)) count = half_fan(list, count, mask, above, below, CELL, down ? b : a);
            else count = bezier_triangle(list, count, a, b, tip);
            a += !down, b += down, is_first = false;
        }
        above = below;
    }
    return count;
}
