// Edge collapse, geometry stage: may an edge of a block go, and what becomes of the triangles at its ends?
//
// Source    Dey, Edelsbrunner, Guha & Nekhayev 1999, Topology preserving edge contraction (link condition); Lindstrom &
//           Turk, Fast and Memory Efficient Polygonal Simplification, 1998 (volume)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/edges.cl cluster/edge_collapse/queue.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// would a triangle at u turn by more than the limit, with u at p? Those with v go; those without area may do as they like
INLINE bool collapse_turns(const Block *b, const uint u, const uint v, const float3 p, const float limit)
{
    const float3 before = b->places[u].xyz;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        if (w.x == v || w.y == v) continue;
        const float3 x = b->places[w.x].xyz, y = b->places[w.y].xyz;
        const float3 n = cross(x - before, y - before), m = cross(x - p, y - p);
        const float nn = dot(n, n), nm = dot(n, m);
        if (nn > 0.0f && !(nm > 0.0f && nm * nm >= limit * nn * dot(m, m))) return true;
    }
    return false;
}

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

// triangles that go with the edge, 0 where it must stay: where the surface would no longer be what it was. Where it is
// none, the edge may go if just those vertices are near both ends that are opposite to it
INLINE uint collapse_gone(Block *b, const uint u, const uint v)
{
    const uint met = ++b->stamp, facing = ++b->stamp, shared = ++b->stamp;
    uint gone = 0, common = 0, opposites = 0, opposite = u;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        if (b->mark[w.x] != facing) b->mark[w.x] = met;
        if (b->mark[w.y] != facing) b->mark[w.y] = met;
        if (w.x != v && w.y != v) continue;
        ++gone;
        opposite = w.x == v ? w.y : w.x;
        opposites += b->mark[opposite] != facing;
        b->mark[opposite] = facing;
    }
    b->mark[v] = shared;
    for (uint c = b->head[v]; c != NONE; c = b->next[c]) {
        if (!b->corners[c | 3]) continue;
        const uint2 w = block_others(b, c);
        const bool x = b->mark[w.x] == met || b->mark[w.x] == facing;
        const bool y = w.y != w.x && (b->mark[w.y] == met || b->mark[w.y] == facing);
        if (x) b->mark[w.x] = shared;
        if (y) b->mark[w.y] = shared;
        common += x + y;
    }
    const bool along = b->kind[u] & b->kind[v] & BORDER;
    const uint expected = along ? 1 : 2, least = (b->kind[u] | b->kind[v]) & BORDER ? 1 : 3;
    if (gone != expected || common != expected || (along && b->degree[opposite] < 2))
        return common == opposites && (collapse_crowded(b, u) || collapse_crowded(b, v)) ? gone : 0;
    return (uint)b->degree[u] + b->degree[v] < 2 * gone + least ? 0 : gone;
}

// half of the volume is made up for that a collapse would take from, or add to, what is below the surface: planes of the
// mesh as it has become leave bends too flat. Not where the surface folds back on itself
INLINE void collapse_level(const Block *b, const uint u, const uint v, Quadrics *merged)
{
    const float3 p = (float3)(merged->px.s0, merged->py.s0, merged->pz.s0);
    const float3 edge = b->places[v].xyz - b->places[u].xyz;
    float3 normal = 0.0f;
    float volume = 0.0f, areas = 0.0f;
    for (uint end = 0; end < 2; ++end) {
        const float3 place = b->places[end ? v : u].xyz;
        for (uint c = b->head[end ? v : u]; c != NONE; c = b->next[c]) {
            if (!b->corners[c | 3]) continue;
            const uint2 w = block_others(b, c);
            if (end && (w.x == u || w.y == u)) continue;
            const float3 n = cross(b->places[w.x].xyz - place, b->places[w.y].xyz - place);
            normal += n;
            volume += dot(n, place - p);
            areas += sqrt(dot(n, n));
        }
    }
    const float square = dot(normal, normal);
    if (!(square > FOLDED * areas * areas)) return;
    const float3 s = normal * (LEVELLED * volume / square);
    if (dot(s, s) < dot(edge, edge)) quadric_move(merged, s);
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
    const uint ends[2] = {u, v};
    uint head = NONE, degree = 0;
    for (uint end = 0; end < 2; ++end)
        for (uint c = b->head[ends[end]]; c != NONE;) {
            const uint next = b->next[c];
            if (b->corners[c | 3]) {
                const uint2 w = block_others(b, c);
                if (end == 0 && (w.x == v || w.y == v)) {
                    b->corners[c | 3] = 0;
                    --b->degree[w.x == v ? w.y : w.x];
                } else {
                    b->corners[c] = v;
                    b->next[c] = head;
                    head = c;
                    ++degree;
                }
            }
            c = next;
        }
    b->head[v] = head;
    b->degree[v] = degree;
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

// costs of the edges at v, anew
INLINE void collapse_ask(Block *b, const uint v, const float threshold)
{
    const uint asked = ++b->stamp;
    Quadrics own;
    block_quadric(b, v, &own);
    uint found[8], count = 0;
    for (uint c = b->head[v]; c != NONE; c = b->next[c]) {
        const uint2 pair = block_others(b, c);
        for (uint k = 0; k < 2; ++k) {
            const uint w = k ? pair.y : pair.x;
            if (!b->version[w] || b->mark[w] == asked) continue;
            b->mark[w] = asked;
            found[count++] = w;
            if (count < 8) continue;
            collapse_cost(b, v, &own, found, count, threshold);
            count = 0;
        }
    }
    if (count) collapse_cost(b, v, &own, found, count, threshold);
}
