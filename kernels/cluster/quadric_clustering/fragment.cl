// Quadric vertex clustering, fragment stage: where does each cell's representative go?
//
// Source    DeCoro & Tatarchuk 2007, slides 14-15 (optimal positions); the regularised cascade is a reconstruction
// Work      1-D, one item per chunk of occupied cells, eight cells at a time
// Reads     maps        float[16 * capacity * map_count]  per cell: xx xy xz yy yz zz x y | z, surviving corners, 0 0, corner sum x y z, corners
//           sums        long[14 * capacity]               the same, xx .. z, corner sum, corners, surviving corners, in fixed point
//           state       uint[4]                           [0]: occupied cells
//           limits      float[3 * capacity]               where WARPED: a cell's longest steps along x, y, z, same units as solved
// Writes    solved      float4[capacity]                  x y z in units of the largest cell edge, kind; kind 0: not used by any triangle
//           chunk_sums  uint[chunk_count]                 used cells
// Needs     common/chunk.cl common/quadric.cl cluster/quadric_clustering/share.cl
// Plain     cluster/quadric_clustering/reference.py
// Defines   WARPED where cells are not alike: their limits differ

#define PLACE_ROBUST 0
#define PLACE_PAPER 1
#define CELLS 8

// a step over the longest that its cell lets it be along each axis; lengths are in units of the cell's edge where all are alike
static inline quadric_point8 fragment_share8(const quadric_point8 s, __global const float *restrict limits, const uint first, const uint live)
{
#ifdef WARPED
    float each[3][CELLS];
    for (uint j = 0; j < CELLS; ++j) {
        const float3 limit = vload3(first + min(j, live - 1), limits);
        each[0][j] = limit.x;
        each[1][j] = limit.y;
        each[2][j] = limit.z;
    }
    const quadric_point8 share = {s.x / max(vload8(0, each[0]), (float8)(1e-30f)),
        s.y / max(vload8(0, each[1]), (float8)(1e-30f)), s.z / max(vload8(0, each[2]), (float8)(1e-30f))};
    return share;
#else
    return s;
#endif
}

// the sums of eight cells, LANES floats each, to eight representatives
static inline uint fragment_place(const float *sums, __global const float *restrict limits, __global float4 *restrict solved,
    const uint first, const uint live, const uint placement, const float per_box)
{
#define COLUMN(lane)                                                                                                   \
    (float8)(sums[lane], sums[LANES + lane], sums[2 * LANES + lane], sums[3 * LANES + lane],                           \
        sums[4 * LANES + lane], sums[5 * LANES + lane], sums[6 * LANES + lane], sums[7 * LANES + lane])
    const float8 used = COLUMN(LANE_SURVIVING), corners = COLUMN(LANE_CORNERS), each = 1.0f / max(corners, (float8)(1.0f));
    const float8 mx = COLUMN(LANE_CORNER_X) * each, my = COLUMN(LANE_CORNER_X + 1) * each;
    const float8 mz = COLUMN(LANE_CORNER_X + 2) * each;
    quadric8 q = {COLUMN(LANE_XX), COLUMN(LANE_XX + 1), COLUMN(LANE_XX + 2), COLUMN(LANE_XX + 3), COLUMN(LANE_XX + 4),
        COLUMN(LANE_XX + 5), COLUMN(LANE_BX), COLUMN(LANE_BX + 1), COLUMN(LANE_BX + 2)};
#undef COLUMN
    q.x += q.xx * mx + q.xy * my + q.xz * mz;
    q.y += q.xy * mx + q.yy * my + q.yz * mz;
    q.z += q.xz * mx + q.yz * my + q.zz * mz;

    float8 dx = 0, dy = 0, dz = 0, kind = 1; // kind 1: the mean
    float8 determinant;
    const float8 trace = q.xx + q.yy + q.zz;
    if (placement == PLACE_ROBUST) {
        const float8 scale = 1.0f / max(trace, (float8)(1e-30f));
        q.xx *= scale, q.xy *= scale, q.xz *= scale, q.yy *= scale, q.yz *= scale, q.zz *= scale;
        q.x *= scale, q.y *= scale, q.z *= scale;
        int8 open = trace > (float8)(1e-30f);
        float ridge = 1e-3f;
        for (int attempt = 0; attempt < 3 && !quadric_all8(~open); ++attempt) {
            const quadric_point8 s = quadric_step8(q, (float8)(ridge), &determinant);
            const int8 taken = open & quadric_short8(fragment_share8(s, limits, first, live), 1.0f);
            dx = taken ? s.x : dx;
            dy = taken ? s.y : dy;
            dz = taken ? s.z : dz;
            kind = taken ? (float8)(2.0f + attempt) : kind;
            open &= ~taken;
            ridge *= 10.0f;
        }
    } else if (placement == PLACE_PAPER) {
        // the slides' threshold belongs to a mesh whose longest box edge is 1: areas in those units
        const float8 scale = (float8)(per_box * per_box);
        q.xx *= scale, q.xy *= scale, q.xz *= scale, q.yy *= scale, q.yz *= scale, q.zz *= scale;
        q.x *= scale, q.y *= scale, q.z *= scale;
        const quadric_point8 s = quadric_step8(q, (float8)(0.0f), &determinant);
        const int8 taken = (determinant > 1e-11f) & (fabs(s.x) + fabs(s.y) + fabs(s.z) < (float8)(1e30f));
        dx = taken ? s.x : dx;
        dy = taken ? s.y : dy;
        dz = taken ? s.z : dz;
        kind = taken ? (float8)(2.0f) : kind;
    }
    kind = used > (float8)(0.0f) ? kind : (float8)(0.0f);
    float rows[4][CELLS];
    vstore8(mx + dx, 0, rows[0]);
    vstore8(my + dy, 0, rows[1]);
    vstore8(mz + dz, 0, rows[2]);
    vstore8(kind, 0, rows[3]);
    uint count = 0;
    for (uint j = 0; j < live; ++j) {
        solved[first + j] = (float4)(rows[0][j], rows[1][j], rows[2][j], rows[3][j]);
        count += rows[3][j] > 0.0f;
    }
    return count;
}

__kernel void quadric_clustering_fragment_solve(
    __global const float16 *restrict maps,
    __global const uint *restrict state,
    __global const float *restrict limits,
    __global float4 *restrict solved,
    __global uint *restrict chunk_sums,
    const float per_box,
    const uint placement,
    const uint map_count,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(state[0], capacity));
    uint count = 0;
    for (uint s = rows.x; s < rows.y; s += CELLS) {
        float sums[CELLS * LANES];
        for (uint j = 0; j < CELLS; ++j) {
            const size_t cell = min(s + j, rows.y - 1);
            float16 sum = maps[cell];
            for (uint map = 1; map < map_count; ++map) sum += maps[map * (size_t)capacity + cell];
            vstore16(sum, j, sums);
        }
        count += fragment_place(sums, limits, solved, s, min(rows.y - s, (uint)CELLS), placement, per_box);
    }
    chunk_sums[chunk] = count;
}

__kernel void quadric_clustering_fragment_solve_fixed_point(
    __global const long *restrict sums,
    __global const uint *restrict state,
    __global const float *restrict limits,
    __global float4 *restrict solved,
    __global uint *restrict chunk_sums,
    const float4 inverse_scale, // of A, of b, of positions
    const float per_box,
    const uint placement,
    const uint capacity,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, min(state[0], capacity));
    uint count = 0;
    for (uint s = rows.x; s < rows.y; s += CELLS) {
        float floats[CELLS * LANES];
        for (uint j = 0; j < CELLS; ++j) {
            __global const long *sum = sums + WORDS * (size_t)min(s + j, rows.y - 1);
            float *lane = floats + LANES * j;
            for (uint i = 0; i < 6; ++i) lane[LANE_XX + i] = (float)sum[WORD_XX + i] * inverse_scale.x;
            for (uint i = 0; i < 3; ++i) lane[LANE_BX + i] = (float)sum[WORD_BX + i] * inverse_scale.y;
            for (uint i = 0; i < 3; ++i) lane[LANE_CORNER_X + i] = (float)sum[WORD_CORNER_X + i] * inverse_scale.z;
            lane[LANE_CORNERS] = (float)sum[WORD_CORNERS];
            lane[LANE_SURVIVING] = (float)sum[WORD_SURVIVING];
        }
        count += fragment_place(floats, limits, solved, s, min(rows.y - s, (uint)CELLS), placement, per_box);
    }
    chunk_sums[chunk] = count;
}
