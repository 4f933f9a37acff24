// Adaptive patterns, selection: which pattern does each coarse triangle take, and how much does that have?
//
// Source    Boubekeur & Schlick 2007, GPU Gems 3, chapter 5: an edge's depth is the mean of its ends' tags, rounded up
//           (reconstruction), the same from both sides; the three index the pool
// Work      1-D, one item per coarse triangle
// Reads     triangles  uint [3 * triangle_count]  in the order of the corners
//           tags       float[vertices]            0 to finest
//           records    uint [4 * patterns + 4]    begin of each pattern's vertices, triangles and moves, last row
// Writes    patterns   uint [triangle_count]      number in the pool
//           vertices   uint [triangle_count]      of that pattern
//           faces      uint [triangle_count]      likewise, its triangles
//           blends     float[4 * triangle_count]  how far the finest level has come, 0 to 1, on the edges P1 P2, P2 P0, P0 P1
//                                                 and inside
// Plain     refine/adaptive_patterns/reference.py

#pragma OPENCL FP_CONTRACT OFF

// of its last level, above 0 and up to 1
static inline float adaptive_blend(const float mean, const uint depth) { return depth ? mean - (float)(depth - 1) : 1.0f; }

__kernel void adaptive_patterns_selection(
    __global const uint *restrict triangles,
    __global const float *restrict tags,
    __global const uint *restrict records,
    __global uint *restrict patterns,
    __global uint *restrict vertices,
    __global uint *restrict faces,
    __global float *restrict blends,
    const uint finest,
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count) return;

    const uint side = finest + 1;
    const float a = tags[triangles[3 * t]], b = tags[triangles[3 * t + 1]], c = tags[triangles[3 * t + 2]];
    const float i = 0.5f * (b + c), j = 0.5f * (c + a), k = 0.5f * (a + b);
    const uint di = min((uint)ceil(i), finest), dj = min((uint)ceil(j), finest), dk = min((uint)ceil(k), finest);
    const uint pattern = (di * side + dj) * side + dk;
    patterns[t] = pattern;
    vertices[t] = records[4 * (pattern + 1)] - records[4 * pattern];
    faces[t] = records[4 * (pattern + 1) + 1] - records[4 * pattern + 1];
    const float inside = adaptive_blend(max(max(i, j), k), max(max(di, dj), dk));
    vstore4((float4)(adaptive_blend(i, di), adaptive_blend(j, dj), adaptive_blend(k, dk), inside), t, blends);
}
