// Vertex clustering, set-up: which edges have a triangle on one side only?
//
// Source    none; an edge that two triangles use in opposite directions cancels out of a sum of hashes
// Work      1-D, one item per chunk of triangles, or of vertices; a `mark` with a map for each chunk
//           needs no atomics, which take four times as long on a CPU
// Reads     triangles   uint[3 * triangle_count]
// Writes    sums        uint[2 * chunk_count]      hashes of the chunk's edges: all chunks add to zero where each
//                                                  edge is used as often in one direction as in the other
//           marks       int[map_count * vertex_count]   zero before; the first map, once the others are added to it:
//                                                  other than zero at the ends of an edge that does not cancel
//           chunk_sums  uint[chunk_count]          edges of the chunk between marked vertices
//           edges       uint[3 * edges]            those edges in input order: from, to, the triangle's third corner
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

// each vertex takes the end of the edge that leaves it, less the begin of the one that comes
__kernel void cluster_borders_mark(
    __global const uint *restrict triangles,
    __global int *restrict marks,
    const uint vertex_count,
    const uint map_count,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    if (chunk_count == map_count) {
        __global int *own = marks + (size_t)chunk * vertex_count;
        for (uint t = rows.x; t < rows.y; ++t) {
            const uint3 v = vload3(t, triangles);
            const int a = borders_hash(v.x), b = borders_hash(v.y), c = borders_hash(v.z);
            own[v.x] += b - c;
            own[v.y] += c - a;
            own[v.z] += a - b;
        }
        return;
    }
    __global volatile int *shared = marks;
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const int a = borders_hash(v.x), b = borders_hash(v.y), c = borders_hash(v.z);
        atomic_add(shared + v.x, b - c);
        atomic_add(shared + v.y, c - a);
        atomic_add(shared + v.z, a - b);
    }
}

__kernel void cluster_borders_join(
    __global int *restrict marks,
    const uint vertex_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint map = 1; map < map_count; ++map) {
        __global const int *other = marks + (size_t)map * vertex_count;
        for (uint v = rows.x; v < rows.y; ++v) marks[v] += other[v];
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
