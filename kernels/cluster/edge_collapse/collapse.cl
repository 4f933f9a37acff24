// Edge collapse, geometry stage: may an edge of a block go, and what becomes of the triangles at its ends?
//
// Source    Dey, Edelsbrunner, Guha & Nekhayev 1999, Topology preserving edge contraction (link condition)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/around.cl cluster/edge_collapse/queue.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// has the vertex an edge of more than two triangles? Then it is on no surface
INLINE bool collapse_crowded(const Block *b, const uint u)
{
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        uint at_x = 0, at_y = 0;
        for (uint d = b->head[u]; d != NONE; d = b->next[d]) {
            if (!b->corners[d | 3]) continue;
            const uint2 other = block_others(b, d);
            at_x += other.x == w.x || other.y == w.x;
            at_y += other.x == w.y || other.y == w.y;
        }
        if (max(at_x, at_y) > 2) return true;
    }
    return false;
}

// Without branches, which are as often this way as that: triangles that go with the edge, 0 where it must stay: where the surface would no longer be what it was. Where it is
// none, the edge may go if just those vertices are near both ends that are opposite to it. Fills `around`
INLINE uint collapse_gone(Block *b, const uint u, const uint v)
{
    const uint met = ++b->stamp, facing = ++b->stamp, shared = ++b->stamp;
    uint rest = 0, gone = 0, common = 0, opposites = 0, opposite = u;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        const uint both = (w.x == v) | (w.y == v);
        b->mark[w.x] = b->mark[w.x] == facing ? facing : met;
        b->mark[w.y] = b->mark[w.y] == facing ? facing : met;
        // those with both ends from behind, until it is known how many others there are
        b->around[both ? LAST - gone : rest] = (ushort4)(u, w.x, w.y, c);
        rest += !both;
        gone += both;
        opposite = !both ? opposite : w.x == v ? w.y : w.x;
        opposites += both & (b->mark[opposite] != facing);
        b->mark[opposite] = both ? facing : b->mark[opposite];
    }
    b->mark[v] = shared;
    for (uint c = b->head[v]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        const uint at_x = b->mark[w.x], at_y = b->mark[w.y];
        const uint x = (at_x == met) | (at_x == facing), y = (w.y != w.x) & ((at_y == met) | (at_y == facing));
        b->mark[w.y] = y ? shared : at_y;
        b->mark[w.x] = x ? shared : at_x;
        common += x + y;
        b->around[rest] = (ushort4)(v, w.x, w.y, c);
        rest += (w.x != u) & (w.y != u);
    }
    b->rest = rest;
    b->both = gone;
    const bool along = b->kind[u] & b->kind[v] & BORDER;
    const uint expected = along ? 1 : 2, least = (b->kind[u] | b->kind[v]) & BORDER ? 1 : 3;
    if (gone != expected || common != expected || (along && b->degree[opposite] < 2))
        return common == opposites && (collapse_crowded(b, u) || collapse_crowded(b, v)) ? gone : 0;
    return (uint)b->degree[u] + b->degree[v] < 2 * gone + least ? 0 : gone;
}

// does the collapse cost more in the mean than the square of the lesser limit of its ends?
INLINE bool collapse_strays(const Block *b, const uint u, const uint v, const Quadrics *merged)
{
    const float limit = fmin(b->places[u].w, b->places[v].w);
    return merged->c.s0 > limit * limit * (merged->xx.s0 + merged->yy.s0 + merged->zz.s0);
}

// v takes over the triangles of u but for those with both
INLINE void collapse_join(Block *b, const uint u, const uint v, const Quadrics *merged)
{
    for (uint i = b->rest; i < b->rest + b->both; ++i) {
        const ushort4 row = b->around[i];
        b->corners[row.w | 3] = 0;
        --b->degree[row.y == v ? row.z : row.y];
    }
    uint head = NONE;
    for (uint i = 0; i < b->rest; ++i) {
        const uint c = b->around[i].w;
        b->corners[c] = v;
        b->next[c] = head;
        head = c;
    }
    b->head[v] = head;
    b->degree[v] = b->rest;
    b->degree[u] = 0;
    b->kind[v] |= b->kind[u];
    b->version[u] = 0;
    ++b->version[v];
    b->planes[v] = (float8)(merged->xx.s0, merged->xy.s0, merged->xz.s0, merged->yy.s0, merged->yz.s0, merged->zz.s0,
        merged->c.s0, 0.0f);
    b->lines[v] = (float4)(merged->bx.s0, merged->by.s0, merged->bz.s0, 0.0f);
    const float limit = fmin(b->places[u].w, b->places[v].w);
    b->places[v] = (float4)(merged->px.s0, merged->py.s0, merged->pz.s0, limit);
}

// costs of the edges from v, whose quadric it is, to some neighbours; those below the threshold go to the queue
INLINE void collapse_cost(Block *b, const uint v, const Quadrics *own, uint *w, const uint count, const float threshold)
{
    for (uint i = count; i < 8; ++i) w[i] = w[0];
    Quadrics others, sum;
    block_quadrics(b, w, false, &others);
    float costs[8];
    vstore8(quadric_merge(own, &others, &sum), 0, costs);
    for (uint i = 0; i < count; ++i)
        if (costs[i] <= threshold) queue_push(b, v, w[i], costs[i]);
}

// costs of the edges at v, anew, which has just taken over what is around it
INLINE void collapse_ask(Block *b, const uint v, const float threshold)
{
    const uint asked = ++b->stamp;
    Quadrics own;
    block_quadric(b, v, &own);
    uint found[8], count = 0;
    // inside the surface every neighbour follows once
    const uint turn = b->kind[v] & BORDER ? 2 : 1;
    for (uint i = 0; i < turn * b->rest; ++i) {
        const ushort4 row = b->around[i < b->rest ? i : i - b->rest];
        const uint w = i < b->rest ? row.z : row.y;
        if (!b->version[w] || b->mark[w] == asked) continue;
        b->mark[w] = asked;
        found[count++] = w;
        if (count < 8) continue;
        collapse_cost(b, v, &own, found, count, threshold);
        count = 0;
    }
    if (count) collapse_cost(b, v, &own, found, count, threshold);
}
