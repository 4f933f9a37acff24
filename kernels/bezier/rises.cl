// How far vertices rise over the surface along its normals, so that triangles lie on both sides of it.
//
// Source    none in Concheiro 2013, whose vertices lie on it: a reconstruction
// Work      functions only. A half rises by what its triangles lie under the surface in the mean; a vertex by the mean of
//           the quarters of cells around it, in whole numbers: the same from every side
// Reads     wishes       uint [cell_count]      as bezier/grids.py has them
//           rises        int  [2 * cell_count]  of each half, in diagonals / 2^28
//           ring         uint [4 * cell_count]  of edges, as bezier/grid_pieces.cl has it
//           corner_ring  uint [4 * cell_count]  for each corner of each cell, 4 cell + corner, the next that is one with it
//           held         uint [cell_count]      bits of edges and, from the fourth on, of corners that stay on the surface
// Writes    nothing
// Needs     bezier/cell.cl
// Plain     bezier/rises.py
// Defines   NORMALS, STREAMING

#pragma OPENCL FP_CONTRACT OFF

#define RISE_UNITS 268435456.0f // of a diagonal
#define RISE_MOST 67108864.0f
#define RISE_PLACES 5 // along a side: its ends, its middle, and what is between them

static inline int bezier_rise(const float diagonals)
{
    const float units = diagonals * RISE_UNITS;
    return (int)(units > -RISE_MOST ? units < RISE_MOST ? units : RISE_MOST : -RISE_MOST);
}

// of a quarter of a cell: half i along u, j along v
static inline long bezier_quarter(
    __global const uint *restrict wishes, __global const int *restrict rises, const uint cell, const uint i, const uint j)
{
    return rises[2 * cell + ((wishes[cell] & 3) == 2 ? j : i)];
}

static inline uint bezier_rise_line(const uint k) { return (k > 0) + (k > CELL / 2 - 1) + (k > CELL / 2) + (k > CELL - 1); }

// where in the table a sample of a cell is
static inline uint bezier_rise_place(const uint sample)
{
    return RISE_PLACES * bezier_rise_line(sample / CELL_SIDE) + bezier_rise_line(sample % CELL_SIDE);
}

// along an edge of a cell: before its middle and after
static inline float2 bezier_edge_rise(__global const uint *restrict wishes, __global const int *restrict rises,
    __global const uint *restrict ring, const uint edge)
{
    long first = 0, second = 0;
    int count = 0;
    uint at = edge;
    do {
        const uint cell = at / 4, k = at & 3, next = ring[at], last = k & 1;
        const long a = k < 2 ? bezier_quarter(wishes, rises, cell, last, 0) : bezier_quarter(wishes, rises, cell, 0, last);
        const long b = k < 2 ? bezier_quarter(wishes, rises, cell, last, 1) : bezier_quarter(wishes, rises, cell, 1, last);
        first += next & 1 ? b : a, second += next & 1 ? a : b;
        ++count, at = next >> 1;
    } while (at != edge);
    const float2 both = (float2)((float)first, (float)second) / (RISE_UNITS * (float)count);
    return ring[edge] & 1 ? both.yx : both;
}

static inline float bezier_corner_rise(__global const uint *restrict wishes, __global const int *restrict rises,
    __global const uint *restrict corner_ring, const uint corner)
{
    long sum = 0;
    int count = 0;
    uint at = corner;
    do {
        sum += bezier_quarter(wishes, rises, at / 4, at >> 1 & 1, at & 1);
        ++count, at = corner_ring[at];
    } while (at != corner);
    return (float)sum / (RISE_UNITS * (float)count);
}

// of all places of a cell, times the diagonal
static inline void bezier_rises(float *table, __global const uint *restrict wishes, __global const int *restrict rises,
    __global const uint *restrict ring, __global const uint *restrict corner_ring, const uint held, const uint cell,
    const float diagonal)
{
    float quarter[4];
    for (uint k = 0; k < 4; ++k) quarter[k] = (float)bezier_quarter(wishes, rises, cell, k >> 1, k & 1) / RISE_UNITS;
    for (uint i = 1; i < 4; ++i)
        for (uint j = 1; j < 4; ++j) {
            const uint top = i / 3, bottom = (i + 1) / 3, left = j / 3, right = (j + 1) / 3;
            table[RISE_PLACES * i + j] = 0.25f * diagonal *
                (quarter[2 * top + left] + quarter[2 * top + right] + quarter[2 * bottom + left] + quarter[2 * bottom + right]);
        }
    for (uint k = 0; k < 4; ++k) {
        const float2 both = held >> k & 1 ? (float2)(0.0f) : diagonal * bezier_edge_rise(wishes, rises, ring, 4 * cell + k);
        const uint step = k < 2 ? 1 : RISE_PLACES, begin = (k & 1) * (k < 2 ? 4 * RISE_PLACES : 4);
        table[begin + step] = both.x, table[begin + 2 * step] = 0.5f * (both.x + both.y), table[begin + 3 * step] = both.y;
        table[4 * (RISE_PLACES * (k >> 1) + (k & 1))] =
            held >> (4 + k) & 1 ? 0.0f : diagonal * bezier_corner_rise(wishes, rises, corner_ring, 4 * cell + k);
    }
}
