// Edge collapse: one block's triangles by themselves, in its work-item's own slice of memory.
//
// Source    none
// Work      functions only; numbers are the block's own and fit 16 bits; lists of corners are linked, so that two
//           vertices' lists are joined where they stand
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/state.cl cluster/edge_collapse/fragment.cl
// Defines   BLOCK       most triangles of a block

#define VERTICES (3 * BLOCK)
#define SLOTS (4 * BLOCK) // of the hash table: BLOCK is a power of two
#define EDGES (4 * BLOCK)  // that a block's queue can ever hold
#define LAST (BLOCK + 15) // of `around`
#define NONE 0xFFFFu
#define FOLD -0.5f // cosine of the normals at folds, which are held always
#define BENT 0.64f // square of the share that is left of normals in their sum, where there may be a fold
#define AHEAD 16  // triangles whose points are on their way from memory
#define BORDER 1u  // kinds of vertices
#define WHOLE 2u   // all of its triangles are the block's
#define FREE 4u    // it might go, as the block was read
// words of a slice, whole cache lines: quadrics, queue, edges, ids, then what has 16 bits
#define SLICE_WORDS \
    ((16 * VERTICES + 8 * EDGES + 16 + VERTICES + (4 + 4 + 4) * BLOCK / 2 + 32 + 6 * VERTICES / 2 + SLOTS / 2 + 31) / 16 * 16)

typedef struct {
    __global float8 *planes;   // of vertices: A as xx xy xz yy yz zz, c, triangles in the whole mesh
    __global float4 *lines;    // b
    __global float4 *places;   // x y z, limit of the distance
    __global ulong *queue, *ranked, *spare;  // cost's bits, number of the edge: a heap, and in order what there was first
    __global uint2 *edges;  // both ends, the sum of their versions
    __global uint *ids;     // the vertex of the mesh
    __global ushort *corners, *next;  // [4 t + k]: vertex, next corner of the same; [4 t + 3]: does the triangle live?
    __global ushort4 *around;  // `rest` triangles with one end of an edge, `both` with both: end, the others, the end's corner
    __global ushort *head, *degree, *given, *version, *kind, *mark;  // of vertices; version 0: it stays or is gone
    __global ushort *slots;
    uint triangles, vertices, edge_count, queued, ranks, rank, stamp, slot_mask, rest, both;
} Block;

INLINE void block_open(Block *b, __global uint *slice)
{
    b->planes = (__global float8 *)slice;
    b->lines = (__global float4 *)(slice + 8 * VERTICES);
    b->places = b->lines + VERTICES;
    b->queue = (__global ulong *)(slice + 16 * VERTICES);
    b->ranked = b->queue + EDGES + 8;
    b->spare = b->ranked + EDGES;
    b->edges = (__global uint2 *)(b->spare + EDGES);
    b->ids = (__global uint *)(b->edges + EDGES);
    b->corners = (__global ushort *)(b->ids + VERTICES);
    b->next = b->corners + 4 * BLOCK;
    b->around = (__global ushort4 *)(b->next + 4 * BLOCK);
    b->head = (__global ushort *)(b->around + BLOCK + 16);
    b->degree = b->head + VERTICES;
    b->given = b->degree + VERTICES;
    b->version = b->given + VERTICES;
    b->kind = b->version + VERTICES;
    b->mark = b->kind + VERTICES;
    b->slots = b->mark + VERTICES;
}

// the other two corners' vertices of corner c, in the triangle's order
INLINE uint2 block_others(const Block *b, const uint c)
{
    const uint k = c & 3, t = c - k;
    return (uint2)(b->corners[t + (k == 2 ? 0 : k + 1)], b->corners[t + (k == 0 ? 2 : k - 1)]);
}

// the block's number of a vertex of the mesh, given where it is met first
INLINE uint block_number(Block *b, const uint id, __global const float4 *points, __global const float *limits,
    __global const float8 *held)
{
    uint slot = id * 2654435761u & b->slot_mask;
    while (true) {
        const uint found = b->slots[slot];
        if (found == NONE) break;
        if (b->ids[found] == id) return found;
        slot = (slot + 1) & b->slot_mask;
    }
    const uint own = b->vertices++;
    const float4 p = points[id];
    b->slots[slot] = own;
    b->ids[own] = id;
    b->planes[own] = held ? held[id] : (float8)(0.0f);
    b->planes[own].s7 = p.w;
    b->places[own] = (float4)(p.xyz, limits ? limits[id] : 0.0f);
    b->lines[own] = 0.0f;
    b->head[own] = NONE;
    b->degree[own] = b->mark[own] = b->kind[own] = 0;
    return own;
}
