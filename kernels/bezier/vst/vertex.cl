// Vertex shader tessellation: the stored parametric map becomes points and normals of every patch.
//
// Source    Concheiro 2013, chapter 2 (VST); Concheiro et al., GRAPP 2010
// Work      1-D over chunks of output vertices, row after row of the map and patch after patch
// Reads     map        float[8 * map_stride]   as bezier/row.cl has it
//           controls   float[64 * patches]     as bezier/patch.cl has it
// Writes    positions  float[3 * vertices]     packed; patch after patch
//           normals    float[3 * vertices]     packed, unit length; nothing where NORMALS is 0
// Needs     bezier/row.cl
// Plain     bezier/vst/reference.py
// Defines   CHUNK (a multiple of eight), NORMALS (1: normals too), STREAMING (common/packed.cl)

__kernel void vst_vertex(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint side,
    const ulong vertex_count)
{
    const ulong first = (ulong)get_global_id(0) * CHUNK;
    if (first >= vertex_count) return;

    const bezier_map weights = {map, map_stride};
    const uint count = (uint)min((ulong)CHUNK, vertex_count - first), each = side * side;
#if STREAMING
    float points[3 * CHUNK], directions[NORMALS ? 3 * CHUNK : 1];
#else
    __global float *restrict points = positions + 3 * first;
    __global float *restrict directions = normals + 3 * first;
#endif
    ulong p = first / each;
    uint i = (uint)(first - p * each) / side, j = (uint)(first - p * each) % side;
    for (uint done = 0; done < count; ++p, i = 0) {
        bezier_patch patch;
        __global const float *c = controls + CONTROL_FLOATS * p;
        bezier_patch_of(&patch, vload16(0, c), vload16(1, c), vload16(2, c), vload16(3, c));
        for (; i < side && done < count; ++i, j = 0) {
            const uint here = min(side - j, count - done);
            bezier_row row;
            bezier_row_of(&row, &patch, weights, i, NORMALS);
            bezier_points(points + 3 * done, &row, weights, i, j, here, count - done, side);
#if NORMALS
            bezier_normals(directions + 3 * done, &row, &patch, weights, i, j, here, count - done, side);
#endif
            done += here;
        }
    }
#if STREAMING
    bezier_flush(points, count, positions + 3 * first);
    if (NORMALS) bezier_flush(directions, count, normals + 3 * first);
#endif
}
