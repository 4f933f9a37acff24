// Probabilistic octree, fragment stage: representative and error of each slot that one node has to itself.
//
// Source    DeCoro & Tatarchuk 2007, slides 15 and 31-32 (a collision shows where the least key is not the largest); the
//           regularised cascade is a reconstruction
// Work      1-D, one item per chunk of slots, eight at a time
// Reads     sums    long[14 * slot_count]          quadric, corner sum, corners, each in units of the node's own edge
//           keys    int[2 * slot_count]            largest key, largest negative key
// Writes    solved  float4[slot_count]             x y z in units of the finest cell edge, kind; kind 0: no node's own slot
//           errors  float[slot_count]              units of the finest cell edge (total: and of that edge once more)
// Needs     common/chunk.cl common/quadric.cl cluster/octree/cell.cl cluster/probabilistic_octree/key.cl
// Plain     cluster/probabilistic_octree/reference.py

#define SLOTS 8
#define RULE_TOTAL 0

__kernel void probabilistic_octree_fragment_solve(
    __global const long *restrict sums,
    __global const int2 *restrict keys,
    __global float4 *restrict solved,
    __global float *restrict errors,
    const float2 inverse_scale, // of the quadrics, of the corners
    const uint finest,
    const uint rule,
    const uint slot_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, slot_count);
    for (uint s = rows.x; s < rows.y;) {
        // the next eight slots that hold one node each; the root's counts though nothing was written to it
        uint slots[SLOTS], live = 0;
        for (; s < rows.y && live < SLOTS; ++s) {
            const int2 key = keys[s];
            if (s == 0 || (key.x != NO_KEY && key.x == -key.y)) {
                slots[live++] = s;
            } else {
                solved[s] = 0.0f;
                errors[s] = INFINITY;
            }
        }
        if (!live) continue;
        float lanes[WORDS][SLOTS];
        for (uint j = 0; j < SLOTS; ++j) {
            __global const long *sum = sums + WORDS * (size_t)slots[min(j, live - 1)];
            for (uint i = 0; i < 10; ++i) lanes[i][j] = (float)sum[i] * inverse_scale.x;
            for (uint i = 10; i < 13; ++i) lanes[i][j] = (float)sum[i] * inverse_scale.y;
            lanes[13][j] = (float)sum[13];
        }
        const float8 corners = vload8(0, lanes[13]), each = 1.0f / max(corners, (float8)(1.0f));
        const float8 mx = vload8(0, lanes[10]) * each, my = vload8(0, lanes[11]) * each, mz = vload8(0, lanes[12]) * each;
        const quadric8 given = {vload8(0, lanes[0]), vload8(0, lanes[1]), vload8(0, lanes[2]), vload8(0, lanes[3]),
            vload8(0, lanes[4]), vload8(0, lanes[5]), vload8(0, lanes[6]), vload8(0, lanes[7]), vload8(0, lanes[8])};
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
        for (int attempt = 0; attempt < 3 && !quadric_all8(~open); ++attempt) {
            const quadric_point8 step = quadric_step8(q, (float8)(ridge), &determinant);
            const int8 taken = open & quadric_short8(step, 1.0f);
            dx = taken ? step.x : dx;
            dy = taken ? step.y : dy;
            dz = taken ? step.z : dz;
            kind = taken ? (float8)(2.0f + attempt) : kind;
            open &= ~taken;
            ridge *= 10.0f;
        }
        const float8 x = mx + dx, y = my + dy, z = mz + dz;
        const float8 energy = vload8(0, lanes[9]) + x * (given.xx * x + 2.0f * (given.xy * y + given.xz * z + given.x)) +
            y * (given.yy * y + 2.0f * (given.yz * z + given.y)) + z * (given.zz * z + 2.0f * given.z);
        vstore8(x, 0, lanes[0]);
        vstore8(y, 0, lanes[1]);
        vstore8(z, 0, lanes[2]);
        vstore8(kind, 0, lanes[3]);
        vstore8(sqrt(max(energy, (float8)(0.0f)) * (rule == RULE_TOTAL ? (float8)(1.0f) : scale)), 0, lanes[4]);
        for (uint j = 0; j < live; ++j) {
            const uint slot = slots[j], key = slot ? (uint)keys[slot].x - 1 : 0, level = key >> 27;
            const uint own = key & 0x7FFFFFFu;
            const float edge = (float)(1u << (finest - level));
            solved[slot] = (float4)(((float)octree_gather(own) + 0.5f + lanes[0][j]) * edge,
                ((float)octree_gather(own >> 1) + 0.5f + lanes[1][j]) * edge,
                ((float)octree_gather(own >> 2) + 0.5f + lanes[2][j]) * edge, lanes[3][j]);
            errors[slot] = lanes[13][j] > 0.0f ? lanes[4][j] * edge : INFINITY;
        }
    }
}
