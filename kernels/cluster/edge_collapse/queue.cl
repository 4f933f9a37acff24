// Edge collapse: a block's queue of edges, a binary heap of cost and number; among equals the edge that came first.
//
// Source    Williams 1964, Algorithm 232, Heapsort
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/block.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// the item to its place at or below i; behind the last stands what is more than any, so that every child has a sibling
INLINE void queue_sink(Block *b, uint i, const ulong item)
{
    for (uint k = 0; k < 3; ++k) b->queue[b->queued + k] = ULONG_MAX;
    for (uint child = 4 * i + 1; child < b->queued; child = 4 * i + 1) {
        const ulong p = b->queue[child], q = b->queue[child + 1], r = b->queue[child + 2], s = b->queue[child + 3];
        const ulong pq = min(p, q), rs = min(r, s), least = min(pq, rs);
        if (least >= item) break;
        b->queue[i] = least;
        i = child + (rs < pq ? 2 + (s < r) : (q < p));
    }
    b->queue[i] = item;
}

// at the end, in no order; a full queue takes no more
INLINE void queue_append(Block *b, const uint u, const uint v, const float cost)
{
    if (b->edge_count >= EDGES) return;
    const uint edge = b->edge_count++;
    b->edges[edge] = (uint2)(u | v << 16, (uint)b->version[u] + b->version[v]);
    b->queue[b->queued++] = (ulong)as_uint(cost) << 32 | edge;
}

INLINE void queue_order(Block *b)
{
    for (uint i = (b->queued + 2) / 4; i-- > 0;) queue_sink(b, i, b->queue[i]);
}

INLINE void queue_push(Block *b, const uint u, const uint v, const float cost)
{
    const uint before = b->queued;
    queue_append(b, u, v, cost);
    if (b->queued == before) return;
    uint i = before;
    const ulong item = b->queue[i];
    for (; i > 0 && b->queue[(i - 1) / 4] > item; i = (i - 1) / 4) b->queue[i] = b->queue[(i - 1) / 4];
    b->queue[i] = item;
}

INLINE uint2 queue_pop(Block *b)
{
    const uint edge = (uint)b->queue[0];
    const ulong last = b->queue[--b->queued];
    if (b->queued) queue_sink(b, 0, last);
    return b->edges[edge];
}
