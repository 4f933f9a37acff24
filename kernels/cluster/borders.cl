// Vertex clustering, set-up: which edges have a triangle on one side only?
//
// Source    none; an edge that two triangles use in opposite directions cancels out of a sum of hashes
// Work      1-D, one item per chunk of triangles, or of kept vertices
// Reads     triangles   uint[3 * triangle_count]
//           kept        uint[kept_count]           vertices that stay as they are
//           positions   float[3 * vertex_count]    model units
//           new_ranks   uint[capacity]             output vertex of a rank
// Writes    sums        uint[2 * chunk_count]      hashes of the chunk's edges: all chunks add to zero where each
//                                                  edge is used as often in one direction as in the other
//           marks       int[vertex_count]          zero before; other than zero at the ends of an edge that does not cancel
//           chunk_sums  uint[chunk_count]          edges of the chunk between marked vertices
//           edges       uint[3 * edges]            those edges in input order: from, to, the triangle's third corner
//           points      float4[vertex_count]       w: a kept vertex gets the bits of a rank of its own, past those of cells
//           state       uint[4]                    [0]: the kept ones counted too
//           cell_ids    uint[vertex_count]         of a kept vertex a number past those of cells
//           vertices    float[3 * capacity]        a kept vertex where it was, model units
// Needs     common/chunk.cl common/corners.cl

static inline uint8 borders_hash8(const uint8 v)
{
    uint8 x = v * 0x9e3779b1u;
    x = (x ^ (x >> 15)) * 0x2c1b3c6du;
    return x ^ (x >> 13);
}

static inline uint8 borders_rehash8(const uint8 hash)
{
    const uint8 x = hash * 0x297a2d39u + 0x85ebca6bu;
    return x ^ (x >> 16);
}

// An edge from a to b adds g(a) h(b) - g(b) h(a), which the edge from b to a takes away, and one from a to a has none of;
// g and h are hashes of a vertex, and a second sum has g / 2^16.
__kernel void cluster_borders_sum(
    __global const uint *restrict triangles,
    __global uint *restrict sums,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint8 first = 0, second = 0;
    for (uint t = rows.x; t < rows.y; t += 8) {
        const corners8 v = corners_load8(triangles, t, rows.y);
        const uint8 a = borders_hash8(v.a), b = borders_hash8(v.b), c = borders_hash8(v.c);
        const uint8 x = borders_rehash8(a), y = borders_rehash8(b), z = borders_rehash8(c);
        first += a * (y - z) + b * (z - x) + c * (x - y);
        second += (a >> 16) * (y - z) + (b >> 16) * (z - x) + (c >> 16) * (x - y);
    }
    const uint4 x = first.lo + first.hi, y = second.lo + second.hi;
    vstore2((uint2)(x.x + x.y + x.z + x.w, y.x + y.y + y.z + y.w), chunk, sums);
}

static inline int borders_hash(const uint v)
{
    uint x = v * 0x9e3779b1u + 0x85ebca6bu;
    x = (x ^ (x >> 15)) * 0x2c1b3c6du;
    x = (x ^ (x >> 12)) * 0x297a2d39u;
    return (int)(x ^ (x >> 15));
}

__kernel void cluster_borders_mark(
    __global const uint *restrict triangles,
    __global volatile int *restrict marks,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const int a = borders_hash(v.x), b = borders_hash(v.y), c = borders_hash(v.z);
        // each vertex takes the end of the edge that leaves it, less the begin of the one that comes
        atomic_add(marks + v.x, b - c);
        atomic_add(marks + v.y, c - a);
        atomic_add(marks + v.z, a - b);
    }
}

__kernel void cluster_borders_count(
    __global const uint *restrict triangles,
    __global const int *restrict marks,
    __global uint *restrict chunk_sums,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const uint a = marks[v.x] != 0, b = marks[v.y] != 0, c = marks[v.z] != 0;
        count += (a & b) + (b & c) + (c & a);
    }
    chunk_sums[chunk] = count;
}

__kernel void cluster_borders_write(
    __global const uint *restrict triangles,
    __global const int *restrict marks,
    __global const uint *restrict chunk_sums,
    __global uint *restrict edges,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint place = chunk_sum_before(chunk, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const bool a = marks[v.x] != 0, b = marks[v.y] != 0, c = marks[v.z] != 0;
        if (a & b) vstore3((uint3)(v.x, v.y, v.z), place++, edges);
        if (b & c) vstore3((uint3)(v.y, v.z, v.x), place++, edges);
        if (c & a) vstore3((uint3)(v.z, v.x, v.y), place++, edges);
    }
}

#define NO_CELL 0x80000000u // cells are fewer

__kernel void cluster_borders_keep(
    __global const uint *restrict kept,
    __global float4 *restrict points,
    __global uint *restrict state,
    const uint occupied,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) points[kept[i]].w = as_float(occupied + i);
    if (chunk == 0) state[0] += kept_count;
}

__kernel void cluster_borders_keep_ids(
    __global const uint *restrict kept,
    __global uint *restrict cell_ids,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) cell_ids[kept[i]] = NO_CELL + i;
}

__kernel void cluster_borders_return(
    __global const uint *restrict kept,
    __global const float *restrict positions,
    __global const uint *restrict new_ranks,
    __global float *restrict vertices,
    const uint occupied,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) {
        const uint v = new_ranks[occupied + i];
        if (v != 0xFFFFFFFFu) vstore3(vload3(kept[i], positions), v, vertices);
    }
}
