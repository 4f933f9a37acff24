// Edge collapse in rounds, geometry stage: may an edge go? The link condition, and whether a triangle turns, by rings.
//
// Source    Dey, Edelsbrunner, Guha & Nekhayev 1999, Topology preserving edge contraction (link condition); Lindstrom &
//           Turk, Fast and Memory Efficient Polygonal Simplification, 1998 (volume)
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

// vertices near both ends, each once, though a crowded edge has it twice; `one` is u's ring, `two` the other's
INLINE uint link_common(__global const uint2 *restrict ring, const uint2 one, const uint2 two, const uint u,
    const bool rim_one, const bool rim_two)
{
    uint common = 0;
    for (uint e = two.x; e < two.y; ++e) {
        const uint2 w = ring[e], before = (uint2)(two.x, e);
        if (w.x != u && link_has(ring, one, w.x, rim_one)) common += !link_has(ring, before, w.x, false);
        if (rim_two && w.y != u && !link_has(ring, two, w.y, false) && link_has(ring, one, w.y, rim_one))
            common += ring[e].x != w.y && !link_has(ring, before, w.y, true);
    }
    return common;
}

// has the vertex an edge of more than two triangles? Then it is on no surface
INLINE bool link_crowded(__global const uint2 *restrict ring, const uint2 range)
{
    for (uint e = range.x; e < range.y; ++e) {
        uint at_x = 0, at_y = 0;
        for (uint f = range.x; f < range.y; ++f) {
            at_x += ring[f].x == ring[e].x || ring[f].y == ring[e].x;
            at_y += ring[f].x == ring[e].y || ring[f].y == ring[e].y;
        }
        if (max(at_x, at_y) > 2) return true;
    }
    return false;
}

// triangles that go with the edge, 0 where it must stay: where the surface would no longer be what it was. Where it is
// none, the edge may go if just those vertices are near both ends that are opposite to it
INLINE uint link_gone(__global const uint *restrict starts, __global const uint2 *restrict ring, const uint u,
    const uint v, const bool rim_u, const bool rim_v)
{
    const uint2 one = link_range(starts, u), two = link_range(starts, v);
    uint gone = 0, back = 0, opposites = 0, opposite = u;
    for (uint e = one.x; e < one.y; ++e) {
        const uint2 w = ring[e];
        if (w.x != v && w.y != v) continue;
        ++gone;
        opposite = w.x == v ? w.y : w.x;
        bool again = false;
        for (uint f = one.x; f < e; ++f)
            again |= (ring[f].x == v && ring[f].y == opposite) || (ring[f].y == v && ring[f].x == opposite);
        opposites += !again;
    }
    for (uint e = two.x; e < two.y; ++e) back += ring[e].x == u || ring[e].y == u;
    const bool along = rim_u && rim_v;
    const uint expected = along ? 1 : 2, least = rim_u || rim_v ? 1 : 3;
    if (back != gone) return 0;
    if (gone != expected || link_common(ring, one, two, u, rim_u, rim_v) != expected
        || (along && starts[opposite + 1] - starts[opposite] < 2)) {
        if (!link_crowded(ring, one) && !link_crowded(ring, two)) return 0;
        return link_common(ring, one, two, u, true, true) == opposites ? gone : 0;
    }
    return one.y - one.x + two.y - two.x < 2 * gone + least ? 0 : gone;
}

// half of the volume is made up for that a collapse would take from, or add to, what is below the surface: planes of the
// mesh leave bends too flat. Not where the surface folds back on itself
INLINE void link_level(__global const float4 *restrict places, __global const uint *restrict starts,
    __global const uint2 *restrict ring, const uint u, const uint v, Quadrics *merged)
{
    const float3 p = (float3)(merged->px.s0, merged->py.s0, merged->pz.s0);
    const float3 edge = places[v].xyz - places[u].xyz;
    float3 normal = 0.0f;
    float volume = 0.0f, areas = 0.0f;
    for (uint end = 0; end < 2; ++end) {
        const float3 place = places[end ? v : u].xyz;
        const uint2 range = link_range(starts, end ? v : u);
        for (uint e = range.x; e < range.y; ++e) {
            const uint2 w = ring[e];
            if (end && (w.x == u || w.y == u)) continue;
            const float3 n = cross(places[w.x].xyz - place, places[w.y].xyz - place);
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
