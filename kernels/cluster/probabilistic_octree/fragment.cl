// Probabilistic octree, fragment stage: representative and error of each slot that one node has to itself.
//
// Source    DeCoro & Tatarchuk 2007, slides 15 and 31-32 (a collision shows where the least key is not the largest)
// Work      1-D, one item per chunk of slots, eight at a time
// Reads     sums    long[14 * slot_count]          quadric, corner sum, corners, each in units of the node's own edge
//           keys    int[2 * slot_count]            largest key, largest negative key
// Writes    solved  float4[slot_count]             x y z in units of the finest cell edge, kind; kind 0: no node's own slot
//           errors  float[slot_count]              units of the finest cell edge (total: and of that edge once more)
// Needs     common/chunk.cl cluster/octree/place.cl cluster/probabilistic_octree/key.cl
// Plain     cluster/probabilistic_octree/reference.py

#define SLOTS 8

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
        float lanes[LANES][SLOTS] = {{0}};
        for (uint j = 0; j < SLOTS; ++j) {
            __global const long *sum = sums + WORDS * (size_t)slots[min(j, live - 1)];
            for (uint i = 0; i < 10; ++i) lanes[LANE_XX + i][j] = (float)sum[i] * inverse_scale.x;
            for (uint i = 0; i < 3; ++i) lanes[LANE_CORNER_X + i][j] = (float)sum[10 + i] * inverse_scale.y;
            lanes[LANE_CORNERS][j] = (float)sum[13];
        }
        float8 columns[LANES];
        for (uint lane = 0; lane < LANES; ++lane) columns[lane] = vload8(0, lanes[lane]);
        octree_placed8 placed;
        octree_place8(columns, 1.0f, &placed);
        vstore8(placed.x, 0, lanes[0]);
        vstore8(placed.y, 0, lanes[1]);
        vstore8(placed.z, 0, lanes[2]);
        vstore8(placed.kind, 0, lanes[3]);
        vstore8(octree_error8(&placed, rule), 0, lanes[4]);
        for (uint j = 0; j < live; ++j) {
            const uint slot = slots[j], key = slot ? (uint)keys[slot].x - 1 : 0, level = key >> 27;
            const uint own = key & 0x7FFFFFFu;
            const float edge = (float)(1u << (finest - level));
            solved[slot] = (float4)(((float)octree_gather(own) + 0.5f + lanes[0][j]) * edge,
                ((float)octree_gather(own >> 1) + 0.5f + lanes[1][j]) * edge,
                ((float)octree_gather(own >> 2) + 0.5f + lanes[2][j]) * edge, lanes[3][j]);
            errors[slot] = lanes[LANE_CORNERS][j] > 0.0f ? lanes[4][j] * edge : INFINITY;
        }
    }
}
