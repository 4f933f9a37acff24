// Octree, boxes: each cube's vertices for the least error, be it one, one for each of a few boxes, or its children's own.
//
// Source    Breiman et al. 1984, chapter 3 (pruning a tree at a price for each leaf), for the cubes of DeCoro & Tatarchuk
//           2007, slides 29-33; that a cube's children are joined to boxes is a reconstruction
// Work      1-D, one item per chunk of a level's nodes, eight cubes at a time; levels from the second finest to the root,
//           one launch each, or one item for several
// Reads     centres  float4[]       x y z in units of the finest cell edge, the cell's edge
//           firsts   uint[]         first child
//           sums     float[16]      of each node, as in fragment.cl
//           errors   float[]        of each node
//           starts   uint[]         first node of each level, the root's level first
// Writes    solved   float4[]       a box's representative in place of its first child's, with 4 added to the kind
//           costs    float[]        of each parent: what its vertices cost at the least
//           joins    uint[]         the node that a node's vertices go to: the parent, a box's first child; 0xFFFFFFFF: its
//                                   own, or those of its children
// Needs     common/chunk.cl cluster/octree/room.cl
// Plain     cluster/octree/reference_boxes.py

// what a vertex adds beyond its price; a leaf's keeps to any limit
static inline float boxes_own(__global const float *restrict errors, const uint node, const uint leaf_count, const float limit,
    const uint rule)
{
    return node < leaf_count && rule != RULE_TOTAL ? 0.0f : room_energy(errors[node], limit, rule);
}

// `level` to `last`, which is coarser, with chunk_count 1 where they are several; nodes below `leaf_count` are leaves
__kernel void octree_boxes_choose(
    __global const float4 *restrict centres,
    __global const uint *restrict firsts,
    __global const float16 *restrict sums,
    __global const float *restrict errors,
    __global const uint *restrict starts,
    __global float4 *restrict solved,
    __global float *costs,
    __global uint *restrict joins,
    const float limit, // of an error; below 0 nothing is joined
    const uint rule,
    const uint boxed, // else cubes alone
    const uint leaf_count,
    const uint level,
    const uint last,
    const uint node_count, // of all levels
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const float price = rule == RULE_TOTAL ? limit * limit : 1.0f;
    boxes_room room;
    for (uint above = level + 1; above-- > last;) {
        const uint first_node = starts[above], end_node = above ? starts[above - 1] : node_count;
        const uint2 rows = chunk_rows(chunk, chunk_count, end_node - first_node);
        for (uint row = rows.x; row < rows.y;) {
            room_clear(&room);
            uint queue[CUBES], live = 0;
            for (; row < rows.y && live < CUBES; ++row) {
                const uint node = first_node + row, begin = firsts[node];
                const uint end = node + 1 < end_node ? firsts[node + 1] : first_node;
                const float whole = boxes_own(errors, node, leaf_count, limit, rule) + price;
                float apart = 0.0f, most = -INFINITY, second = -INFINITY; // saved where children are joined, at most
                for (uint child = begin; child < end; ++child) {
                    const float own = boxes_own(errors, child, leaf_count, limit, rule);
                    const float cost = child < leaf_count ? own + price : costs[child];
                    apart += cost;
                    second = max(second, min(most, cost - SURE * own));
                    most = max(most, cost - SURE * own);
                }
                if (boxed && limit >= 0.0f && whole > 2.0f * price && most + second > price) {
                    // neither all of it for sure, nor none of it
                    for (uint child = begin; child < end; ++child) {
                        const float own = boxes_own(errors, child, leaf_count, limit, rule);
                        const float cost = child < leaf_count ? own + price : costs[child];
                        room_add(&room, live, child, centres[child].xyz - centres[node].xyz, sums[child], own, cost);
                    }
                    queue[live++] = node;
                    continue;
                }
                const bool one = limit >= 0.0f && whole <= apart;
                costs[node] = one ? whole : apart;
                for (uint child = begin; child < end; ++child) joins[child] = one ? node : NO_NODE;
            }
            if (!live) continue;
            const float edge = centres[queue[0]].w;
            for (uint i = 0; i < JOINED; ++i) room_choose(&room, room_order[i], edge, price, limit, rule);
            for (uint j = 0; j < live; ++j) {
                const uint node = queue[j];
                const float whole = boxes_own(errors, node, leaf_count, limit, rule) + price;
                const float apart = ((const float *)&room.costs[WHOLE])[j];
                costs[node] = min(whole, apart);
                room_join(&room, j, whole <= apart ? node : NO_NODE, centres[node].xyz, solved, joins);
            }
        }
    }
}
