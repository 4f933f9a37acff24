// Are two surfaces nowhere farther apart than a bound? A grid over the triangles of one, in which they are found.
//
// Source    none, ours
// Work      1-D, one item per chunk of triangles
// Reads     points      float[3 * points]     in units of the diagonal, from the grid's corner
//           triangles   uint[3 * triangle_count]
// Writes    cells       uint[cells]           triangles of each; scanned and filled, where each cell's list ends
//           list        uint[]                its triangles, cell by cell, in any order
// Needs     common/chunk.cl

static inline int3 within_cell(const float3 p, const float along, const int3 cells)
{
    return clamp(convert_int3(clamp(p * along, 0.0f, 1e6f)), (int3)(0), cells - 1);
}

// the triangle's cells among those of its box: those that its plane goes through; counts them or lists it there
static inline void within_enter(const uint t, const float3 a, const float3 b, const float3 c, const float along,
    const int3 cells, __global uint *counts, __global uint *list)
{
    const int3 low = within_cell(fmin(a, fmin(b, c)), along, cells), high = within_cell(fmax(a, fmax(b, c)), along, cells);
    const float3 n = cross(b - a, c - a);
    const float reach = (0.5001f * (fabs(n.x) + fabs(n.y) + fabs(n.z)) + 1e-30f) / along;
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const float3 middle = ((float3)(x, y, z) + 0.5f) / along;
                if (low.x != high.x && low.y != high.y && low.z != high.z && fabs(dot(n, middle - a)) > reach) continue;
                const uint at = atomic_inc(counts + ((z * cells.y + y) * cells.x + x));
                if (list) list[at] = t;
            }
}

__kernel void cluster_within_count(
    __global const float *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict cells,
    const float along, // cells per unit
    const int3 sides,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 row = vload3(t, triangles);
        within_enter(t, vload3(row.x, points), vload3(row.y, points), vload3(row.z, points), along, sides, cells, 0);
    }
}

__kernel void cluster_within_fill(
    __global const float *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict cells,
    __global uint *restrict list,
    const float along,
    const int3 sides,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 row = vload3(t, triangles);
        within_enter(t, vload3(row.x, points), vload3(row.y, points), vload3(row.z, points), along, sides, cells, list);
    }
}
