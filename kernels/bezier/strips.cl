// The triangles between a coarse triangle's inserted vertices: rows of them are strips, and the gaps at the sides are filled.
//
// Source    Concheiro 2013, sections 3.1.2 and 3.1.3 (strips of vertices; extreme and reused vertices at the sides): the
//           zip of two rows and the cutting of ears beside them are reconstructions
// Work      functions only; whole numbers alone
// Reads     nothing
// Writes    nothing
// Needs     bezier/cell.cl
// Plain     bezier/strips.py
// Defines   NORMALS, STREAMING (common/output.cl, 1)

#define STRIP_TRIANGLES 64 // at the most

// between one vertex on a side and the next lies what rows without one leave: the chain of their ends, cut ear by ear
typedef struct {
    int row[CELL_SIDE], away[CELL_SIDE]; // columns away from the side
    uchar rank[CELL_SIDE];
    uint count;
} bezier_chain;

static inline uint bezier_triangle(uchar *list, const uint count, const uint a, const uint b, const uint c)
{
    list[3 * count] = a, list[3 * count + 1] = b, list[3 * count + 2] = c;
    return count + 1;
}

// the end of one more row; returns the triangles so far
static inline uint bezier_chain_on(
    bezier_chain *chain, uchar *list, uint count, const int row, const int away, const uint rank, const bool is_right)
{
    uint n = chain->count;
    for (; n > 1; --n) {
        const int r = chain->row[n - 2], x = chain->away[n - 2];
        if ((chain->away[n - 1] - x) * (row - r) <= (away - x) * (chain->row[n - 1] - r)) break;
        const uint first = chain->rank[n - 2], ear = chain->rank[n - 1];
        count = is_right ? bezier_triangle(list, count, first, ear, rank) : bezier_triangle(list, count, first, rank, ear);
    }
    if (away == 0) n = 0; // all was cut: a new chain begins
    chain->row[n] = row, chain->away[n] = away, chain->rank[n] = rank;
    chain->count = n + 1;
    return count;
}

// the triangles of a mask, as ranks of its vertices, turning as the coarse triangle does; returns how many
static inline uint bezier_strips(uchar *list, const ulong mask)
{
    bezier_chain left, right;
    left.row[0] = left.away[0] = right.row[0] = right.away[0] = 0;
    left.rank[0] = right.rank[0] = 0;
    left.count = right.count = 1;
    uint count = 0, above = 1, above_row = 0, above_rank = 0, rank = 1;
    for (uint r = 1; r <= CELL; ++r) {
        const uint bits = bezier_row_bits(mask, r);
        if (!bits) continue;
        // zip: of the two edges that may come next, the shorter one
        uint up = above & (above - 1), low = bits & (bits - 1), a = above_rank, b = rank;
        int c = bezier_lowest(above), d = bezier_lowest(bits);
        const int down = r - above_row, first = d;
        while (up | low) {
            const int next_c = up ? (int)bezier_lowest(up) : 99, next_d = low ? (int)bezier_lowest(low) : 99;
            const int to_low = 2 * (next_d - c) - down, to_up = 2 * (next_c - d) + down;
            if (low && (!up || to_low * to_low <= to_up * to_up)) {
                count = bezier_triangle(list, count, a, b, b + 1);
                ++b, d = next_d, low &= low - 1;
            } else {
                count = bezier_triangle(list, count, a, b, a + 1);
                ++a, c = next_c, up &= up - 1;
            }
        }
        const uint end = rank + popcount(bits) - 1, last = bezier_highest(bits);
        count = bezier_chain_on(&left, list, count, r, first, rank, false);
        count = bezier_chain_on(&right, list, count, r, (int)(r - last), end, true);
        above = bits, above_row = r, above_rank = rank, rank = end + 1;
    }
    return count;
}

// triangles of a list to their place, their vertices from number `first` on; returns the place behind them
static inline __global uint *bezier_put_triangles(__global uint *to, const uchar *list, const uint count, const uint first)
{
    for (uint k = 0; k < 3 * count; ++k) to[k] = first + list[k];
    return to + 3 * count;
}
