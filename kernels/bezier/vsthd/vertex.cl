// Vertex shader tessellation on a handheld device: one draw of a few patches, whose control points lie in one memory or
// another.
//
// Source    Concheiro 2013, chapter 5 (uniform and texture VSTHD); WSCG 2013
// Work      1-D over chunks of the draw's vertices, row after row of the map and patch after patch
// Reads     map        float[8 * map_stride]   as bezier/row.cl has it
//           uniforms   float[64 * N_d]         as bezier/patch.cl has it, of the draw's patches
//           texels     image[16 * patches]     the same as a texture, a row for each patch
//           controls   float[64 * patches]     the same of all patches
//           levels     uint [patches]          of the patches, where each has its own
//           offsets    uint [patches]          and where its vertices begin
// Writes    positions  float[3 * vertices]     packed; patch after patch
//           normals    float[3 * vertices]     packed, unit length; nothing where NORMALS is 0
// Needs     bezier/row.cl
// Plain     bezier/vsthd/reference.py
// Defines   CHUNK (a multiple of eight), NORMALS (1: normals too), STREAMING (0: a draw begins where the last one ended)

__constant sampler_t vsthd_texel = CLK_NORMALIZED_COORDS_FALSE | CLK_ADDRESS_CLAMP_TO_EDGE | CLK_FILTER_NEAREST;

// the draw's vertices of one work-item; PATCH(k, row) is row `row` of the draw's patch k
#define VSTHD_DRAW(PATCH)                                                                                              \
    const uint first = get_global_id(0) * CHUNK;                                                                       \
    if (first >= vertex_count) return;                                                                                 \
    const bezier_map weights = {map, map_stride};                                                                      \
    const uint count = min((uint)CHUNK, vertex_count - first), each = side * side;                                     \
    __global float *restrict points = positions + 3 * ((size_t)first_patch * each + first);                            \
    __global float *restrict directions = normals + (NORMALS ? 3 * ((size_t)first_patch * each + first) : 0);          \
    uint k = first / each, vertex = first % each;                                                                      \
    for (uint done = 0; done < count; ++k, vertex = 0) {                                                               \
        bezier_patch patch;                                                                                            \
        bezier_patch_of(&patch, PATCH(k, 0), PATCH(k, 1), PATCH(k, 2), PATCH(k, 3));                                   \
        done += bezier_rows(                                                                                           \
            points + 3 * done, directions + (NORMALS ? 3 * done : 0), &patch, weights, vertex, count - done, side);    \
    }

// the same of the patches that have this level, each where its vertices begin
#define VSTHD_LEVELS(PATCH)                                                                                            \
    const uint k = get_global_id(0) / blocks;                                                                          \
    if (k >= patch_count || levels[first_patch + k] != level) return;                                                  \
    const bezier_map weights = {map, map_stride};                                                                      \
    bezier_patch patch;                                                                                                \
    bezier_patch_of(&patch, PATCH(k, 0), PATCH(k, 1), PATCH(k, 2), PATCH(k, 3));                                       \
    bezier_block_rows(                                                                                                 \
        positions, normals, &patch, weights, offsets[first_patch + k], get_global_id(0) % blocks, (1u << level) + 1);

#define IN_UNIFORMS(k, row) vload16(4 * (k) + row, uniforms)
#define IN_CONTROLS(k, row) vload16(4 * (size_t)(first_patch + (k)) + row, controls)
#define TEXEL(k, column) read_imagef(texels, vsthd_texel, (int2)(column, (int)(first_patch + (k))))
#define IN_TEXELS(k, row)                                                                                              \
    (float16)(TEXEL(k, 4 * row), TEXEL(k, 4 * row + 1), TEXEL(k, 4 * row + 2), TEXEL(k, 4 * row + 3))

__kernel void vsthd_vertex_uniform(
    __global const float *restrict map,
    __constant float *uniforms,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint side,
    const uint first_patch,
    const uint vertex_count) // of the draw
{
    VSTHD_DRAW(IN_UNIFORMS)
}

__kernel void vsthd_vertex_texture(
    __global const float *restrict map,
    read_only image2d_t texels,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint side,
    const uint first_patch,
    const uint vertex_count) // of the draw
{
    VSTHD_DRAW(IN_TEXELS)
}

__kernel void vsthd_vertex_global(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint side,
    const uint first_patch,
    const uint vertex_count) // of the draw
{
    VSTHD_DRAW(IN_CONTROLS)
}

__kernel void vsthd_vertex_levels_uniform(
    __global const float *restrict map,
    __constant float *uniforms,
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint level,
    const uint blocks, // of rows, of a patch
    const uint first_patch,
    const uint patch_count) // of the draw
{
    VSTHD_LEVELS(IN_UNIFORMS)
}

__kernel void vsthd_vertex_levels_texture(
    __global const float *restrict map,
    read_only image2d_t texels,
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint level,
    const uint blocks, // of rows, of a patch
    const uint first_patch,
    const uint patch_count) // of the draw
{
    VSTHD_LEVELS(IN_TEXELS)
}

__kernel void vsthd_vertex_levels_global(
    __global const float *restrict map,
    __global const float *restrict controls,
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint map_stride,
    const uint level,
    const uint blocks, // of rows, of a patch
    const uint first_patch,
    const uint patch_count) // of the draw
{
    VSTHD_LEVELS(IN_CONTROLS)
}
