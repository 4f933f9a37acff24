// Adaptive patterns, vertex stage: the vertices of each coarse triangle's pattern become points and normals.
//
// Source    Boubekeur & Schlick 2007, GPU Gems 3, chapter 5; one launch writes all triangles, whatever their patterns
// Work      1-D over chunks of output vertices, in whole vectors of eight: a chunk may span coarse triangles. Joined after a
//           surface.cl, which says what is evaluated
// Reads     pool       float[2 * pool_stride]     planes of u and v of all patterns, at least eight more than there are
//           records    uint [4 * patterns + 4]    begin of each pattern's vertices, triangles and moves, last row
//           patterns   uint [triangle_count]      of each coarse triangle
//           offsets    uint [triangle_count]      where its vertices begin
//           totals     uint [2]                   vertices and triangles of the frame
//           surface    float[floats * triangles]  as surface.cl has them
//           table      uint []                    of the displacement
//           attributes float[3 * ATTRIBUTES * triangles]  of the displacement, as common/displacement.cl has them
// Writes    positions  float[3 * vertex_room]     packed; coarse triangle after coarse triangle
//           normals    float[3 * vertex_room]     packed, unit length
//           counts     uint [2]                   live vertices and triangles: none where the room does not suffice
// Needs     common/lattice_walk.cl, common/rows.cl
// Plain     refine/adaptive_patterns/reference.py
// Defines   CHUNK (a multiple of eight), DISPLACED (1: by what stands in front), ATTRIBUTES
//           (common/displacement.cl), STREAMING (common/packed.cl)

__kernel void adaptive_patterns_vertex(
    __global const float *restrict pool,
    __global const uint *restrict records,
    __global const uint *restrict patterns,
    __global const uint *restrict offsets,
    __global const uint *restrict totals,
    __global const float *restrict surface,
    __global const uint *restrict table,
    __global const float *restrict attributes,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict counts,
    const float4 displacement, // as the struct has it
    const uint pool_stride,
    const uint triangle_count,
    const uint vertex_room,
    const uint face_room)
{
    const uint vertex_count = totals[0], face_count = totals[1];
    const bool fits = vertex_count <= vertex_room && face_count <= face_room;
    if (get_global_id(0) == 0) vstore2((uint2)(fits ? vertex_count : 0, fits ? face_count : 0), 0, counts);
    ulong v = (ulong)get_global_id(0) * CHUNK;
    if (!fits || v >= vertex_count) return;

    Displacement d = {displacement.x, displacement.y, displacement.z, displacement.w, table};
    const ulong end = v + CHUNK < vertex_count ? v + CHUNK : vertex_count;
    packed_stage stage;
    stage.first = stage.end = 0;
    for (uint t = row_of(offsets, triangle_count, (uint)v); v < end && t < triangle_count; ++t) {
        const uint4 record = vload4(patterns[t], records);
        const uint k = (uint)v - offsets[t];
        const uint count = min(records[4 * (patterns[t] + 1)] - record.x - k, (uint)(end - v));
        const lattice_pattern lattice = {pool + record.x, pool_stride, record.w};
        lattice_surface s;
        lattice_surface_of(&s, surface, t);
        displacement_enter(&d, attributes, t);
        lattice_walk(lattice, &s, d, k, v, count, &stage, positions, normals);
        v += count;
    }
    packed_stage_flush(&stage, end & ~7ul, positions, normals);
}
