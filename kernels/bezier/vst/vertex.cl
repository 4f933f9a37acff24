// Vertex shader tessellation: the stored parametric map becomes points and normals of every patch.
//
// Source    Concheiro 2013, chapter 2 (VST); Concheiro et al., GRAPP 2010
// Work      1-D over chunks of output vertices, row after row of the map and patch after patch; whole blocks of rows are
//           the fastest
// Reads     map        float[8 * map_stride]   as bezier/row.cl has it
//           controls   float[64 * patches]     as bezier/patch.cl has it
//           levels     uint [patches]          of the patches, where each has its own
//           offsets    uint [patches]          and where its vertices begin
// Writes    positions  float[3 * vertices]     packed; patch after patch
//           normals    float[3 * vertices]     packed, unit length; nothing where NORMALS is 0
// Needs     bezier/row.cl
// Plain     bezier/vst/reference.py
// Defines   CHUNK (the longest chunk, where STREAMING), NORMALS (1: normals too), STREAMING (common/output.cl)

__kernel void vst_vertex(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint side,
    const uint chunk, // a multiple of eight
    const ulong vertex_count)
{
    const ulong first = (ulong)get_global_id(0) * chunk;
    if (first >= vertex_count) return;

    const bezier_map weights = {map, map_stride};
    const uint count = (uint)min((ulong)chunk, vertex_count - first), each = side * side;
    OUTPUT_BEGIN(points, CHUNK, positions + 3 * first);
    OUTPUT_BEGIN(directions, NORMALS ? CHUNK : 1, normals + (NORMALS ? 3 * first : 0));
    ulong p = first / each;
    uint vertex = (uint)(first - p * each);
    for (uint done = 0; done < count; ++p, vertex = 0) {
        bezier_patch patch;
        bezier_patch_at(&patch, controls, p);
        done += bezier_rows(
            points + 3 * done, directions + (NORMALS ? 3 * done : 0), &patch, weights, vertex, count - done, side);
    }
    OUTPUT_END(points, count, positions + 3 * first);
#if NORMALS
    OUTPUT_END(directions, count, normals + 3 * first);
#endif
}

#if !STREAMING // rows go where a patch's vertices begin, not to a chunk of a work-item's own

// the patches that have this level
__kernel void vst_vertex_levels(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint level,
    const uint blocks, // of rows, of a patch
    const uint patch_count)
{
    const uint p = get_global_id(0) / blocks;
    if (p >= patch_count || levels[p] != level) return;

    const bezier_map weights = {map, map_stride};
    bezier_patch patch;
    bezier_patch_at(&patch, controls, p);
    bezier_block_rows(positions, normals, &patch, weights, offsets[p], get_global_id(0) % blocks, (1u << level) + 1);
}
#endif
