// Adaptive patterns, tags: how deeply does each coarse vertex ask to be refined?
//
// Source    Boubekeur & Schlick 2007, GPU Gems 3, chapter 5 (a depth tag per vertex, by distance, curvature or both): the
//           formulas are a reconstruction
// Work      1-D, one item per coarse vertex
// Reads     positions  float[3 * vertex_count]  model units
//           spans      float[2 * vertex_count]  mean length of the edges around, height of the arcs over them; diagonals
// Writes    tags       float[vertex_count]      0 to finest
// Plain     refine/adaptive_patterns/reference.py
// Defines   BY  0: what lies there already, 1: distance, 2: screen, 3: curvature, 4: the least of 2 and 3

#pragma OPENCL FP_CONTRACT OFF

// within 1e-6; 0 and below give a large negative number
static inline float adaptive_log2(const float x)
{
    const int bits = as_int(max(x, 1e-37f)) - 0x3f3504f3; // counted from the root of a half
    const float m = as_float((bits & 0x007fffff) + 0x3f3504f3), s = (m - 1.0f) / (m + 1.0f), t = s * s;
    const float sum = 1.0f + t * (1.0f / 3.0f + t * (1.0f / 5.0f + t * (1.0f / 7.0f + t * (1.0f / 9.0f))));
    return (float)(bits >> 23) + 2.88539008f * s * sum;
}

__kernel void adaptive_patterns_tags(
    __global const float *restrict positions,
    __global const float *restrict spans,
    __global float *restrict tags,
    const float4 eye,     // model units; w: diagonals up to which all is finest
    const float4 measure, // pixels at distance 1 over those of a segment, 1 / tolerance, 1 with an eye, 1 / diagonal
    const float finest,
    const uint vertex_count)
{
    const uint v = get_global_id(0);
    if (v >= vertex_count) return;

    if (BY == 0) {
        tags[v] = min(max(tags[v], 0.0f), finest);
        return;
    }
    const float3 from = vload3(v, positions) * measure.w - eye.xyz * measure.w;
    const float away = sqrt(max(from.x * from.x + from.y * from.y + from.z * from.z, 1e-37f));
    const bool seen = measure.z > 0.0f;
    float tag = finest;
    if (BY == 1 && seen) tag = finest - adaptive_log2(max(away / eye.w, 1.0f));
    if ((BY == 2 || BY == 4) && seen) tag = adaptive_log2(spans[2 * v] / away * measure.x);
    if (BY == 3 || BY == 4) tag = min(tag, 0.5f * adaptive_log2(spans[2 * v + 1] * measure.y));
    tags[v] = min(max(tag, 0.0f), finest);
}
