// Level chain, fragment stage: each cell of a level is the sum of the 2 x 2 x 2 cells of the level before.
//
// Source    DeCoro & Tatarchuk 2007, alternate pass 2 (downsampled quadric map); of the occupied cells alone, by rank
// Work      1-D, one item per chunk of the coarser level's 64-cell words
// Reads     fine_words    ulong2[fine_word_count]     of the level before; x: the cells' bits, y: occupied cells before these 64
//           fine_maps     float[16 * fine_capacity * fine_map_count]  its cluster map, in private maps for the first level
//           fine_sums     long[14 * fine_capacity]    the same in fixed point
//           fine_ranks    uint[fine_capacity]         output vertex of its cells
// Writes    words         ulong2[word_count]
//           chunk_sums    uint[chunk_count]           occupied cells of each chunk of words, of `bits`
//           state         uint[4]                     [0]: occupied cells
//           maps          float[16 * capacity]        in units of this level's cells; of its surviving corners none
//           sums          long[14 * capacity]         as they are added up: a scale says in which units
//           parents       uint[fine_capacity]         the cell, by rank, of each output vertex of the level before
// Needs     common/chunk.cl cluster/quadric_clustering/share.cl
// Plain     cluster/level_chain/reference.py

#define ROW 32 // cells of a row that are made at once, of 64 bits

// 64 bits from `cell` on; cells past the end of its row are the next row's
static inline ulong fragment_row(__global const ulong2 *restrict words, const uint word_count, const uint cell)
{
    const uint word = cell / 64, shift = cell % 64;
    const ulong bits = words[word].x >> shift;
    return shift && word + 1 < word_count ? bits | words[word + 1].x << (64 - shift) : bits;
}

// a bit for each pair of bits, set where either is
static inline ulong fragment_pairs(ulong bits)
{
    bits = (bits | bits >> 1) & 0x5555555555555555ul;
    bits = (bits | bits >> 1) & 0x3333333333333333ul;
    bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0ful;
    bits = (bits | bits >> 4) & 0x00ff00ff00ff00fful;
    bits = (bits | bits >> 8) & 0x0000ffff0000fffful;
    return (bits | bits >> 16) & 0x00000000fffffffful;
}

__kernel void level_chain_fragment_bits(
    __global const ulong2 *restrict fine_words,
    __global ulong2 *restrict words,
    __global uint *restrict chunk_sums,
    const uint4 fine_cells,
    const uint4 cells, // w: their number
    const uint fine_word_count,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);
    uint sum = 0;
    for (uint w = rows.x; w < rows.y; ++w) {
        const uint first = 64 * w, end = min(first + 64, cells.w);
        uint x = first % cells.x, y = first / cells.x % cells.y, z = first / cells.x / cells.y;
        ulong bits = 0;
        for (uint cell = first; cell < end;) {
            const uint take = min(min(cells.x - x, (uint)ROW), end - cell);
            ulong four = 0;
            for (uint dz = 0; dz < 2; ++dz)
                for (uint dy = 0; dy < 2; ++dy)
                    if (2 * y + dy < fine_cells.y && 2 * z + dz < fine_cells.z)
                        four |= fragment_row(fine_words, fine_word_count,
                            ((2 * z + dz) * fine_cells.y + 2 * y + dy) * fine_cells.x + 2 * x);
            const uint own = min(2 * take, fine_cells.x - 2 * x); // bits of this row
            if (own < 64) four &= (1ul << own) - 1;
            bits |= fragment_pairs(four) << (cell - first);
            cell += take;
            x += take;
            if (x == cells.x) {
                x = 0;
                if (++y == cells.y) y = 0, ++z;
            }
        }
        words[w] = (ulong2)(bits, 0);
        sum += (uint)popcount(bits);
    }
    chunk_sums[chunk] = sum;
}

// the ranks of a cell's two children in a row, first and past the last; ranks ascend along it
static inline uint2 fragment_children(
    __global const ulong2 *restrict words, const uint cell, const bool both, const uint capacity)
{
    const ulong2 word = words[cell / 64];
    const uint shift = cell % 64;
    const uint first = (uint)word.y + (uint)popcount(word.x & ((1ul << shift) - 1));
    uint count = (uint)(word.x >> shift & 1);
    if (both) count += (uint)(shift < 63 ? word.x >> (shift + 1) & 1 : words[cell / 64 + 1].x & 1);
    // the maps hold `capacity` cells
    return (uint2)(min(first, capacity), min(first + count, capacity));
}

// For each occupied cell, a `rank`, CLEAR is said, then ADD for each `child`, then STORE; the children's output vertices
// are told their new cell
#define DOWNSAMPLE(CLEAR, ADD, STORE)                                                                                  \
    uint rank = chunk_sum_before(chunk, chunk_sums);                                                                   \
    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);                                                     \
    for (uint w = rows.x; w < rows.y; ++w) {                                                                           \
        words[w].y = rank;                                                                                             \
        for (ulong bits = words[w].x; bits && rank < capacity; bits &= bits - 1, ++rank) {                             \
            const uint cell = 64 * w + (uint)popcount((bits & -bits) - 1);                                             \
            const uint x = 2 * (cell % cells.x), y = 2 * (cell / cells.x % cells.y), z = 2 * (cell / cells.x / cells.y); \
            CLEAR;                                                                                                     \
            for (uint dz = 0; dz < 2 && z + dz < fine_cells.z; ++dz)                                                   \
                for (uint dy = 0; dy < 2 && y + dy < fine_cells.y; ++dy) {                                             \
                    const uint2 children = fragment_children(fine_words,                                               \
                        ((z + dz) * fine_cells.y + y + dy) * fine_cells.x + x, x + 1 < fine_cells.x, fine_capacity);   \
                    for (uint child = children.x; child < children.y; ++child) {                                       \
                        const uint vertex = fine_ranks[child];                                                          \
                        if (vertex < fine_capacity) parents[vertex] = rank;                                            \
                        ADD;                                                                                           \
                    }                                                                                                  \
                }                                                                                                      \
            STORE;                                                                                                     \
        }                                                                                                              \
    }                                                                                                                  \
    if (chunk == chunk_count - 1) state[0] = rank;

__kernel void level_chain_fragment_downsample(
    __global const ulong2 *restrict fine_words,
    __global const float16 *restrict fine_maps,
    __global const uint *restrict fine_ranks,
    __global const uint *restrict chunk_sums,
    __global ulong2 *restrict words,
    __global float16 *restrict maps,
    __global uint *restrict parents,
    __global uint *restrict state,
    const uint4 fine_cells,
    const uint4 cells,
    const uint fine_map_count,
    const uint fine_capacity,
    const uint capacity,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    // from the units of the level before to those of this one, twice as long: areas, areas times lengths, lengths
    const float16 units = (float16)(0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.125f, 0.125f, 0.125f, 0.0f, 0.0f, 0.0f,
        0.5f, 0.5f, 0.5f, 1.0f);
    DOWNSAMPLE(float16 sum = 0.0f,
        for (uint m = 0; m < fine_map_count; ++m) sum += fine_maps[m * (size_t)fine_capacity + child],
        maps[rank] = sum * units)
}

__kernel void level_chain_fragment_downsample_fixed_point(
    __global const ulong2 *restrict fine_words,
    __global const long *restrict fine_sums,
    __global const uint *restrict fine_ranks,
    __global const uint *restrict chunk_sums,
    __global ulong2 *restrict words,
    __global long *restrict sums,
    __global uint *restrict parents,
    __global uint *restrict state,
    const uint4 fine_cells,
    const uint4 cells,
    const uint fine_capacity,
    const uint capacity,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    DOWNSAMPLE(__global long *own = sums + WORDS * (size_t)rank; for (uint i = 0; i < WORDS; ++i) own[i] = 0,
        for (uint i = 0; i < WORD_SURVIVING; ++i) own[i] += fine_sums[WORDS * (size_t)child + i], )
}
