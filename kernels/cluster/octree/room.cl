// Octree, boxes: eight cubes at a time, and the cheapest vertices for each box of their children.
//
// Source    as boxes.cl
// Work      functions only
// Reads     nothing
// Writes    nothing, but for representatives and joins where `room_join` is called
// Needs     cluster/octree/place.cl
// Plain     cluster/octree/reference_boxes.py

#define CUBES 8
#define BOXES 27 // along each axis 0 the lower half, 1 the upper, 2 both; x + 3 y + 9 z
#define WHOLE 26
#define JOINED 19 // boxes of several children
#define NO_NODE 0xFFFFFFFFu
#define OF_A_BOX 4.0f
#define SURE 0.5f // of what parts' energies say of their sum's, which is no less but where a step was cut short

// halves before what is made of them
__constant uchar room_order[JOINED] = {2, 5, 6, 7, 11, 14, 15, 16, 18, 19, 21, 22, 8, 17, 20, 23, 24, 25, 26};
// children in each box, bits by x + 2 y + 4 z
__constant uchar room_children[BOXES] = {
    1, 2, 3, 4, 8, 12, 5, 10, 15, 16, 32,
    48, 64, 128, 192, 80, 160, 240, 17, 34, 51, 68, 136, 204, 85, 170, 255};
// and the box of each child
__constant uchar room_single[8] = {0, 1, 3, 4, 9, 10, 12, 13};
__constant uchar room_stride[3] = {1, 3, 9};

typedef struct {
    float8 sums[BOXES][LANES]; // about the cubes' centres
    float8 energies[BOXES], costs[BOXES], counts[BOXES];
    float8 points[BOXES][4];
    int8 choices[BOXES];       // halve along this axis, or -1: one vertex
    uint children[CUBES][8];   // by x + 2 y + 4 z
    uint occupied[CUBES];      // which of them are there
} boxes_room;

static inline void room_clear(boxes_room *room)
{
    for (uint slot = 0; slot < 8; ++slot) {
        const uint box = room_single[slot];
        for (uint lane = 0; lane < LANES; ++lane) room->sums[box][lane] = 0.0f;
        room->energies[box] = room->costs[box] = room->counts[box] = 0.0f;
    }
    for (uint j = 0; j < CUBES; ++j) room->occupied[j] = 0;
}

// a child of cube j, `from` its centre
static inline void room_add(boxes_room *room, const uint j, const uint child, const float3 from, const float16 sums,
    const float energy, const float cost)
{
    const uint slot = (from.x > 0.0f) + 2 * (from.y > 0.0f) + 4 * (from.z > 0.0f), box = room_single[slot];
    float moved[LANES];
    vstore16(octree_moved(sums, from), 0, moved);
    for (uint lane = 0; lane < LANES; ++lane) ((float *)&room->sums[box][lane])[j] = moved[lane];
    ((float *)&room->energies[box])[j] = energy;
    ((float *)&room->costs[box])[j] = cost;
    ((float *)&room->counts[box])[j] = 1.0f;
    room->children[j][slot] = child;
    room->occupied[j] |= 1u << slot;
}

// what a vertex adds beyond its price, when its node has this error
static inline float room_energy(const float error, const float limit, const uint rule)
{
    return rule == RULE_TOTAL ? error * error : error <= limit ? 0.0f : INFINITY;
}

// the cheapest way to halve a box of the eight cubes, and one vertex for all of it where that is cheaper
static inline void room_choose(boxes_room *room, const uint box, const float edge, const float price, const float limit,
    const uint rule)
{
    float8 best = INFINITY, least = 0.0f, count = 0.0f;
    int8 choice = 0, wanted = -1;
    uint low = 0, high = 0;
    for (uint axis = 0; axis < 3; ++axis) {
        const uint stride = room_stride[axis];
        if (box / stride % 3 != 2) continue;
        low = box - 2 * stride, high = box - stride;
        const float8 cost = room->costs[low] + room->costs[high], energy = room->energies[low] + room->energies[high];
        const int8 cheaper = cost < best;
        best = cheaper ? cost : best;
        choice = cheaper ? (int8)(int)axis : choice;
        // what cannot be cheaper is not solved; an empty half leaves nothing to join
        least = max(least, energy);
        wanted &= (room->counts[low] > 0.0f) & (room->counts[high] > 0.0f) & (SURE * energy + price < cost);
        count = room->counts[low] + room->counts[high];
    }
    if (box != WHOLE) {
        float8 *columns = room->sums[box];
        for (uint lane = 0; lane < LANES; ++lane) columns[lane] = room->sums[low][lane] + room->sums[high][lane];
        float8 all = 0.0f;
        for (uint slot = 0; slot < 8; ++slot) all += room->counts[room_single[slot]];
        wanted &= count < all; // all children together are the cube
        if (!quadric_all8(~wanted)) {
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

// children of cube j to `all`, or to the vertices that were chosen where that is NO_NODE
static inline void room_join(const boxes_room *room, const uint j, const uint all, const float3 centre, __global float4 *solved,
    __global uint *joins)
{
    uint waiting[8], depth = 1;
    waiting[0] = WHOLE;
    while (depth) {
        const uint box = waiting[--depth];
        const uint inside = room_children[box] & room->occupied[j];
        if (!inside) continue;
        const uint first = room->children[j][popcount((inside & (~inside + 1)) - 1)];
        if (all != NO_NODE) {
            for (uint slot = 0; slot < 8; ++slot)
                if (inside >> slot & 1) joins[room->children[j][slot]] = all;
            return;
        }
        if (((const float *)&room->counts[box])[j] == 1.0f) { // a child by itself
            joins[first] = NO_NODE;
            continue;
        }
        const int choice = ((const int *)&room->choices[box])[j];
        if (choice >= 0) {
            const uint stride = room_stride[choice];
            waiting[depth++] = box - 2 * stride;
            waiting[depth++] = box - stride;
            continue;
        }
        const float8 *point = room->points[box];
        solved[first] = (float4)(((const float *)point)[j] + centre.x, ((const float *)(point + 1))[j] + centre.y,
            ((const float *)(point + 2))[j] + centre.z, ((const float *)(point + 3))[j]);
        for (uint slot = 0; slot < 8; ++slot)
            if (inside >> slot & 1) joins[room->children[j][slot]] = first;
    }
}
