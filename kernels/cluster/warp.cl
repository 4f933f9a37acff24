// Vertex clustering, vertex stage under a warp: where vertices lie in the space that the grid is laid over.
//
// Source    DeCoro & Tatarchuk 2007 (view-dependent and region-of-interest warps); the table and the limit are reconstructions
// Work      1-D, one item per chunk of vertices; atomics take the maximum, which no order changes
// Reads     positions  float[3 * vertex_count]         model units
//           table      float[3 * (WARP_STEPS + 1)]     F(t) - t of x, y, z at t = 0 .. 1
// Writes    warped     float[3 * vertex_count]         what the grid's cells are told from, scaled model units
//           stretch    float[3 * vertex_count]         length before the warp per length after it, along x, y, z
//           points     float4[vertex_count]            x y z, which the warp must not move, beside the cell's rank
//           limits     uint[3 * capacity]              bits of the cell's step limits, units of the largest even edge
// Needs     common/chunk.cl common/grid.cl
// Plain     cluster/warp.py
// Defines   WARP_STEPS

static inline void warp_store8(__global float *restrict warped, const uint v, const uint vertex_count, const grid_points8 p)
{
    const float8 a = (float8)(p.x.s0, p.y.s0, p.z.s0, p.x.s1, p.y.s1, p.z.s1, p.x.s2, p.y.s2);
    const float8 b = (float8)(p.z.s2, p.x.s3, p.y.s3, p.z.s3, p.x.s4, p.y.s4, p.z.s4, p.x.s5);
    const float8 c = (float8)(p.y.s5, p.z.s5, p.x.s6, p.y.s6, p.z.s6, p.x.s7, p.y.s7, p.z.s7);
    if (v + 8 <= vertex_count) {
        vstore8(a, 3 * (size_t)(v / 8), warped);
        vstore8(b, 3 * (size_t)(v / 8) + 1, warped);
        vstore8(c, 3 * (size_t)(v / 8) + 2, warped);
    } else {
        float last[24];
        vstore8(a, 0, last);
        vstore8(b, 1, last);
        vstore8(c, 2, last);
        for (uint j = 0; j < 3 * (vertex_count - v); ++j) warped[3 * (size_t)v + j] = last[j];
    }
}

static inline float8 warp_look8(__global const float *restrict table, const int8 i)
{
    return (float8)(table[i.s0], table[i.s1], table[i.s2], table[i.s3], table[i.s4], table[i.s5], table[i.s6], table[i.s7]);
}

// one coordinate moved; no product is fused into a sum, so that numpy rounds alike
static inline float8 warp_axis8(__global const float *restrict table, const float8 p, const float low, const float extent,
    const float steps_per_unit, float8 *stretch)
{
#pragma OPENCL FP_CONTRACT OFF
    const float8 s = (p - low) * steps_per_unit;
    const int8 i = clamp(convert_int8(s), (int8)0, (int8)(WARP_STEPS - 1));
    const float8 start = warp_look8(table, i), rise = warp_look8(table, i + 1) - start;
    const float8 slope = rise * (float)WARP_STEPS + 1.0f;
    *stretch = 1.0f / max(slope, (float8)(1e-6f));
    const float8 within = (s - convert_float8(i)) * rise;
    const float8 shift = (start + within) * extent;
    return p + shift;
}

__kernel void cluster_warp_table(
    __global const float *restrict positions,
    __global const float *restrict table,
    __global float *restrict warped,
    __global float *restrict stretch,
    const float4 low,            // w: a power of two, which scales positions
    const float4 extent,         // of the scaled box
    const float4 steps_per_unit, // of the table; 0 along a flat axis
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; v += 8) {
        const grid_points8 p = grid_load8(positions, v, vertex_count);
        grid_points8 q, s;
        q.x = warp_axis8(table, p.x * low.w, low.x, extent.x, steps_per_unit.x, &s.x);
        q.y = warp_axis8(table + WARP_STEPS + 1, p.y * low.w, low.y, extent.y, steps_per_unit.y, &s.y);
        q.z = warp_axis8(table + 2 * (WARP_STEPS + 1), p.z * low.w, low.z, extent.z, steps_per_unit.z, &s.z);
        warp_store8(warped, v, vertex_count, q);
        warp_store8(stretch, v, vertex_count, s);
    }
}

static inline float8 warp_row8(const grid_points8 u, const float4 row)
{
#pragma OPENCL FP_CONTRACT OFF
    const float8 x = u.x * row.x, y = u.y * row.y, z = u.z * row.z;
    const float8 first = x + y, second = z + row.w;
    return first + second;
}

// about the logarithm to base 2, without a step between powers of two; numpy gives the same bits
static inline float8 warp_log8(const float8 w)
{
#pragma OPENCL FP_CONTRACT OFF
    const int8 bits = as_int8(w);
    const float8 t = as_float8((bits & (int8)0x007fffff) | (int8)0x3f800000) - 1.0f;
    const float8 scaled = t * 0.15f;
    const float8 bent = t * (scaled + -0.57f);
    const float8 within = t * (bent + 1.42f);
    return convert_float8((bits >> 23) - 127) + within;
}

// a place after projection; what is outside of what is seen counts as on its border, what is behind the eye too
__kernel void cluster_warp_view(
    __global const float *restrict positions,
    __global float *restrict warped,
    __global float *restrict stretch,
    const float4 low,
    const float4 row_x, // of positions scaled, from the box's corner
    const float4 row_y,
    const float4 row_z,
    const float4 row_w, // 1 in the middle of what is seen; w: of the nearest place that is told apart
    const float4 least,
    const float4 most, // w: of the depth's logarithm; 0: the depth is z
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; v += 8) {
        const grid_points8 u = grid_scale8(grid_load8(positions, v, vertex_count), low, 1.0f);
        const float8 w = max(warp_row8(u, row_w), (float8)(least.w));
        grid_points8 q;
        q.x = clamp(warp_row8(u, row_x) / w, (float8)(least.x), (float8)(most.x));
        q.y = clamp(warp_row8(u, row_y) / w, (float8)(least.y), (float8)(most.y));
        const float8 z = most.w > 0.0f ? warp_log8(w) * most.w : warp_row8(u, row_z) / w;
        q.z = clamp(z, (float8)(least.z), (float8)(most.z));
        warp_store8(warped, v, vertex_count, q);
        // a cell widens with the distance; as deep as that by its logarithm, by z as its square
        const float8 wide = most.w > 0.0f ? w : max(w, w * w);
        const grid_points8 s = {wide, wide, wide};
        warp_store8(stretch, v, vertex_count, s);
    }
}

// bits of floats above zero rise with them
static inline void warp_limit(__global uint *restrict limits, const uint rank, const float3 limit)
{
    __global uint *own = limits + 3 * (size_t)rank;
    atomic_max(own, as_uint(limit.x));
    atomic_max(own + 1, as_uint(limit.y));
    atomic_max(own + 2, as_uint(limit.z));
}

// one atomic for each row of vertices in one cell
__kernel void cluster_warp_points(
    __global const float *restrict positions,
    __global const float *restrict stretch,
    __global float4 *restrict points,
    __global uint *restrict limits,
    const float4 low,
    const float inverse,
    const float edge,    // of the largest cell where the warp stretches nothing
    const float longest, // of the box; no cell is larger
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    if (rows.x >= rows.y) return;

    uint cell = as_uint(points[rows.x].w);
    float3 most = 0.0f;
    for (uint v = rows.x; v < rows.y; ++v) {
        const float3 q = (vload3(v, positions) * low.w - low.xyz) * inverse;
        const float rank = points[v].w;
        points[v] = (float4)(q, rank);
        if (as_uint(rank) != cell) {
            warp_limit(limits, cell, most);
            cell = as_uint(rank);
            most = 0.0f;
        }
        most = max(most, min(vload3(v, stretch) * edge, (float3)(longest)));
    }
    warp_limit(limits, cell, most);
}
