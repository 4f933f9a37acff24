// Which triangles of the input are left, by the map of its vertices: those whose corners went to three vertices.
//
// Source    none
// Work      1-D, one item per chunk of triangles, which writes to its own rows
// Reads     triangles    uint[3 * triangle_count]
//           vertex_map   uint[vertices]              output vertex, 0xFFFFFFFF where there is none
// Writes    rows         uint[triangle_count]        from a chunk's first row on: its triangles that are left
//           bounds       uint[2 * chunk_count]       the first of these rows, and past the last
// Needs     common/chunk.cl

__kernel void cluster_sources(
    __global const uint *restrict triangles,
    __global const uint *restrict vertex_map,
    __global uint *restrict rows,
    __global uint *restrict bounds,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    uint place = range.x;
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const uint a = vertex_map[v.x], b = vertex_map[v.y], c = vertex_map[v.z];
        rows[place] = t; // place <= t: overwritten where the triangle is gone
        place += (a != b) & (b != c) & (c != a) & (max(a, max(b, c)) != 0xFFFFFFFFu);
    }
    vstore2((uint2)(range.x, place), chunk, bounds);
}
