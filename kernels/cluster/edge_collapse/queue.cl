// Edge collapse: a block's queue of edges by cost and number. Those that it begins with are sorted, for most will be of no
// use when their turn comes; those that come later go to a heap with four children. Among equals the edge that came first.
//
// Source    Williams 1964, Algorithm 232, Heapsort; Knuth, The Art of Computer Programming 3, 5.2.5 (radix exchange by digits)
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

// at the end, in no order, where it costs no more than the threshold: without branches, which are as often this way as that
INLINE void queue_append(Block *b, const uint u, const uint v, const float cost, const float threshold)
{
    b->edges[b->ranks] = (uint2)(u | v << 16, b->version[u] + b->version[v]);
    b->ranked[b->ranks] = (ulong)as_uint(cost) << 32 | b->ranks;
    b->ranks += cost <= threshold;
}

// what was appended in order, digit by digit of the cost
INLINE void queue_order(Block *b)
{
    b->edge_count = b->ranks;
    uint places[4][256] = {{0}};
    for (uint i = 0; i < b->ranks; ++i) {
        const uint cost = b->ranked[i] >> 32;
        for (uint k = 0; k < 4; ++k) ++places[k][cost >> 8 * k & 255];
    }
    for (uint k = 0; k < 4; ++k) {
        uint sum = 0;
        for (uint digit = 0; digit < 256; ++digit) {
            const uint count = places[k][digit];
            places[k][digit] = sum;
            sum += count;
        }
        __global const ulong *from = k & 1 ? b->spare : b->ranked;
        __global ulong *to = k & 1 ? b->ranked : b->spare;
        for (uint i = 0; i < b->ranks; ++i) to[places[k][from[i] >> (32 + 8 * k) & 255]++] = from[i];
    }
}

// to the heap, its ends as they are; left out where there is no room
INLINE void queue_push(Block *b, const uint u, const uint v, const float cost)
{
    if (b->edge_count >= EDGES) return;
    b->edges[b->edge_count] = (uint2)(u | v << 16, (uint)b->version[u] + b->version[v]);
    const ulong item = (ulong)as_uint(cost) << 32 | b->edge_count++;
    uint i = b->queued++;
    for (; i > 0 && b->queue[(i - 1) / 4] > item; i = (i - 1) / 4) b->queue[i] = b->queue[(i - 1) / 4];
    b->queue[i] = item;
}

// the cheapest edge whose ends are as they were when it was asked, and its cost's bits; false where there is none
INLINE bool queue_next(Block *b, uint *u, uint *v, uint *cost)
{
    while (b->rank < b->ranks || b->queued) {
        ulong item = b->rank < b->ranks ? b->ranked[b->rank] : ULONG_MAX;
        if (b->queued && b->queue[0] < item) {
            item = b->queue[0];
            const ulong last = b->queue[--b->queued];
            if (b->queued) queue_sink(b, 0, last);
        } else
            ++b->rank;
        const uint2 edge = b->edges[(uint)item];
        *u = edge.x & 0xFFFF;
        *v = edge.x >> 16;
        *cost = item >> 32;
        if (b->version[*u] && b->version[*v] && (uint)b->version[*u] + b->version[*v] == edge.y) return true;
    }
    return false;
}
