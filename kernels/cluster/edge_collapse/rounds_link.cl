// Edge collapse in rounds, geometry stage: may an edge go? The link condition, and whether a triangle turns, by rings.
//
// Source    Dey, Edelsbrunner, Guha & Nekhayev 1999, Topology preserving edge contraction (link condition)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/rounds_state.cl

INLINE uint2 link_range(__global const uint *restrict starts, const uint v) { return (uint2)(starts[v], starts[v + 1]); }

// is w a neighbour? Inside the surface each is once the next one
INLINE bool link_has(__global const uint2 *restrict ring, const uint2 range, const uint w, const bool rim)
{
    bool found = false;
    for (uint e = range.x; e < range.y; ++e) found |= ring[e].x == w;
    for (uint e = range.x; rim && e < range.y; ++e) found |= ring[e].y == w;
    return found;
}

// triangles that go with the edge, 0 where it must stay: where the surface would no longer be what it was
INLINE uint link_gone(__global const uint *restrict starts, __global const uint2 *restrict ring, const uint u,
    const uint v, const bool rim_u, const bool rim_v)
{
    const uint2 one = link_range(starts, u), two = link_range(starts, v);
    uint gone = 0, back = 0, common = 0, next = NONE, last = NONE; // the vertices opposite
    for (uint e = one.x; e < one.y; ++e) {
        const uint2 w = ring[e];
        gone += (w.x == v) + (w.y == v);
        next = w.x == v ? w.y : next;
        last = w.y == v ? w.x : last;
    }
    for (uint e = two.x; e < two.y; ++e) {
        const uint2 w = ring[e];
        back += (w.x == u) + (w.y == u);
        common += w.x != u && link_has(ring, one, w.x, rim_u);
        if (rim_v && w.y != u && !link_has(ring, two, w.y, false)) common += link_has(ring, one, w.y, rim_u);
    }
    const bool along = rim_u && rim_v;
    const uint expected = along ? 1 : 2, least = rim_u || rim_v ? 1 : 3;
    if (gone != expected || back != expected || common != expected || next == last) return 0;
    const uint opposite = next == NONE ? last : next;
    if (along && starts[opposite + 1] - starts[opposite] < 2) return 0;
    return one.y - one.x + two.y - two.x < 2 * gone + least ? 0 : gone;
}

// would a triangle at the vertex turn by more than the limit, with the vertex at p? Those with v go
INLINE bool link_turns(__global const float4 *restrict places, __global const uint2 *restrict ring, const uint2 range,
    const float3 before, const uint v, const float3 p, const float limit)
{
    for (uint e = range.x; e < range.y; ++e) {
        const uint2 w = ring[e];
        if (w.x == v || w.y == v) continue;
        const float3 x = places[w.x].xyz, y = places[w.y].xyz;
        const float3 n = cross(x - before, y - before), m = cross(x - p, y - p);
        const float nn = dot(n, n), nm = dot(n, m);
        if (nn > 0.0f && !(nm > 0.0f && nm * nm >= limit * nn * dot(m, m))) return true;
    }
    return false;
}
