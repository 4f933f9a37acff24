// Runs: neighbours in a row of pixels that see one triangle. What shading needs of it is gathered once for each run.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     common/shading.cl
// Defines   INSTANCED, SEVERAL, SMOOTH as in stages/fragment.cl

#define RUN_ROOM (TILE + 8) // runs are gathered and looked up by eight
#define LINE (2 * RUN_ROOM)

typedef struct {
    uint ids[TILE];       // the triangle of each pixel
    uint seen[TILE];      // likewise; where nothing was hit, the least of its eight is looked at and thrown away
    int places[TILE];     // the run of each pixel, counted from that of the first of its eight
    uint bases[GROUPS];   // and which one that is
    uint shown[RUN_ROOM]; // the triangle of each run
    int firsts[RUN_ROOM]; // and the first pixel
    uint count, hits;
} Row;

// from `ids` and `hits`, all the rest; a row ahead of its use, so that the triangles' lines come into the cache meanwhile
static inline void row_runs(Row *row, __global const uint *restrict triangles)
{
    uint count = 0;
    ulong starts = 0;
    uint8 before = ID_EMPTY;
    for (int group = 0; group < GROUPS; ++group) {
        uint8 id = vload8(group, row->ids);
        if (row->hits >> group & 1) {
            if (lane_signs(id == ID_EMPTY)) id = id == ID_EMPTY ? (uint8)smallest_lane(id) : id;
            const uint bits = lane_signs(id != (uint8)(before.s7, id.s0123, id.s45, id.s6));
            row->bases[group] = count + (bits & 1) - 1;
            // bits of lanes 1 to 7, each in a byte of its own, summed from the first byte on
            const ulong bytes = (bits & 254) * 0x0002040810204081UL & 0x0101010101010101UL;
            vstore8(convert_int8(as_uchar8(bytes * 0x0101010101010101UL)), group, row->places);
            vstore8(id, group, row->seen);
            starts |= (ulong)bits << (8 * group);
            count += popcount(bits);
        }
        before = id;
    }
    row->count = count;
    for (uint run = 0; run < count; ++run) {
        const uint first = 63 - (uint)clz(starts & -starts), id = row->seen[first];
        starts &= starts - 1;
        row->shown[run] = id, row->firsts[run] = (int)first;
        if (!INSTANCED) prefetch(triangles + 3 * (size_t)id, 1);
    }
    if (count) vstore8((int8)(row->firsts[count - 1]), 0, row->firsts + count); // fills the last eight
}

// of eight pixels, the value of the run that each belongs to: `values` are those from the first one's on
static inline float8 runs_at(const float *values, const int8 place)
{
#ifdef __AVX2__
    return __builtin_ia32_permvarsf256(vload8(0, values), place);
#else
    int k[8];
    vstore8(place, 0, k);
    return (float8)(values[k[0]], values[k[1]], values[k[2]], values[k[3]],
                    values[k[4]], values[k[5]], values[k[6]], values[k[7]]);
#endif
}

// what changes evenly along the row: its value at eight runs' first pixels, and its steps from pixel to pixel, as two
// planes of numbers that runs_along looks up: that at the row's first pixel, and the step
static inline void runs_line(const float8 value, const float8 step, const float8 first, float *line)
{
    vstore8(fma(-step, first, value), 0, line);
    vstore8(step, 0, line + RUN_ROOM);
}

static inline void runs_lines(const planes8 value, const planes8 step, const float8 first, float *lines)
{
    runs_line(value.x, step.x, first, lines);
    runs_line(value.y, step.y, first, lines + LINE);
    runs_line(value.z, step.z, first, lines + 2 * LINE);
}

static inline float8 runs_along(const float *line, const int8 place, const float8 pixel)
{
    return fma(runs_at(line + RUN_ROOM, place), pixel, runs_at(line, place));
}

static inline planes8 runs_along3(const float *lines, const int8 place, const float8 pixel)
{
    const planes8 e = {runs_along(lines, place, pixel), runs_along(lines + LINE, place, pixel),
                       runs_along(lines + 2 * LINE, place, pixel)};
    return e;
}
