// Adaptive patterns, selection: which pattern does each coarse triangle take, and where do its vertices and triangles go?
//
// Source    Boubekeur & Schlick 2007, GPU Gems 3, chapter 5: an edge's depth is the mean of its ends' tags, rounded up
//           (reconstruction), the same from both sides; the three index the pool
// Work      1-D, one item per chunk of coarse triangles, which sums as it goes; a single chunk needs no second pass
// Reads     triangles   uint [3 * triangle_count]  in the order of the corners
//           tags        float[vertices]            0 to finest
//           records     uint [4 * patterns + 4]    begin of each pattern's vertices, triangles and moves, last row
// Writes    patterns    uint [triangle_count]      number in the pool
//           offsets     uint [triangle_count]      where its vertices begin
//           starts      uint [triangle_count]      where its triangles begin
//           blends      float[4 * triangle_count]  how far the finest level has come, 0 to 1, on the edges P1 P2, P2 P0, P0 P1
//                                                  and inside
//           chunk_sums  uint [2 * chunk_count]     vertices and triangles of each chunk
//           totals      uint [2]                   of all
// Needs     common/chunk.cl
// Plain     refine/adaptive_patterns/reference.py

#pragma OPENCL FP_CONTRACT OFF

// of its last level, above 0 and up to 1
static inline float adaptive_blend(const float mean, const uint depth) { return depth ? mean - (float)(depth - 1) : 1.0f; }

__kernel void adaptive_patterns_selection(
    __global const uint *restrict triangles,
    __global const float *restrict tags,
    __global const uint *restrict records,
    __global uint *restrict patterns,
    __global uint *restrict offsets,
    __global uint *restrict starts,
    __global float *restrict blends,
    __global uint *restrict chunk_sums,
    __global uint *restrict totals,
    const uint finest,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint side = finest + 1;
    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    uint2 sum = (uint2)(0);
    for (uint t = rows.x; t < rows.y; ++t) {
        const float a = tags[triangles[3 * t]], b = tags[triangles[3 * t + 1]], c = tags[triangles[3 * t + 2]];
        const float i = 0.5f * (b + c), j = 0.5f * (c + a), k = 0.5f * (a + b);
        const uint di = min((uint)ceil(i), finest), dj = min((uint)ceil(j), finest), dk = min((uint)ceil(k), finest);
        const uint pattern = (di * side + dj) * side + dk;
        patterns[t] = pattern;
        offsets[t] = sum.x;
        starts[t] = sum.y;
        sum += vload2(0, records + 4 * (pattern + 1)) - vload2(0, records + 4 * pattern);
        const float inside = adaptive_blend(max(max(i, j), k), max(max(di, dj), dk));
        vstore4((float4)(adaptive_blend(i, di), adaptive_blend(j, dj), adaptive_blend(k, dk), inside), t, blends);
    }
    vstore2(sum, chunk, chunk_sums);
    if (chunk_count == 1) vstore2(sum, 0, totals);
}

__kernel void adaptive_patterns_selection_join(
    __global const uint *restrict chunk_sums,
    __global uint *restrict offsets,
    __global uint *restrict starts,
    __global uint *restrict totals,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint2 before = (uint2)(0);
    for (uint c = 0; c < chunk; ++c) before += vload2(c, chunk_sums);
    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = rows.x; t < rows.y; ++t) {
        offsets[t] += before.x;
        starts[t] += before.y;
    }
    if (chunk == chunk_count - 1) vstore2(before + vload2(chunk, chunk_sums), 0, totals);
}
