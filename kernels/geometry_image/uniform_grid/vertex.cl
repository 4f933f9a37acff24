// A geometry image drawn in the same detail everywhere, vertex stage: what is stored is passed through.
//
// Source    Gu, Gortler & Hoppe 2002, section 1 (a geometry image's mip levels are its levels of detail)
// Work      1-D, one item per CHUNK floats; items past float_count return at once
// Reads     stored_positions  float[float_count]   packed x y z
//           stored_normals    float[float_count]
// Writes    positions         float[float_count]
//           normals           float[float_count]
// Plain     geometry_image/uniform_grid/reference.py
// Defines   CHUNK   floats of one item, a multiple of 16

__kernel void uniform_grid_vertex(
    __global const float *restrict stored_positions,
    __global const float *restrict stored_normals,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint float_count)
{
    const uint first = get_global_id(0) * CHUNK;
    if (first >= float_count) return;

    uint k = first;
    if (first + CHUNK <= float_count) {
        for (; k < first + CHUNK; k += 16) {
            vstore16(vload16(0, stored_positions + k), 0, positions + k);
            vstore16(vload16(0, stored_normals + k), 0, normals + k);
        }
        return;
    }
    for (; k < float_count; ++k) {
        positions[k] = stored_positions[k];
        normals[k] = stored_normals[k];
    }
}
