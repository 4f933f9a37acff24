// Edge collapse: quadrics of a block's vertices, eight at once, and what its edges cost.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/load.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// quadrics of eight vertices; `fresh` ones are planes through their vertices
INLINE void block_quadrics(const Block *b, const uint *v, const bool fresh, Quadrics *q)
{
    __global const float4 *halves = (__global const float4 *)b->planes;
    const fours8 first = block_columns(halves, 2, v), second = block_columns(halves + 1, 2, v);
    const fours8 place = block_columns(b->places, 1, v);
    q->xx = first.x, q->xy = first.y, q->xz = first.z, q->yy = first.w, q->yz = second.x, q->zz = second.y;
    q->px = place.x, q->py = place.y, q->pz = place.z;
    q->bx = q->by = q->bz = q->c = 0.0f;
    if (fresh) return;
    const fours8 line = block_columns(b->lines, 1, v);
    q->bx = line.x, q->by = line.y, q->bz = line.z, q->c = second.z;
}

// that of one vertex, eight times
INLINE void block_quadric(const Block *b, const uint v, Quadrics *q)
{
    const float8 plane = b->planes[v];
    const float4 line = b->lines[v], place = b->places[v];
    q->xx = plane.s0, q->xy = plane.s1, q->xz = plane.s2, q->yy = plane.s3, q->yz = plane.s4, q->zz = plane.s5;
    q->c = plane.s6;
    q->bx = line.x, q->by = line.y, q->bz = line.z;
    q->px = place.x, q->py = place.y, q->pz = place.z;
}

// does an edge run from u to v in some triangle?
INLINE bool block_runs(const Block *b, const uint u, const uint v)
{
    for (uint c = b->head[u]; c != NONE; c = b->next[c])
        if (block_others(b, c).x == v) return true;
    return false;
}

// is the edge from u to v, as some triangle has it, the one of the two that is asked? Without branches but on borders
INLINE uint block_asks(const Block *b, const uint u, const uint v, const uint kind)
{
    const uint free = (kind & FREE) != 0;
    if (free & kind & BORDER) return u < v || !block_runs(b, v, u);
    return free & (u < v);
}

// edges of the block's triangles, to be asked for their costs: `count` of eight, and what the last triangle has more
typedef struct {
    uint u[10], v[10];
    uint count, more;
} Edges;

// the next edges, from a triangle on, which goes on; false where there are none left
INLINE bool block_edges(const Block *b, uint *t, Edges *edges)
{
    uint count = edges->more;
    for (uint i = 0; i < 2; ++i) edges->u[i] = edges->u[8 + i], edges->v[i] = edges->v[8 + i];
    for (; *t < b->triangles && count < 8; ++*t) {
        const ushort4 row = *(__global const ushort4 *)(b->corners + 4 * *t);
        const uint x = b->kind[row.x], y = b->kind[row.y], z = b->kind[row.z];
        edges->u[count] = row.x, edges->v[count] = row.y;
        count += block_asks(b, row.x, row.y, x & y);
        edges->u[count] = row.y, edges->v[count] = row.z;
        count += block_asks(b, row.y, row.z, y & z);
        edges->u[count] = row.z, edges->v[count] = row.x;
        count += block_asks(b, row.z, row.x, z & x);
    }
    edges->count = min(count, 8u);
    edges->more = count - edges->count;
    return count > 0;
}

// what the edges cost; lanes past their number are the first again
INLINE float8 block_costs(const Block *b, Edges *edges)
{
    for (uint i = edges->count; i < 8; ++i) edges->u[i] = edges->u[0], edges->v[i] = edges->v[0];
    Quadrics u, v, sum;
    block_quadrics(b, edges->u, true, &u);
    block_quadrics(b, edges->v, true, &v);
    return quadric_merge(&u, &v, &sum);
}
