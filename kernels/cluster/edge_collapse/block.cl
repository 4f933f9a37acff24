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
#define NONE 0xFFFFu
#define FOLD -0.5f // cosine of the normals at folds, which are held always
#define BENT 0.64f // square of the share that is left of normals in their sum, where there may be a fold
#define AHEAD 16  // triangles whose points are on their way from memory
#define BORDER 1u  // kinds of vertices
#define WHOLE 2u   // all of its triangles are the block's
// words of a slice, whole cache lines: quadrics, queue, edges, ids, then what has 16 bits
#define SLICE_WORDS ((16 * VERTICES + 4 * EDGES + 16 + VERTICES + (4 + 4) * BLOCK / 2 + 6 * VERTICES / 2 + SLOTS / 2 + 31) / 16 * 16)

typedef struct {
    __global float8 *planes;   // of vertices: A as xx xy xz yy yz zz, c, triangles in the whole mesh
    __global float4 *lines;    // b
    __global float4 *places;   // x y z, limit of the distance
    __global ulong *queue;  // cost's bits, number of the edge: a binary heap, the least first
    __global uint2 *edges;  // both ends, the sum of their versions
    __global uint *ids;     // the vertex of the mesh
    __global ushort *corners, *next;  // [4 t + k]: vertex, next corner of the same; [4 t + 3]: does the triangle live?
    __global ushort *head, *degree, *given, *version, *kind, *mark;  // of vertices; version 0: it stays or is gone
    __global ushort *slots;
    uint triangles, vertices, edge_count, queued, stamp, slot_mask;
} Block;

INLINE void block_open(Block *b, __global uint *slice)
{
    b->planes = (__global float8 *)slice;
    b->lines = (__global float4 *)(slice + 8 * VERTICES);
    b->places = b->lines + VERTICES;
    b->queue = (__global ulong *)(slice + 16 * VERTICES);
    b->edges = (__global uint2 *)(b->queue + EDGES + 8);
    b->ids = (__global uint *)(b->edges + EDGES);
    b->corners = (__global ushort *)(b->ids + VERTICES);
    b->next = b->corners + 4 * BLOCK;
    b->head = b->next + 4 * BLOCK;
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

// planes upright on the border edges at a vertex, whose neighbours there are in one triangle with it
INLINE void block_border(Block *b, const uint u, const float weight)
{
    const uint once = ++b->stamp, twice = ++b->stamp;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        b->mark[w.x] = b->mark[w.x] == once ? twice : once;
        b->mark[w.y] = b->mark[w.y] == once ? twice : once;
    }
    const float3 p = b->places[u].xyz;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        const float3 x = b->places[w.x].xyz - p, y = b->places[w.y].xyz - p;
        const float3 normal = cross(x, y), a = cross(x, normal), z = cross(y, normal);
        const float aa = dot(a, a), zz = dot(z, z);
        if (b->mark[w.x] == once && aa > 0.0f) b->planes[u] += quadric_plane(a, weight * dot(x, x) / aa);
        if (b->mark[w.y] == once && zz > 0.0f) b->planes[u] += quadric_plane(z, weight * dot(y, y) / zz);
    }
}

// planes upright on the creases at a vertex, edges whose two triangles' normals have a cosine below the limit
INLINE void block_creases(Block *b, const uint u, const float weight, const float crease)
{
    const float3 p = b->places[u].xyz;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        const float3 x = b->places[w.x].xyz - p, n = cross(x, b->places[w.y].xyz - p);
        for (uint d = b->head[u]; d != NONE; d = b->next[d]) {
            const uint2 other = block_others(b, d);
            if (other.y != w.x) continue;
            const float3 m = cross(b->places[other.x].xyz - p, x);
            if (dot(n, m) >= crease * sqrt(dot(n, n) * dot(m, m))) continue;
            const float3 one = cross(x, n), two = cross(x, m);
            const float oo = dot(one, one), tt = dot(two, two);
            if (oo > 0.0f) b->planes[u] += quadric_plane(one, weight * dot(x, x) / oo);
            if (tt > 0.0f) b->planes[u] += quadric_plane(two, weight * dot(x, x) / tt);
        }
    }
}

// the block's triangles, their vertices with quadrics, and which of these may go: those all of whose triangles it has
INLINE void block_load(Block *b, __global const uint4 *rows, const uint count, __global const float4 *points,
    __global const float *limits, __global const float8 *held, const float border_weight, const uint keep_border,
    const float crease)
{
    for (b->slot_mask = 63; b->slot_mask < 4 * count - 1;) b->slot_mask = 2 * b->slot_mask + 1;
    for (uint s = 0; s <= b->slot_mask; ++s) b->slots[s] = NONE;
    b->triangles = count;
    b->vertices = b->edge_count = b->queued = b->stamp = 0;
    for (uint t = 0; t < count; ++t) {
        const uint4 row = rows[t], ahead = rows[min(t + AHEAD, count - 1)];
        prefetch(points + ahead.x, 1);
        prefetch(points + ahead.y, 1);
        prefetch(points + ahead.z, 1);
        const uint id[3] = {row.x, row.y, row.z};
        uint own[3];
        for (uint k = 0; k < 3; ++k) {
            const uint v = own[k] = block_number(b, id[k], points, limits, held);
            b->corners[4 * t + k] = v;
            b->next[4 * t + k] = b->head[v];
            b->head[v] = 4 * t + k;
            ++b->degree[v];
        }
        b->corners[4 * t + 3] = 1;
        // around a vertex inside the surface every neighbour follows once and goes before once: they cancel out
        for (uint k = 0; k < 3; ++k) b->kind[own[k]] += own[k == 2 ? 0 : k + 1] - own[k == 0 ? 2 : k - 1];
        const float3 p = b->places[own[0]].xyz;
        const float3 n = cross(b->places[own[1]].xyz - p, b->places[own[2]].xyz - p);
        const float square = dot(n, n);
        if (!(square > 0.0f)) continue;
        const float8 plane = quadric_plane(n, 0.5f * rsqrt(square));  // area times the unit normal's square
        const float4 bend = (float4)(n, sqrt(square));
        for (uint k = 0; k < 3; ++k) {
            b->planes[own[k]] += plane;
            b->lines[own[k]] += bend;
        }
    }
    for (uint v = 0; v < b->vertices; ++v) {
        b->given[v] = b->degree[v];
        b->version[v] = b->planes[v].s7 == (float)b->degree[v];
        const bool rim = b->kind[v] != 0;
        b->kind[v] = b->version[v] ? WHOLE : 0;
        // folds are seen in the sum of the normals, so that most vertices need not be looked at edge by edge
        const float4 bend = b->lines[v];
        b->lines[v] = 0.0f;
        const bool bent = crease > FOLD || dot(bend.xyz, bend.xyz) < BENT * bend.w * bend.w;
        if (bent && b->version[v]) block_creases(b, v, border_weight, crease);
        if (!rim || !b->version[v]) continue;
        b->kind[v] |= BORDER;
        if (keep_border)
            b->version[v] = 0;
        else
            block_border(b, v, border_weight);
    }
}

// does an edge run from u to v in some triangle?
INLINE bool block_runs(const Block *b, const uint u, const uint v)
{
    for (uint c = b->head[u]; c != NONE; c = b->next[c])
        if (block_others(b, c).x == v) return true;
    return false;
}

// is the edge from u to v, as some triangle has it, the one of the two that is asked? Without branches but on borders
INLINE uint block_asks(const Block *b, const uint u, const uint v)
{
    const uint inside = (b->version[u] != 0) & (b->version[v] != 0);
    if (inside & b->kind[u] & b->kind[v] & BORDER) return u < v || !block_runs(b, v, u);
    return inside & (u < v);
}
