// Generic mesh refinement, vertex stage: the pattern's vertices become points and normals of one coarse triangle.
//
// Source    Boubekeur & Schlick 2005, section 3.2 (barycentric pattern), section 4 (a sin(f |P|), in common/displacement.cl)
// Work      1-D over chunks of output vertices, in whole vectors of eight; the triangle's attributes are arguments
// Reads     pattern     float[2 * pattern_stride]         planes of u and v, 0..1, at least eight more than pattern_vertices
//           table       uint []                           of the displacement
//           attributes  float[3 * ATTRIBUTES * triangles]  of the displacement, as common/displacement.cl has them
// Writes    positions   float[3 * vertices]               packed; instance after instance
//           normals     float[3 * vertices]               packed, unit length
// Needs     refine/pattern/surface.cl, common/lattice_walk.cl
// Plain     refine/pattern/reference.py
// Defines   CHUNK (a multiple of eight), DISPLACED (1: a height such as common/sine.cl stands in front), ATTRIBUTES
//           (common/displacement.cl), STREAMING (common/packed.cl)

__kernel void pattern_vertex_single(
    __global const float *restrict pattern,
    __global const uint *restrict table,
    __global const float *restrict attributes,
    __global float *restrict positions,
    __global float *restrict normals,
    const float4 p0, // fourth lane: 1 where edge P1 P2 begins at P2
    const float4 p1,
    const float4 p2,
    const float4 n0,
    const float4 n1,
    const float4 n2,
    const float4 displacement,
    const uint pattern_stride,
    const uint last_row,
    const uint triangle,      // whose attributes these are
    const ulong first_vertex, // of the output: the pattern's vertex 0
    const uint pattern_vertices)
{
    const ulong end = first_vertex + pattern_vertices;
    const ulong chunk = (first_vertex / CHUNK + get_global_id(0)) * CHUNK;
    if (chunk >= end) return;

    const lattice_pattern lattice = {pattern, pattern_stride, last_row};
    Displacement d = {displacement.x, displacement.y, displacement.z, displacement.w, table};
    displacement_enter(&d, attributes, triangle);
    const ulong v = chunk > first_vertex ? chunk : first_vertex;
    const uint count = (uint)((chunk + CHUNK < end ? chunk + CHUNK : end) - v);
    const lattice_surface s = {p0.xyz, p1.xyz, p2.xyz, n0.xyz, n1.xyz, n2.xyz, p0.w > 0.0f};
    packed_stage stage;
    stage.first = stage.end = v & 7;
    lattice_walk(lattice, &s, d, (uint)(v - first_vertex), v, count, &stage, positions, normals);
    packed_stage_flush(&stage, (v + count) & ~7ul, positions, normals);
}
