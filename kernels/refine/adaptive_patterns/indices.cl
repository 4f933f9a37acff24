// Adaptive patterns, indices: the triangles of each coarse triangle's pattern, by the numbers of their output vertices.
//
// Source    Boubekeur & Schlick 2007, GPU Gems 3, chapter 5: an index range per pattern. There the range is bound for each
//           draw; here the lists are written one after the other, so that a frame is one draw
// Work      1-D over chunks of output triangles: a chunk may span coarse triangles
// Reads     lists      uint[3 * pool's triangles]  of all patterns, by place in the pattern's own vertices
//           records    uint[4 * patterns + 4]      begin of each pattern's vertices, triangles and moves, last row
//           patterns   uint[triangle_count]        of each coarse triangle
//           offsets    uint[triangle_count]        where its vertices begin
//           starts     uint[triangle_count]        where its triangles begin
//           counts     uint[2]                     live vertices and triangles
// Writes    triangles  uint[3 * room]
// Needs     common/rows.cl
// Plain     refine/adaptive_patterns/reference.py
// Defines   CHUNK  triangles of a work-item

__kernel void adaptive_patterns_indices(
    __global const uint *restrict lists,
    __global const uint *restrict records,
    __global const uint *restrict patterns,
    __global const uint *restrict offsets,
    __global const uint *restrict starts,
    __global const uint *restrict counts,
    __global uint *restrict triangles,
    const uint triangle_count)
{
    ulong f = (ulong)get_global_id(0) * CHUNK;
    if (f >= counts[1]) return;

    const ulong end = f + CHUNK < counts[1] ? f + CHUNK : counts[1];
    for (uint t = row_of(starts, triangle_count, (uint)f); f < end && t < triangle_count; ++t) {
        const uint first = records[4 * patterns[t] + 1], last = records[4 * (patterns[t] + 1) + 1];
        const uint k = (uint)f - starts[t], base = offsets[t];
        const uint words = 3 * min(last - first - k, (uint)(end - f));
        __global const uint *restrict from = lists + 3 * (size_t)(first + k);
        __global uint *restrict to = triangles + 3 * f;
        uint w = 0;
        for (; w + 8 <= words; w += 8) vstore8(vload8(0, from + w) + base, 0, to + w);
        for (; w < words; ++w) to[w] = from[w] + base;
        f += words / 3;
    }
}
