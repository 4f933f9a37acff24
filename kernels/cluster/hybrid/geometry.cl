// Hybrid, geometry stage: the triangles whose corners have three labels, as labels; which vertices the mesh uses.
//
// Source    none; what is left of a mesh whose vertices are joined, as in DeCoro & Tatarchuk 2007, slide 16
// Work      1-D, one item per chunk of triangles, which writes to its own rows
// Reads     triangles   uint[3 * triangle_count]
//           labels      uint[vertices]
// Writes    joined      uint[3 * triangle_count]   from a chunk's first row on: labels of its triangles that are left
//           rows        uint[triangle_count]       their numbers
//           bounds      uint[2 * chunk_count]      the first of these rows, and past the last
//           used        uchar[vertices]            1 where a triangle of three vertices has a corner; several items may
//                                                  write the same 1
//           whole       uint[chunk_count]          triangles of three vertices
// Needs     common/chunk.cl
// Plain     cluster/hybrid/reference.py

__kernel void hybrid_geometry_join(
    __global const uint *restrict triangles,
    __global const uint *restrict labels,
    __global uint *restrict joined,
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
        const uint a = labels[v.x], b = labels[v.y], c = labels[v.z];
        vstore3((uint3)(a, b, c), place, joined); // place <= t: overwritten where the triangle is gone
        rows[place] = t;
        place += (a != b) & (b != c) & (c != a);
    }
    vstore2((uint2)(range.x, place), chunk, bounds);
}

__kernel void hybrid_geometry_used(
    __global const uint *restrict triangles,
    __global uchar *restrict used,
    __global uint *restrict whole,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    uint count = 0;
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 v = vload3(t, triangles);
        if (v.x == v.y || v.y == v.z || v.z == v.x) continue;
        used[v.x] = used[v.y] = used[v.z] = 1;
        ++count;
    }
    whole[chunk] = count;
}
