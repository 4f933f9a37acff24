// Generic mesh refinement, vertex stage: the pattern's vertices become points and normals of every coarse triangle.
//
// Source    Boubekeur & Schlick 2005, section 3.2 (barycentric pattern), section 4 (a sin(f |P|), in common/wave.cl)
// Work      1-D over chunks of output vertices, in whole vectors of eight: a chunk may span coarse triangles, which keeps
//           every vector aligned; `_batched` for all triangles at once, `_single` for one whose attributes are arguments
// Reads     pattern    float[2 * pattern_stride]  planes of u and v, 0..1, at least eight more than pattern_vertices
//           corners    float[19 * triangles]      P0 P1 P2 N0 N1 N2, 1 where edge P1 P2 begins at P2; model units.
//                                                 Edges begin at their end of lower number, hence P0 is the lowest
// Writes    positions  float[3 * vertices]        packed; instance after instance
//           normals    float[3 * vertices]        packed, unit length
// Needs     common/packed.cl, common/wave.cl
// Defines   CHUNK (a multiple of eight), DISPLACED (1: sine displacement), STREAMING (common/packed.cl)

#pragma OPENCL FP_CONTRACT OFF

typedef struct {
    float3 p0, p1, p2, n0, n1, n2;
    bool from_p2;
} coarse_triangle;

// the edge from a to b at t, by the same sum as planes8_span makes on the edges at P0, and exact at b
static inline planes8 pattern_edge(const float8 t, const float3 a, const float3 b)
{
    planes8 end;
    end.x = (float8)(b.x);
    end.y = (float8)(b.y);
    end.z = (float8)(b.z);
    return planes8_pick(t == 1.0f, end, planes8_span(t, (float8)(0.0f), a, b - a, (float3)(0.0f)));
}

// eight vertices from the pattern's k on, some of which may be of the row P1 .. P2 that begins at `last_row`
static inline void pattern_eight(
    __global const float *restrict pattern,
    const coarse_triangle *c,
    const float4 wave,
    const uint pattern_stride,
    const uint last_row,
    const uint k,
    planes8 *p,
    planes8 *n)
{
    const float8 u = vload8(0, pattern + k), v = vload8(0, pattern + pattern_stride + k);
    const int8 is_last = (int8)(k) + (int8)(0, 1, 2, 3, 4, 5, 6, 7) >= (int8)(last_row);
    const float8 t = c->from_p2 ? u : v;
    const planes8 edge_p = pattern_edge(t, c->from_p2 ? c->p2 : c->p1, c->from_p2 ? c->p1 : c->p2);
    const planes8 edge_n = pattern_edge(t, c->from_p2 ? c->n2 : c->n1, c->from_p2 ? c->n1 : c->n2);
    *p = planes8_pick(is_last, edge_p, planes8_span(u, v, c->p0, c->p1 - c->p0, c->p2 - c->p0));
    *n = planes8_pick(is_last, edge_n, planes8_span(u, v, c->n0, c->n1 - c->n0, c->n2 - c->n0));
    *n = planes8_normalise(*n);
#if DISPLACED
    float8 height, steep;
    wave_phase(*p, wave, &height, &steep);
    wave_height(&height, &steep, wave);
    const planes8 flat_n = *n;
    *n = wave_tilted(*p, flat_n, steep, wave);
    *p = wave_raised(*p, flat_n, height);
#endif
}

// whole vectors before the last row: `positions`, `normals` and `pattern` at the first, `count` vertices
static inline void pattern_inside(
    __global const float *restrict pattern,
    __global float *restrict positions,
    __global float *restrict normals,
    const coarse_triangle *c,
    const float4 wave,
    const uint pattern_stride,
    const uint count)
{
    const float3 p0 = c->p0, p1 = c->p1 - c->p0, p2 = c->p2 - c->p0;
    const float3 n0 = c->n0, n1 = c->n1 - c->n0, n2 = c->n2 - c->n0;
    const uint vectors = count / 8;
#if DISPLACED
    planes8 n[CHUNK / 8];
    float8 height[CHUNK / 8], steep[CHUNK / 8];
    for (uint i = 0; i < vectors; ++i) {
        const float8 u = vload8(i, pattern), v = vload8(i, pattern + pattern_stride);
        n[i] = planes8_normalise(planes8_span(u, v, n0, n1, n2));
        wave_phase(planes8_span(u, v, p0, p1, p2), wave, &height[i], &steep[i]);
    }
    for (uint i = 0; i < vectors; ++i) wave_height(&height[i], &steep[i], wave);
#endif
    // one stream of stores at a time: whole cache lines leave the core
    for (uint i = 0; i < vectors; ++i) {
        const float8 u = vload8(i, pattern), v = vload8(i, pattern + pattern_stride);
        planes8 p = planes8_span(u, v, p0, p1, p2);
#if DISPLACED
        p = wave_raised(p, n[i], height[i]);
#endif
        packed_store8(p, positions + 24 * i);
    }
    for (uint i = 0; i < vectors; ++i) {
        const float8 u = vload8(i, pattern), v = vload8(i, pattern + pattern_stride);
#if DISPLACED
        const planes8 out = wave_tilted(planes8_span(u, v, p0, p1, p2), n[i], steep[i], wave);
#else
        const planes8 out = planes8_normalise(planes8_span(u, v, n0, n1, n2));
#endif
        packed_store8(out, normals + 24 * i);
    }
}

// `count` output vertices from v on, of one triangle; v is the pattern's vertex k
static inline void pattern_vertices_of(
    __global const float *restrict pattern,
    __global float *restrict positions,
    __global float *restrict normals,
    const coarse_triangle *c,
    const float4 wave,
    const uint pattern_stride,
    const uint last_row,
    const uint k,
    const ulong v,
    const uint count,
    packed_stage *stage)
{
    const uint to_vector = min(count, -(uint)v & 7u);
    const uint before = min(count, last_row - min(k, last_row));
    const uint inside = before > to_vector ? (before - to_vector) & ~7u : 0;
    if (inside) {
        const ulong at = 3 * (v + to_vector);
        pattern_inside(pattern + k + to_vector, positions + at, normals + at, c, wave, pattern_stride, inside);
    }
    // what is left: before the first whole vector, and after the last
    uint at = to_vector ? 0 : inside;
    while (at < count) {
        const uint taken = min(8 - ((uint)(v + at) & 7), count - at);
        planes8 p, n;
        pattern_eight(pattern, c, wave, pattern_stride, last_row, k + at, &p, &n);
        packed_stage_put(stage, p, n, taken, v + at, positions, normals);
        at += at < to_vector ? taken + inside : taken;
    }
}

__kernel void pattern_vertex_batched(
    __global const float *restrict pattern,
    __global const float *restrict corners,
    __global float *restrict positions,
    __global float *restrict normals,
    const float4 wave,
    const uint pattern_stride,
    const uint last_row,
    const uint first_triangle, // of corners: the one that writes vertex 0
    const uint pattern_vertices,
    const ulong vertex_count)
{
    ulong v = (ulong)get_global_id(0) * CHUNK;
    if (v >= vertex_count) return;

    const ulong end = v + CHUNK < vertex_count ? v + CHUNK : vertex_count;
    packed_stage stage;
    stage.first = stage.end = 0;
    while (v < end) {
        const ulong t = v / pattern_vertices;
        const uint k = (uint)(v - t * pattern_vertices);
        const uint count = min(pattern_vertices - k, (uint)(end - v));
        __global const float *a = corners + 19 * (first_triangle + (size_t)t);
        const coarse_triangle c = {vload3(0, a), vload3(1, a), vload3(2, a), vload3(3, a), vload3(4, a), vload3(5, a),
            a[18] > 0.0f};
        pattern_vertices_of(pattern, positions, normals, &c, wave, pattern_stride, last_row, k, v, count, &stage);
        v += count;
    }
    packed_stage_flush(&stage, end & ~7ul, positions, normals);
}

__kernel void pattern_vertex_single(
    __global const float *restrict pattern,
    __global float *restrict positions,
    __global float *restrict normals,
    const float4 p0, // fourth lane: 1 where edge P1 P2 begins at P2
    const float4 p1,
    const float4 p2,
    const float4 n0,
    const float4 n1,
    const float4 n2,
    const float4 wave,
    const uint pattern_stride,
    const uint last_row,
    const ulong first_vertex, // of the output: the pattern's vertex 0
    const uint pattern_vertices)
{
    const ulong end = first_vertex + pattern_vertices;
    const ulong chunk = (first_vertex / CHUNK + get_global_id(0)) * CHUNK;
    if (chunk >= end) return;

    const ulong v = chunk > first_vertex ? chunk : first_vertex;
    const uint count = (uint)((chunk + CHUNK < end ? chunk + CHUNK : end) - v);
    const coarse_triangle c = {p0.xyz, p1.xyz, p2.xyz, n0.xyz, n1.xyz, n2.xyz, p0.w > 0.0f};
    packed_stage stage;
    stage.first = stage.end = v & 7;
    const uint k = (uint)(v - first_vertex);
    pattern_vertices_of(pattern, positions, normals, &c, wave, pattern_stride, last_row, k, v, count, &stage);
    packed_stage_flush(&stage, (v + count) & ~7ul, positions, normals);
}
