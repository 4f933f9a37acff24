// Edge collapse in rounds, vertex stage: quadrics of the mesh as it is now, and which vertices lie on its border.
//
// Source    Lindstrom & Turk 1998 (quadrics of the current mesh); Garland & Heckbert 1997, section 6 (border planes)
// Work      1-D, one item per chunk of vertices, eight at once
// Reads     places    float4[vertices]      x y z, locked
//           starts    uint[vertices + 1]    of the vertices' rings
//           ring      uint2[corners]        next, previous vertex of each triangle at a vertex
//           ids       uint[vertices]        the vertex of the mesh
//           held      float8[vertex_count]  where attributes count: quadrics besides those of planes; A, summed up
//           state     uint[16]
// Writes    planes    float8[vertices]      A as xx xy xz yy yz zz, two unused
//           kinds     uchar[vertices]       RIM, FIXED
//           rims      uint[vertices]        the neighbour over a border edge that comes to the vertex; NONE
//           degrees   uint[vertices]        triangles
//           absorbed  uint[vertices]        NONE: the vertex that went to it in this round
//           touched   uchar[vertices]       0: what touched it in this round
// Needs     cluster/edge_collapse/rounds_state.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// is a triangle's edge from the vertex to w, or with `back` from w to it, that of no other triangle?
INLINE bool vertex_alone(__global const uint2 *restrict ring, const uint2 range, const uint w, const bool back)
{
    for (uint e = range.x; e < range.y; ++e)
        if ((back ? ring[e].x : ring[e].y) == w) return false;
    return true;
}

// planes upright on the border edges at a vertex; the neighbour over an edge that comes to it
INLINE uint vertex_border(__global const float4 *restrict places, __global const uint2 *restrict ring, const uint2 range,
    const float3 p, const float weight, float8 *plane)
{
    uint rim = NONE;
    for (uint e = range.x; e < range.y; ++e) {
        const uint2 w = ring[e];
        const float3 x = places[w.x].xyz - p, y = places[w.y].xyz - p;
        const float3 normal = cross(x, y), a = cross(x, normal), z = cross(y, normal);
        const float aa = dot(a, a), zz = dot(z, z);
        if (vertex_alone(ring, range, w.x, false) && aa > 0.0f) *plane += quadric_plane(a, weight * dot(x, x) / aa);
        if (!vertex_alone(ring, range, w.y, true)) continue;
        rim = min(rim, w.y);
        if (zz > 0.0f) *plane += quadric_plane(z, weight * dot(y, y) / zz);
    }
    return rim;
}

// planes upright on the creases at a vertex, edges whose two triangles' normals have a cosine below the limit
INLINE void vertex_creases(__global const float4 *restrict places, __global const uint2 *restrict ring, const uint2 range,
    const float3 p, const float weight, const float crease, float8 *plane)
{
    for (uint e = range.x; e < range.y; ++e) {
        const uint2 w = ring[e];
        const float3 x = places[w.x].xyz - p, n = cross(x, places[w.y].xyz - p);
        for (uint f = range.x; f < range.y; ++f) {
            if (ring[f].y != w.x) continue;
            const float3 m = cross(places[ring[f].x].xyz - p, x);
            if (dot(n, m) >= crease * sqrt(dot(n, n) * dot(m, m))) continue;
            const float3 one = cross(x, n), two = cross(x, m);
            const float oo = dot(one, one), tt = dot(two, two);
            if (oo > 0.0f) *plane += quadric_plane(one, weight * dot(x, x) / oo);
            if (tt > 0.0f) *plane += quadric_plane(two, weight * dot(x, x) / tt);
        }
    }
}

__kernel void edge_collapse_rounds_vertex_quadrics(
    __global const float4 *restrict places,
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const uint *restrict ids,
    __global const float8 *restrict held,
    __global const uint *restrict state,
    __global float8 *restrict planes,
    __global uchar *restrict kinds,
    __global uint *restrict rims,
    __global uint *restrict degrees,
    __global uint *restrict absorbed,
    __global uchar *restrict touched,
    const float border_weight,
    const uint keep_border,
    const float crease, // cosine; -1: none
    const uint holding,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || ring_done(state)) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    for (uint first = rows.x; first < rows.y; first += 8) {
        uint own[8], begin[8], count[8], turn[8], most = 0;
        for (uint i = 0; i < 8; ++i) {
            own[i] = min(first + i, rows.y - 1); // lanes past the end are the last again
            begin[i] = starts[own[i]];
            count[i] = starts[own[i] + 1] - begin[i];
            most = max(most, count[i]);
            turn[i] = 0;
        }
        const fours8 p = ring_columns(places, 1, own);
        float8 xx = 0.0f, xy = 0.0f, xz = 0.0f, yy = 0.0f, yz = 0.0f, zz = 0.0f;
        for (uint k = 0; k < most; ++k) {
            uint x[8], y[8];
            for (uint i = 0; i < 8; ++i) { // past a ring's end: a triangle without area
                const uint2 pair = k < count[i] ? ring[begin[i] + k] : (uint2)(own[i]);
                x[i] = pair.x;
                y[i] = pair.y;
                turn[i] += pair.x - pair.y; // inside the surface each neighbour is next once and previous once
            }
            const fours8 next = ring_columns(places, 1, x), last = ring_columns(places, 1, y);
            const float8 ax = next.x - p.x, ay = next.y - p.y, az = next.z - p.z;
            const float8 bx = last.x - p.x, by = last.y - p.y, bz = last.z - p.z;
            const float8 nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
            const float8 square = nx * nx + ny * ny + nz * nz;
            // area times the unit normal's square
            const float8 weight = square > 0.0f ? 0.5f / sqrt(square) : (float8)(0.0f);
            const float8 mx = nx * weight, my = ny * weight, mz = nz * weight;
            xx += mx * nx, xy += mx * ny, xz += mx * nz, yy += my * ny, yz += my * nz, zz += mz * nz;
        }
        const fours8 one = transpose_fours(xx, xy, xz, yy), two = transpose_fours(yz, zz, (float8)(0.0f), (float8)(0.0f));
        float8 plane[8] = {(float8)(one.x.lo, two.x.lo), (float8)(one.y.lo, two.y.lo), (float8)(one.z.lo, two.z.lo),
            (float8)(one.w.lo, two.w.lo), (float8)(one.x.hi, two.x.hi), (float8)(one.y.hi, two.y.hi),
            (float8)(one.z.hi, two.z.hi), (float8)(one.w.hi, two.w.hi)};
        for (uint i = 0; i < 8 && first + i < rows.y; ++i) {
            const uint v = own[i];
            const uint2 range = (uint2)(begin[i], begin[i] + count[i]);
            const float4 place = places[v];
            uint rim = NONE;
            if (crease > -1.0f) vertex_creases(places, ring, range, place.xyz, border_weight, crease, plane + i);
            if (turn[i]) rim = vertex_border(places, ring, range, place.xyz, border_weight, plane + i);
            planes[v] = holding ? plane[i] + held[ids[v]] : plane[i];
            kinds[v] = (turn[i] ? RIM : 0) | (place.w > 0.0f || (turn[i] && keep_border) ? FIXED : 0);
            rims[v] = rim;
            degrees[v] = count[i];
            absorbed[v] = NONE;
            touched[v] = 0;
        }
    }
}
