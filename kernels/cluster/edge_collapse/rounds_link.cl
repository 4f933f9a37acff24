// Edge collapse in rounds, geometry stage: may an edge go? The link condition, and whether a triangle turns, by rings.
//
// Source    Dey, Edelsbrunner, Guha & Nekhayev 1999, Topology preserving edge contraction (link condition)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/rounds_state.cl

INLINE uint2 link_range(__global const uint *restrict starts, const uint v) { return (uint2)(starts[v], starts[v + 1]); }

INLINE bool link_has(__global const uint2 *restrict ring, const uint2 range, const uint w)
{
    for (uint e = range.x; e < range.y; ++e)
        if (ring[e].x == w || ring[e].y == w) return true;
    return false;
}

// triangles that go with the edge, 0 where it must stay: where the surface would no longer be what it was
INLINE uint link_gone(__global const uint *restrict starts, __global const uint2 *restrict ring, const uint u,
    const uint v, const uint rims)
{
    const uint2 one = link_range(starts, u), two = link_range(starts, v);
    uint gone = 0, back = 0, common = 0, opposite = u;
    for (uint e = one.x; e < one.y; ++e) {
        const uint2 w = ring[e];
        if (w.x != v && w.y != v) continue;
        ++gone;
        opposite = w.x == v ? w.y : w.x;
    }
    for (uint e = two.x; e < two.y; ++e) {
        const uint2 w = ring[e];
        back += w.x == u || w.y == u;
        bool again = w.x == u, next = w.y == u; // each neighbour once, as the next one where it is that too
        for (uint f = two.x; f < two.y; ++f) {
            again |= f < e && ring[f].x == w.x;
            next |= ring[f].x == w.y || (f < e && ring[f].y == w.y);
        }
        common += !again && link_has(ring, one, w.x);
        common += !next && link_has(ring, one, w.y);
    }
    const bool along = rims == 2;
    const uint expected = along ? 1 : 2, least = rims ? 1 : 3;
    if (gone != expected || back != expected || common != expected) return 0;
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
