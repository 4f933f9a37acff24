// Octree, fragment stage: a node's sums from its children's, its representative, and its error.
//
// Source    DeCoro & Tatarchuk 2007, slides 15 and 30 (sums of children); moving a quadric by t: b + A t, c + 2 b t + t A t;
//           the regularised cascade and the rules on the total error are reconstructions
// Work      1-D, one item per chunk of a level's nodes, eight at a time; levels from the finest to the root
// Reads     maps     float[16 * node_count * map_count]  finest cells: xx xy xz yy yz zz x y | z c 0 0, corner sum, corners
//           centres  float4[]                     x y z in units of the finest cell edge, the cell's edge
//           firsts   uint[]                       first child
// Writes    sums     float[16]                    of each node, about its centre, as in maps
//           solved   float4[]                     x y z in units of the finest cell edge, kind
//           errors   float[]                      units of the finest cell edge (total: and of that edge once more); with
//                                                 `whole` at least as large as every child's
// Needs     common/chunk.cl common/quadric.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

#define NODES 8
#define RULE_TOTAL 0
#define RULE_RMS 1

// sums of eight nodes, LANES floats each, to representatives and errors; `least`: what the errors are raised to
static inline void fragment_place(const float *sums, const float *least, __global const float4 *restrict centres,
    __global float4 *restrict solved, __global float *restrict errors, const uint first, const uint live, const uint rule)
{
#define COLUMN(lane)                                                                                                   \
    (float8)(sums[lane], sums[LANES + lane], sums[2 * LANES + lane], sums[3 * LANES + lane],                           \
        sums[4 * LANES + lane], sums[5 * LANES + lane], sums[6 * LANES + lane], sums[7 * LANES + lane])
    const float8 each = 1.0f / max(COLUMN(LANE_CORNERS), (float8)(1.0f));
    const float8 mx = COLUMN(LANE_CORNER_X) * each, my = COLUMN(LANE_CORNER_X + 1) * each;
    const float8 mz = COLUMN(LANE_CORNER_X + 2) * each, c = COLUMN(LANE_C);
    const quadric8 given = {COLUMN(LANE_XX), COLUMN(LANE_XX + 1), COLUMN(LANE_XX + 2), COLUMN(LANE_XX + 3),
        COLUMN(LANE_XX + 4), COLUMN(LANE_XX + 5), COLUMN(LANE_BX), COLUMN(LANE_BX + 1), COLUMN(LANE_BX + 2)};
#undef COLUMN
    quadric8 q = given;
    q.x += q.xx * mx + q.xy * my + q.xz * mz;
    q.y += q.xy * mx + q.yy * my + q.yz * mz;
    q.z += q.xz * mx + q.yz * my + q.zz * mz;
    const float8 trace = q.xx + q.yy + q.zz, scale = 1.0f / max(trace, (float8)(1e-30f));
    q.xx *= scale, q.xy *= scale, q.xz *= scale, q.yy *= scale, q.yz *= scale, q.zz *= scale;
    q.x *= scale, q.y *= scale, q.z *= scale;
    float8 dx = 0, dy = 0, dz = 0, kind = 1, determinant; // kind 1: the mean
    int8 open = trace > (float8)(1e-30f);
    float ridge = 1e-3f;
    const float edge = centres[first].w;
    for (int attempt = 0; attempt < 3 && !quadric_all8(~open); ++attempt) {
        const quadric_point8 s = quadric_step8(q, (float8)(ridge), &determinant);
        const int8 taken = open & quadric_short8(s, edge);
        dx = taken ? s.x : dx;
        dy = taken ? s.y : dy;
        dz = taken ? s.z : dz;
        kind = taken ? (float8)(2.0f + attempt) : kind;
        open &= ~taken;
        ridge *= 10.0f;
    }
    const float8 x = mx + dx, y = my + dy, z = mz + dz;
    const float8 energy = c + x * (given.xx * x + 2.0f * (given.xy * y + given.xz * z + given.x)) +
        y * (given.yy * y + 2.0f * (given.yz * z + given.y)) + z * (given.zz * z + 2.0f * given.z);
    const float8 error = sqrt(max(energy, (float8)(0.0f)) * (rule == RULE_TOTAL ? (float8)(1.0f) : scale));
    float rows[5][NODES];
    vstore8(x, 0, rows[0]);
    vstore8(y, 0, rows[1]);
    vstore8(z, 0, rows[2]);
    vstore8(kind, 0, rows[3]);
    vstore8(rule == RULE_TOTAL || rule == RULE_RMS ? error : (float8)(0.0f), 0, rows[4]);
    for (uint j = 0; j < live; ++j) {
        solved[first + j] = (float4)((float3)(rows[0][j], rows[1][j], rows[2][j]) + centres[first + j].xyz, rows[3][j]);
        errors[first + j] = max(rows[4][j], least[j]);
    }
}

__kernel void octree_fragment_leaves(
    __global const float16 *restrict maps,
    __global const float4 *restrict centres,
    __global float16 *restrict sums,
    __global float4 *restrict solved,
    __global float *restrict errors,
    const uint rule,
    const uint map_count,
    const uint node_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const float least[NODES] = {0};
    const uint2 rows = chunk_rows(chunk, chunk_count, node_count);
    for (uint s = rows.x; s < rows.y; s += NODES) {
        const uint live = min(rows.y - s, (uint)NODES);
        float found[NODES * LANES];
        for (uint j = 0; j < NODES; ++j) {
            const size_t node = s + min(j, live - 1);
            float16 sum = maps[node];
            for (uint map = 1; map < map_count; ++map) sum += maps[map * (size_t)node_count + node];
            vstore16(sum, j, found);
            if (j < live) sums[node] = sum;
        }
        fragment_place(found, least, centres, solved, errors, s, live, rule);
    }
}

// a child's sums about its parent's centre, `t` away from its own
static inline float16 fragment_moved(const float16 s, const float3 t)
{
    const float3 At = (float3)(s.s0 * t.x + s.s1 * t.y + s.s2 * t.z, s.s1 * t.x + s.s3 * t.y + s.s4 * t.z,
        s.s2 * t.x + s.s4 * t.y + s.s5 * t.z);
    const float3 b = s.s678;
    float16 moved = s;
    moved.s678 = b - At;
    moved.s9 = s.s9 - 2.0f * (b.x * t.x + b.y * t.y + b.z * t.z) + At.x * t.x + At.y * t.y + At.z * t.z;
    moved.scde = s.scde + s.sf * t;
    return moved;
}

// nodes first_node .. first_node + node_count - 1, whose children end before `child_end`
__kernel void octree_fragment_parents(
    __global const float4 *restrict centres,
    __global const uint *restrict firsts,
    __global float16 *sums,
    __global float4 *restrict solved,
    __global float *errors,
    const uint rule,
    const uint whole,
    const uint first_node,
    const uint child_end,
    const uint node_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, node_count);
    for (uint s = rows.x; s < rows.y; s += NODES) {
        const uint live = min(rows.y - s, (uint)NODES);
        float found[NODES * LANES], least[NODES];
        for (uint j = 0; j < NODES; ++j) {
            const uint row = s + min(j, live - 1), node = first_node + row;
            const uint end = row + 1 < node_count ? firsts[node + 1] : child_end;
            const float3 centre = centres[node].xyz;
            float16 sum = 0.0f;
            float worst = 0.0f;
            for (uint child = firsts[node]; child < end; ++child) {
                sum += fragment_moved(sums[child], centres[child].xyz - centre);
                worst = max(worst, errors[child]);
            }
            vstore16(sum, j, found);
            least[j] = whole ? worst : 0.0f;
            if (j < live) sums[node] = sum;
        }
        fragment_place(found, least, centres, solved, errors, first_node + s, live, rule);
    }
}
