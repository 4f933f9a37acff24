// Octree, boxes: each cube's vertices for the least error, be it one, one for each of a few boxes, or its children's own.
//
// Source    Breiman et al. 1984, chapter 3 (pruning a tree at a price for each leaf), for the cubes of DeCoro & Tatarchuk
//           2007, slides 29-33; that a cube's children are joined to boxes is a reconstruction
// Work      1-D, one item per chunk of a level's nodes, eight cubes at a time; levels from the second finest to the root
// Reads     centres  float4[]       x y z in units of the finest cell edge, the cell's edge
//           firsts   uint[]         first child
//           sums     float[16]      of each node, as in fragment.cl
//           errors   float[]        of each node
// Writes    solved   float4[]       a box's representative in place of its first child's, with 4 added to the kind
//           costs    float[]        of each parent: what its vertices cost at the least
//           joins    uint[]         the node that a node's vertices go to: the parent, a box's first child; 0xFFFFFFFF: its
//                                   own, or those of its children
// Needs     common/chunk.cl cluster/octree/place.cl
// Plain     cluster/octree/reference_boxes.py

#define CUBES 8
#define BOXES 27 // along each axis 0 the lower half, 1 the upper, 2 both; x + 3 y + 9 z
#define WHOLE 26
#define JOINED 19 // boxes of several children
#define NO_NODE 0xFFFFFFFFu
#define OF_A_BOX 4.0f

// halves before what is made of them
__constant uchar boxes_order[JOINED] = {2, 5, 6, 7, 11, 14, 15, 16, 18, 19, 21, 22, 8, 17, 20, 23, 24, 25, 26};
// children in each box, bits by x + 2 y + 4 z
__constant uchar boxes_children[BOXES] = {1, 2, 3, 4, 8, 12, 5, 10, 15, 16, 32, 48, 64, 128, 192, 80, 160, 240, 17, 34, 51, 68, 136, 204, 85, 170, 255};
// and the box of each child
__constant uchar boxes_single[8] = {0, 1, 3, 4, 9, 10, 12, 13};
__constant uchar boxes_stride[3] = {1, 3, 9};

typedef struct {
    float8 sums[BOXES][LANES]; // about the cubes' centres
    float8 energies[BOXES], costs[BOXES], counts[BOXES];
    float8 points[BOXES][4];
    int8 choices[BOXES];       // halve along this axis, or -1: one vertex
    uint children[CUBES][8];   // by x + 2 y + 4 z
    uint occupied[CUBES];      // which of them are there
} boxes_room;

static inline bool boxes_any8(const int8 mask) { return !quadric_all8(~mask); }

// what a vertex adds beyond its price, when its node has this error
static inline float boxes_energy(const float error, const float limit, const uint rule)
{
    return rule == RULE_TOTAL ? error * error : error <= limit ? 0.0f : INFINITY;
}

static inline void boxes_add_child(boxes_room *room, const uint j, const uint child, const float3 t, const float16 sum,
    const float energy, const float cost)
{
    const uint slot = (t.x > 0.0f) + 2 * (t.y > 0.0f) + 4 * (t.z > 0.0f), box = boxes_single[slot];
    float values[LANES];
    vstore16(octree_moved(sum, t), 0, values);
    for (uint lane = 0; lane < LANES; ++lane) ((float *)&room->sums[box][lane])[j] = values[lane];
    ((float *)&room->energies[box])[j] = energy;
    ((float *)&room->costs[box])[j] = cost;
    ((float *)&room->counts[box])[j] = 1.0f;
    room->children[j][slot] = child;
    room->occupied[j] |= 1u << slot;
}

// the cheapest way to halve a box of the eight cubes, and one vertex for all of it where that is cheaper
static inline void boxes_choose(boxes_room *room, const uint box, const float edge, const float price, const float limit,
    const uint rule, const float8 all)
{
    float8 best = INFINITY, least = 0.0f, count = 0.0f;
    int8 choice = 0, wanted = -1;
    uint low = 0, high = 0;
    for (uint axis = 0; axis < 3; ++axis) {
        const uint stride = boxes_stride[axis];
        if (box / stride % 3 != 2) continue;
        low = box - 2 * stride, high = box - stride;
        const float8 cost = room->costs[low] + room->costs[high], energy = room->energies[low] + room->energies[high];
        const int8 cheaper = cost < best;
        best = cheaper ? cost : best;
        choice = cheaper ? (int8)(int)axis : choice;
        // a sum's minimum is no less than the minima's sum; an empty half leaves nothing to join
        least = max(least, energy);
        wanted &= (room->counts[low] > 0.0f) & (room->counts[high] > 0.0f) & (energy + price < cost);
        count = room->counts[low] + room->counts[high];
    }
    if (box != WHOLE) {
        float8 *columns = room->sums[box];
        for (uint lane = 0; lane < LANES; ++lane) columns[lane] = room->sums[low][lane] + room->sums[high][lane];
        wanted &= count < all; // all children together are the cube
        if (boxes_any8(wanted)) {
            octree_placed8 placed;
            octree_place8(columns, edge, &placed);
            room->points[box][0] = placed.x;
            room->points[box][1] = placed.y;
            room->points[box][2] = placed.z;
            room->points[box][3] = placed.kind + OF_A_BOX;
            const float8 error = octree_error8(&placed, rule);
            const float8 energy = rule == RULE_TOTAL ? placed.energy : error <= limit ? (float8)(0.0f) : (float8)(INFINITY);
            least = wanted ? energy : least;
            const int8 taken = wanted & (energy + price < best);
            best = taken ? energy + price : best;
            choice = taken ? (int8)(-1) : choice;
        }
    }
    room->energies[box] = least;
    room->costs[box] = best;
    room->counts[box] = count;
    room->choices[box] = choice;
}

// children of cube j to the vertices that were chosen
static inline void boxes_join(const boxes_room *room, const uint j, const float3 centre, __global float4 *solved,
    __global uint *joins)
{
    uint waiting[8], depth = 1;
    waiting[0] = WHOLE;
    while (depth) {
        const uint box = waiting[--depth];
        uint inside = boxes_children[box] & room->occupied[j];
        if (!inside) continue;
        const uint first = room->children[j][popcount((inside & (~inside + 1)) - 1)];
        if (!(inside & (inside - 1))) { // a child by itself
            joins[first] = NO_NODE;
            continue;
        }
        const int choice = ((const int *)&room->choices[box])[j];
        if (choice >= 0) {
            const uint stride = boxes_stride[choice];
            waiting[depth++] = box - 2 * stride;
            waiting[depth++] = box - stride;
            continue;
        }
        const float8 *point = room->points[box];
        solved[first] = (float4)(((const float *)point)[j] + centre.x, ((const float *)(point + 1))[j] + centre.y,
            ((const float *)(point + 2))[j] + centre.z, ((const float *)(point + 3))[j]);
        for (; inside; inside &= inside - 1) joins[room->children[j][popcount((inside & (~inside + 1)) - 1)]] = first;
    }
}

// nodes first_node .. first_node + node_count - 1, whose children end before `child_end` and are leaves below `leaf_count`
__kernel void octree_boxes_choose(
    __global const float4 *restrict centres,
    __global const uint *restrict firsts,
    __global const float16 *restrict sums,
    __global const float *restrict errors,
    __global float4 *restrict solved,
    __global float *costs,
    __global uint *restrict joins,
    const float limit, // of an error; below 0 nothing is joined
    const uint rule,
    const uint boxed, // else cubes alone
    const uint leaf_count,
    const uint first_node,
    const uint child_end,
    const uint node_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const float price = rule == RULE_TOTAL ? limit * limit : 1.0f;
    const uint2 rows = chunk_rows(chunk, chunk_count, node_count);
    boxes_room room;
    for (uint row = rows.x; row < rows.y;) {
        uint queue[CUBES], live = 0;
        for (; row < rows.y && live < CUBES; ++row) {
            const uint node = first_node + row, end = row + 1 < node_count ? firsts[node + 1] : child_end;
            const float energy = boxes_energy(errors[node], limit, rule);
            float apart = 0.0f, most = -INFINITY, second = -INFINITY; // saved where children are joined, at most
            for (uint child = firsts[node]; child < end; ++child) {
                const float own = child < leaf_count && rule != RULE_TOTAL ? 0.0f : boxes_energy(errors[child], limit, rule);
                const float cost = child < leaf_count ? own + price : costs[child], saved = cost - own;
                apart += cost;
                second = max(second, min(most, saved));
                most = max(most, saved);
            }
            const bool one = limit >= 0.0f && energy + price <= apart;
            if (boxed && limit >= 0.0f && energy > price && most + second > price) {
                queue[live++] = node; // neither all of it for sure, nor none of it
                continue;
            }
            costs[node] = one ? energy + price : apart;
            for (uint child = firsts[node]; child < end; ++child) joins[child] = one ? node : NO_NODE;
        }
        if (!live) continue;
        for (uint slot = 0; slot < 8; ++slot) {
            const uint box = boxes_single[slot];
            for (uint lane = 0; lane < LANES; ++lane) room.sums[box][lane] = 0.0f;
            room.energies[box] = room.costs[box] = room.counts[box] = 0.0f;
        }
        float8 all = 0.0f;
        for (uint j = 0; j < live; ++j) {
            const uint node = queue[j], end = node + 1 < first_node + node_count ? firsts[node + 1] : child_end;
            room.occupied[j] = 0;
            ((float *)&all)[j] = (float)(end - firsts[node]);
            for (uint child = firsts[node]; child < end; ++child) {
                const float own = child < leaf_count && rule != RULE_TOTAL ? 0.0f : boxes_energy(errors[child], limit, rule);
                boxes_add_child(&room, j, child, centres[child].xyz - centres[node].xyz, sums[child], own,
                    child < leaf_count ? own + price : costs[child]);
            }
        }
        for (uint i = 0; i < JOINED; ++i)
            boxes_choose(&room, boxes_order[i], centres[queue[0]].w, price, limit, rule, all);
        for (uint j = 0; j < live; ++j) {
            const uint node = queue[j], end = node + 1 < first_node + node_count ? firsts[node + 1] : child_end;
            const float whole = boxes_energy(errors[node], limit, rule) + price, apart = ((float *)&room.costs[WHOLE])[j];
            costs[node] = min(whole, apart);
            if (whole > apart) boxes_join(&room, j, centres[node].xyz, solved, joins);
            for (uint child = firsts[node]; whole <= apart && child < end; ++child) joins[child] = node;
        }
    }
}
