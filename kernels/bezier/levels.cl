// A level for each patch: chosen by the eye, then borders brought to the level that both sides have, and triangles.
//
// Source    Concheiro 2013, chapter 2: the level is chosen for each object and camera; that patches choose, and how
//           neighbours of different level meet, is a reconstruction
// Work      bezier_levels and bezier_levels_snap: 1-D over patches; bezier_levels_indices: 1-D over chunks of a patch's triangles
// Reads     controls       float[64 * patches]  as bezier/patch.cl has it
//           slots          uint [levels]        vertices of a patch, by level
//           places         uint [3 * borders]   slot, i and j of every vertex on a border, level after level
//           place_starts   uint [levels + 1]
//           owners         uint [8 * patches]   of the edges, 8 patch + 2 edge + (1: it runs the other way), then of the
//                                               corners, 4 patch + corner: whose normals they have
//           topology       uint [3 * ...]       triangles of a patch, level after level
//           topology_starts uint [levels + 1]
// Writes    levels         uint [patches]
//           edge_levels    uint [4 * patches]   edges u = 0, u = 1, v = 0, v = 1
//           vertex_counts, triangle_counts  uint [patches]
//           positions, normals  float[3 * vertices]
//           triangles      uint [3 * triangles]
//           counts         uint [2]
// Needs     bezier/normal.cl
// Plain     bezier/leveled.py
// Defines   NORMALS (1: normals too), STREAMING (0)

#pragma OPENCL FP_CONTRACT OFF

#define NEAREST_W 1e-20f // in front of the eye

static inline float2 levels_pixel(const float4 a, const float4 x, const float4 y, const float w)
{
    return (float2)(((a.x * x.x + a.y * x.y) + (a.z * x.z + x.w)) / w, ((a.x * y.x + a.y * y.y) + (a.z * y.z + y.w)) / w);
}

static inline float levels_apart(const float2 a, const float2 b)
{
    const float x = b.x - a.x, y = b.y - a.y;
    return sqrt(x * x + y * y);
}

// of the edge with these control points: segments of at most so many pixels; the same from either end
static inline uint levels_of_edge(const float4 *c, const float4 x, const float4 y, const float4 w, const float pixels, const uint finest)
{
    float2 at[4];
    for (uint k = 0; k < 4; ++k) {
        const float depth = (c[k].x * w.x + c[k].y * w.y) + (c[k].z * w.z + w.w);
        if (!(depth > NEAREST_W)) return finest;
        at[k] = levels_pixel(c[k], x, y, depth);
    }
    const float length = (levels_apart(at[0], at[1]) + levels_apart(at[2], at[3])) + levels_apart(at[1], at[2]);
    uint level = 0;
    while (level < finest && !(pixels * (float)(1u << level) >= length)) ++level;
    return level;
}

__kernel void bezier_levels(
    __global const float *restrict controls,
    __global const uint *restrict slots,
    __global uint *restrict levels,
    __global uint *restrict edge_levels,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const float4 screen_x, // from a point to pixels times w
    const float4 screen_y,
    const float4 screen_w,
    const float pixels, // of a segment
    const uint finest,
    const uint patch_count)
{
    const uint p = get_global_id(0);
    if (p >= patch_count) return;

    uint most = 0;
    for (uint edge = 0; edge < 4; ++edge) {
        const uint first = edge == 1 ? 12 : edge == 3 ? 3 : 0, step = edge < 2 ? 1 : 4;
        float4 c[4];
        for (uint k = 0; k < 4; ++k) c[k] = vload4(16 * (size_t)p + first + step * k, controls);
        const uint level = levels_of_edge(c, screen_x, screen_y, screen_w, pixels, finest);
        edge_levels[4 * p + edge] = level;
        most = max(most, level);
    }
    levels[p] = most;
    vertex_counts[p] = slots[most];
    triangle_counts[p] = 2u << (2 * most);
}

// the place on an edge, as (u, v)
static inline float2 levels_place(const uint edge, const float t)
{
    return edge < 2 ? (float2)((float)edge, t) : (float2)(t, (float)(edge - 2));
}

__kernel void bezier_levels_snap(
    __global const float *restrict controls,
    __global const uint *restrict levels,
    __global const uint *restrict edge_levels,
    __global const uint *restrict offsets,
    __global const uint *restrict vertex_total,
    __global const uint *restrict triangle_total,
    __global const uint *restrict places,
    __global const uint *restrict place_starts,
    __global const uint *restrict owners,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict counts,
    const uint patch_count)
{
    const uint p = get_global_id(0);
    if (p >= patch_count) return;

    if (p == 0) counts[0] = vertex_total[0], counts[1] = triangle_total[0];
    const uint level = levels[p], n = 1u << level;
    const float step = 1.0f / (float)n;
    __global const float *c = controls + CONTROL_FLOATS * (size_t)p;
    for (uint b = place_starts[level]; b < place_starts[level + 1]; ++b) {
        const uint3 place = vload3(b, places);
        const uint i = place.y, j = place.z;
        const size_t slot = offsets[p] + place.x;
        const bool is_row = i == 0 || i == n;
        const uint edge = is_row ? (i ? 1 : 0) : j ? 3 : 2;
        const uint drop = level - edge_levels[4 * p + edge];
        const uint k = ((is_row ? j : i) >> drop) << drop;
        uint owner;
        float2 at;
        if (k == 0 || k == n) {
            const uint row = is_row ? edge : (k ? 1 : 0), column = is_row ? (k ? 1 : 0) : edge - 2;
            vstore3(vload4(12 * row + 3 * column, c).xyz, slot, positions);
            const uint whose = owners[8 * p + 4 + 2 * row + column];
            owner = whose / 4;
            at = (float2)((float)(whose / 2 & 1), (float)(whose & 1));
        } else {
            const uint m = min(k, n - k), first = edge == 1 ? 12 : edge == 3 ? 3 : 0;
            const int along = edge < 2 ? 1 : 4, turned = m != k;
            const float t = (float)m * step, s = 1.0f - t;
            float4 q[4];
            for (int l = 0; l < 4; ++l) q[l] = vload4(first + along * (turned ? 3 - l : l), c);
            const float4 point =
                BEZIER_CUBIC(s * s * s, 3.0f * s * s * t, 3.0f * s * t * t, t * t * t, q[0], q[1], q[2], q[3]);
            vstore3(point.xyz, slot, positions);
            const uint whose = owners[8 * p + edge];
            owner = whose / 8;
            at = levels_place(whose / 2 & 3, (whose & 1 ? n - k : k) * step);
        }
#if NORMALS
        bezier_patch patch;
        bezier_patch_at(&patch, controls, owner);
        vstore3(bezier_unit(bezier_cross_at(&patch, at.x, at.y), &patch, at.x, at.y), slot, normals);
#endif
    }
}

#define INDEX_CHUNK 256 // triangles of an item

__kernel void bezier_levels_indices(
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict topology,
    __global const uint *restrict topology_starts,
    __global uint *restrict triangles,
    const uint chunks, // of a patch
    const uint patch_count)
{
    const uint p = get_global_id(0) / chunks;
    if (p >= patch_count) return;

    const uint level = levels[p], count = 2u << (2 * level), begin = get_global_id(0) % chunks * INDEX_CHUNK;
    if (begin >= count) return;
    __global const uint *from = topology + 3 * ((size_t)topology_starts[level] + begin);
    __global uint *to = triangles + 3 * ((size_t)triangle_offsets[p] + begin);
    const uint vertex = offsets[p], numbers = 3 * min((uint)INDEX_CHUNK, count - begin);
    for (uint k = 0; k < numbers; ++k) to[k] = from[k] + vertex;
}
