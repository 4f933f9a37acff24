// A refined mesh stored in full, vertex stage: stored points and normals pass through to the output.
//
// Source    Boubekeur & Schlick 2005, section 5 (the "Static VBO" rows of figure 7)
// Work      1-D over chunks of output vertices, whole vectors of eight and a rest that only the last chunk has
// Reads     stored_positions  float[3 * vertices]  packed, model units
//           stored_normals    float[3 * vertices]  packed, unit length
// Writes    positions         float[3 * vertices]
//           normals           float[3 * vertices]
// Needs     common/packed.cl
// Plain     refine/static_vbo/reference.py
// Defines   CHUNK (a multiple of eight), STREAMING (common/packed.cl)

__kernel void static_vbo_vertex(
    __global const float *restrict stored_positions,
    __global const float *restrict stored_normals,
    __global float *restrict positions,
    __global float *restrict normals,
    const ulong vertex_count)
{
    const ulong first = (ulong)get_global_id(0) * CHUNK;
    if (first >= vertex_count) return;

    const size_t begin = 3 * first;
    const uint count = 3 * (uint)(vertex_count - first < CHUNK ? vertex_count - first : CHUNK);
    const uint whole = count & ~7u;
    // one stream of stores at a time: whole cache lines leave the core
    for (uint f = 0; f < whole; f += 8) PACKED_STORE(vload8(0, stored_positions + begin + f), positions + begin + f);
    for (uint f = 0; f < whole; f += 8) PACKED_STORE(vload8(0, stored_normals + begin + f), normals + begin + f);
    for (uint f = whole; f < count; ++f) {
        positions[begin + f] = stored_positions[begin + f];
        normals[begin + f] = stored_normals[begin + f];
    }
}
