// Adaptive patterns, geomorphing: the vertices of the finest level come out of the middle between those they arise from.
//
// Source    Boubekeur & Schlick 2005, section 6, names it as future work: a reconstruction. A vertex on an edge moves by
//           the edge's own depth, the same from both sides; inside, by the largest depth
// Work      1-D, one item per coarse triangle; edges come first in a pattern's moves, since what lies inside may arise between
// Reads     moves      uint [2 * pool's moves]    in 16 bits each: a vertex, the two that it lies between, edge or 3
//           records    uint [4 * patterns + 4]    begin of each pattern's vertices, triangles and moves, last row
//           patterns   uint [triangle_count]      of each coarse triangle
//           offsets    uint [triangle_count]      where its vertices begin
//           blends     float[4 * triangle_count]  0 to 1, of the three edges and inside
//           counts     uint [2]                   live vertices and triangles
// Writes    positions  float[3 * room]            in place
//           normals    float[3 * room]            in place, unit length
// Plain     refine/adaptive_patterns/reference.py

#pragma OPENCL FP_CONTRACT OFF

// sums of two that do not depend on their order: edges come out alike from both sides
static inline float3 morph_between(const float3 a, const float3 b, const float3 own, const float blend)
{
    const float3 middle = (a + b) * 0.5f;
    return middle + (own - middle) * blend;
}

__kernel void adaptive_patterns_morph(
    __global const uint *restrict moves,
    __global const uint *restrict records,
    __global const uint *restrict patterns,
    __global const uint *restrict offsets,
    __global const float *restrict blends,
    __global const uint *restrict counts,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count || !counts[0]) return;

    const uint first = records[4 * patterns[t] + 2], last = records[4 * (patterns[t] + 1) + 2];
    __global float *p = positions + 3 * (size_t)offsets[t], *n = normals + 3 * (size_t)offsets[t];
    for (uint m = first; m < last; ++m) {
        const uint2 move = vload2(m, moves);
        const uint own = move.x & 0xffff, one = move.x >> 16, other = move.y & 0xffff;
        const float blend = blends[4 * t + (move.y >> 16)];
        if (blend >= 1.0f) continue;
        vstore3(morph_between(vload3(one, p), vload3(other, p), vload3(own, p), blend), own, p);
        const float3 sum = morph_between(vload3(one, n), vload3(other, n), vload3(own, n), blend);
        const float square = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
        if (square > 1e-30f) vstore3(sum * (1.0f / sqrt(square)), own, n);
    }
}
