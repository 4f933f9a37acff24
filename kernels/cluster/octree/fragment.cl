// Octree, fragment stage: a node's sums from its children's, its representative, and its error.
//
// Source    DeCoro & Tatarchuk 2007, slides 15 and 30 (sums of children); moving a quadric by t: b + A t, c + 2 b t + t A t;
//           the rule on the total error is a reconstruction
// Work      1-D, one item per chunk of a level's nodes, eight at a time; levels from the finest to the root, one
//           launch each, or one item for several
// Reads     maps     float[16 * node_count * map_count]  finest cells: xx xy xz yy yz zz x y | z c 0 0, corner sum, corners
//           centres  float4[]                     x y z in units of the finest cell edge, the cell's edge
//           firsts   uint[]                       first child
//           starts   uint[]                       first node of each level, the root's level first
// Writes    sums     float[16]                    of each node, about its centre, as in maps
//           solved   float4[]                     x y z in units of the finest cell edge, kind
//           errors   float[]                      units of the finest cell edge (total: and of that edge once more)
// Needs     common/chunk.cl cluster/octree/place.cl
// Plain     cluster/octree/reference.py

#define NODES 8

// sums of eight nodes, LANES floats each, to representatives and errors
static inline void fragment_place(const float *sums, __global const float4 *restrict centres, __global float4 *restrict solved,
    __global float *restrict errors, const uint first, const uint live, const uint rule)
{
    float8 columns[LANES];
    for (uint lane = 0; lane < LANES; ++lane)
        columns[lane] = (float8)(sums[lane], sums[LANES + lane], sums[2 * LANES + lane], sums[3 * LANES + lane],
            sums[4 * LANES + lane], sums[5 * LANES + lane], sums[6 * LANES + lane], sums[7 * LANES + lane]);
    octree_placed8 placed;
    octree_place8(columns, centres[first].w, &placed);
    float rows[5][NODES];
    vstore8(placed.x, 0, rows[0]);
    vstore8(placed.y, 0, rows[1]);
    vstore8(placed.z, 0, rows[2]);
    vstore8(placed.kind, 0, rows[3]);
    vstore8(octree_error8(&placed, rule), 0, rows[4]);
    for (uint j = 0; j < live; ++j) {
        solved[first + j] = (float4)((float3)(rows[0][j], rows[1][j], rows[2][j]) + centres[first + j].xyz, rows[3][j]);
        errors[first + j] = rows[4][j];
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
        fragment_place(found, centres, solved, errors, s, live, rule);
    }
}

// `level` to `last`, which is coarser, with chunk_count 1 where they are several
__kernel void octree_fragment_parents(
    __global const float4 *restrict centres,
    __global const uint *restrict firsts,
    __global const uint *restrict starts,
    __global float16 *sums,
    __global float4 *restrict solved,
    __global float *restrict errors,
    const uint rule,
    const uint level,
    const uint last,
    const uint node_count, // of all levels
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    for (uint above = level + 1; above-- > last;) {
        const uint first_node = starts[above], end_node = above ? starts[above - 1] : node_count;
        const uint2 rows = chunk_rows(chunk, chunk_count, end_node - first_node);
        for (uint s = rows.x; s < rows.y; s += NODES) {
            const uint live = min(rows.y - s, (uint)NODES);
            float found[NODES * LANES];
            for (uint j = 0; j < NODES; ++j) {
                const uint row = s + min(j, live - 1), node = first_node + row;
                const uint end = node + 1 < end_node ? firsts[node + 1] : first_node;
                const float3 centre = centres[node].xyz;
                float16 sum = 0.0f;
                for (uint child = firsts[node]; child < end; ++child)
                    sum += octree_moved(sums[child], centres[child].xyz - centre);
                vstore16(sum, j, found);
                if (j < live) sums[node] = sum;
            }
            fragment_place(found, centres, solved, errors, first_node + s, live, rule);
        }
    }
}
