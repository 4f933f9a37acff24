// Octree: where eight nodes' representatives lie, and how large the quadrics are there.
//
// Source    DeCoro & Tatarchuk 2007, slide 15; the regularised cascade is a reconstruction; moving a quadric by t: b + A t,
//           c + 2 b t + t A t
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     common/quadric.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

typedef struct {
    float8 x, y, z; // about the node's centre
    float8 kind;    // 1: the mean; 2, 3, 4: the minimum with a ridge of 2e-4, 2e-3, 2e-2
    float8 energy;  // the quadric there
    float8 area;    // its trace
} octree_placed8;

// columns: LANES of eight nodes' sums about their centres; no representative is farther than `edge` from the corners' mean
static inline void octree_place8(const float8 *columns, const float edge, octree_placed8 *placed)
{
    const float8 each = 1.0f / max(columns[LANE_CORNERS], (float8)(1.0f));
    const float8 mx = columns[LANE_CORNER_X] * each, my = columns[LANE_CORNER_X + 1] * each;
    const float8 mz = columns[LANE_CORNER_X + 2] * each;
    const quadric8 given = {columns[LANE_XX], columns[LANE_XX + 1], columns[LANE_XX + 2], columns[LANE_XX + 3],
        columns[LANE_XX + 4], columns[LANE_XX + 5], columns[LANE_BX], columns[LANE_BX + 1], columns[LANE_BX + 2]};
    quadric8 q = given;
    q.x += q.xx * mx + q.xy * my + q.xz * mz;
    q.y += q.xy * mx + q.yy * my + q.yz * mz;
    q.z += q.xz * mx + q.yz * my + q.zz * mz;
    const float8 trace = q.xx + q.yy + q.zz, scale = 1.0f / max(trace, (float8)(1e-30f));
    q.xx *= scale, q.xy *= scale, q.xz *= scale, q.yy *= scale, q.yz *= scale, q.zz *= scale;
    q.x *= scale, q.y *= scale, q.z *= scale;
    float8 dx = 0, dy = 0, dz = 0, kind = 1, determinant;
    int8 open = trace > (float8)(1e-30f);
    float ridge = 2e-4f; // sums about a cell's own centre leave float32 room for less than a grid's 1e-3
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
    const float8 energy = columns[LANE_C] + x * (given.xx * x + 2.0f * (given.xy * y + given.xz * z + given.x)) +
        y * (given.yy * y + 2.0f * (given.yz * z + given.y)) + z * (given.zz * z + 2.0f * given.z);
    placed->x = x, placed->y = y, placed->z = z, placed->kind = kind, placed->area = trace;
    placed->energy = max(energy, (float8)(0.0f));
}

// the error that a rule compares: of the quadric itself, or of its share of the area
static inline float8 octree_error8(const octree_placed8 *placed, const uint rule)
{
    if (rule == RULE_TOTAL) return sqrt(placed->energy);
    return rule == RULE_RMS ? sqrt(placed->energy / max(placed->area, (float8)(1e-30f))) : (float8)(0.0f);
}

// a child's sums about its parent's centre, `t` away from its own
static inline float16 octree_moved(const float16 s, const float3 t)
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
