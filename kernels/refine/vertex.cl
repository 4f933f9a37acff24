// Refinement by patterns, vertex stage: the pattern's vertices become points and normals of every coarse triangle.
//
// Source    Boubekeur & Schlick 2005, section 3.2 (barycentric pattern), section 4 (displacement)
// Work      1-D over chunks of output vertices, in whole vectors of eight: a chunk may span coarse triangles, which keeps
//           every vector aligned. Joined after a system's surface.cl, which says what is evaluated
// Reads     pattern     float[2 * pattern_stride]         planes of u and v, 0..1, at least eight more than pattern_vertices
//           surface     float[floats * triangles]         as surface.cl has them
//           table       uint []                           of the displacement
//           attributes  float[3 * ATTRIBUTES * triangles]  of the displacement, as common/displacement.cl has them
// Writes    positions   float[3 * vertices]               packed; instance after instance
//           normals     float[3 * vertices]               packed, unit length
// Needs     common/lattice_walk.cl
// Plain     refine/reference.py
// Defines   CHUNK (a multiple of eight), DISPLACED (1: a height such as common/sine.cl stands in front), ATTRIBUTES
//           (common/displacement.cl), STREAMING (common/packed.cl)

__kernel void refine_vertex(
    __global const float *restrict pattern,
    __global const float *restrict surface,
    __global const uint *restrict table,
    __global const float *restrict attributes,
    __global float *restrict positions,
    __global float *restrict normals,
    const float4 displacement, // as the struct has it
    const uint pattern_stride,
    const uint last_row,
    const uint first_triangle, // of the surface: the one that writes vertex 0
    const uint pattern_vertices,
    const ulong vertex_count)
{
    ulong v = (ulong)get_global_id(0) * CHUNK;
    if (v >= vertex_count) return;

    const lattice_pattern lattice = {pattern, pattern_stride, last_row};
    Displacement d = {displacement.x, displacement.y, displacement.z, displacement.w, table};
    const ulong end = v + CHUNK < vertex_count ? v + CHUNK : vertex_count;
    packed_stage stage;
    stage.first = stage.end = 0;
    while (v < end) {
        const ulong t = v / pattern_vertices;
        const uint k = (uint)(v - t * pattern_vertices);
        const uint count = min(pattern_vertices - k, (uint)(end - v));
        lattice_surface s;
        lattice_surface_of(&s, surface, first_triangle + (size_t)t);
        displacement_enter(&d, attributes, first_triangle + (size_t)t);
        lattice_walk(lattice, &s, d, k, v, count, &stage, positions, normals);
        v += count;
    }
    packed_stage_flush(&stage, end & ~7ul, positions, normals);
}
