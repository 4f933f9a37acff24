// Edge collapse, the last stage: vertices move to where they fit the samples best, one step.
//
// Source    ours; least squares of distances from planes as in Chen & Medioni, Object Modelling by Registration of Multiple
//           Range Images, 1992, solved by steps of a Jacobi iteration
// Work      1-D, one item per chunk of vertices
// Reads     places      float4[row_count]         output vertices, near 1; w: not 0, it stays
//           counts      uint[2]                   vertices, triangles of the output
//           met         uint[map_count * (row_count + 1)]   the last part: where each vertex's corners end
//           ring        uint[9 * triangles out]   corners, the vertices next and before
//           slots       uint[3 * triangles out]   the row of each corner there
//           sums        float8[3 * triangles out] as in fit_gather.cl
// Writes    moved       float4[row_count]         places, one step on
//           vertices    float[3 * vertex_count]   model units, of vertices that moved
// Needs     common/chunk.cl cluster/edge_collapse/fit.cl
// Plain     cluster/edge_collapse/fit_reference.py

#define FIT_RIDGE 1e-3f // of the weights: what a flat vertex is solved with
#define FIT_STEP 1.5f   // times what the sums of weights would have a vertex move, which is never too far
#define FIT_ROOM 0.45f  // of a triangle's height: all three of its vertices may move so far in its plane without turning it
#define FIT_FOLD -0.5f  // cosine of the normals at folds, FOLD in block.cl
#define FIT_BENT 0.64f  // as there: folds are seen in the sum of the normals

// where the samples would have a vertex, from where it lies: (A + ridge) step = b, by cofactors
static inline float3 fit_solve(const float3 diagonal, const float3 mixed, const float3 b, const float ridge)
{
    const float xx = diagonal.x + ridge, yy = diagonal.y + ridge, zz = diagonal.z + ridge;
    const float xy = mixed.x, xz = mixed.y, yz = mixed.z;
    const float3 p = (float3)(yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    const float det = xx * p.x + xy * p.y + xz * p.z;
    if (!(det > 0.0f)) return (float3)(0.0f);
    const float3 q = (float3)(p.y, xx * zz - xz * xz, xy * xz - xx * yz);
    const float3 r = (float3)(p.z, q.z, xx * yy - xy * xy);
    return (float3)(dot(p, b), dot(q, b), dot(r, b)) / det;
}

// is an edge at the vertex a crease, which is held?
static inline bool fit_creases(__global const uint *ring, const uint corners, const float3 p,
    __global const float4 *places, const float crease)
{
    for (uint i = 0; i < corners; ++i) {
        const uint3 own = vload3(i, ring);
        const float3 x = places[own.y].xyz - p, n = cross(x, places[own.z].xyz - p);
        for (uint j = 0; j < corners; ++j) {
            const uint3 other = vload3(j, ring);
            if (other.z != own.y) continue;
            const float3 m = cross(places[other.y].xyz - p, x);
            if (dot(n, m) < crease * sqrt(dot(n, n) * dot(m, m))) return true;
        }
    }
    return false;
}

__kernel void edge_collapse_fit_move(
    __global const float4 *restrict places,
    __global const uint *restrict counts,
    __global const uint *restrict met,
    __global const uint *restrict ring,
    __global const uint *restrict slots,
    __global const float8 *restrict sums,
    __global float4 *restrict moved,
    __global float *restrict vertices,
    const float unscale,
    const float crease, // cosine
    const uint room,
    const uint row_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || counts[1] > room) return;

    met += (size_t)(map_count - 1) * (row_count + 1);
    const uint2 range = chunk_rows(chunk, chunk_count, counts[0]);
    for (uint v = range.x; v < range.y; ++v) {
        const uint start = v ? met[v - 1] : 0, corners = met[v] - start;
        const float4 place = places[v];
        const float3 p = place.xyz;
        moved[v] = place;
        if (place.w != 0.0f) continue;
        float3 diagonal = 0.0f, mixed = 0.0f, b = 0.0f, normals = 0.0f;
        float total = 0.0f, areas = 0.0f;
        uint around = 0; // inside the surface every neighbour follows once and goes before once: they cancel out
        for (uint i = 0; i < corners; ++i) {
            const uint3 corner = vload3(start + i, ring);
            const uint2 others = fit_others(corner.x);
            around += corner.y - corner.z;
            const float3 n = cross(places[corner.y].xyz - p, places[corner.z].xyz - p);
            const float square = dot(n, n);
            normals += n;
            areas += sqrt(square);
            if (!(square > FIT_LEAST)) continue;
            const float8 own = sums[start + i], next = sums[slots[others.x]], before = sums[slots[others.y]];
            const float weight = (own.s0 + next.s2 + before.s1) / square;
            const float high = (own.s3 + next.s5 + before.s4) * rsqrt(square);
            diagonal += weight * n * n;
            mixed += weight * n.xxy * n.yzz;
            b += high * n;
            total += weight * square;
        }
        if (around || !(total > 0.0f)) continue;
        const bool bent = crease > FIT_FOLD || dot(normals, normals) < FIT_BENT * areas * areas;
        if (bent && fit_creases(ring + 3 * (size_t)start, corners, p, places, crease)) continue;
        const float3 step = FIT_STEP * fit_solve(diagonal / total, mixed / total, b / total, FIT_RIDGE);
        float share = 1.0f;
        for (uint i = 0; i < corners; ++i) {
            const uint3 corner = vload3(start + i, ring);
            const float3 x = places[corner.y].xyz - p, y = places[corner.z].xyz - p, z = y - x;
            const float3 n = cross(x, y), along = cross(n, step); // as long as the step in the plane times n
            const float longest = fmax(dot(x, x), fmax(dot(y, y), dot(z, z))), square = dot(n, n);
            const float most = FIT_ROOM * square, length = sqrt(dot(along, along) * longest);
            if (length * share > most) share = most / length;
        }
        const float3 to = p + step * share;
        if (!(dot(to, to) < FIT_NOWHERE)) continue;
        moved[v] = (float4)(to, 0.0f);
        vstore3(clamp(to * unscale, (float3)(-3.4e38f), (float3)(3.4e38f)), v, vertices);
    }
}
