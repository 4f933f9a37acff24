// The sampler's first half: how many KSDices each KSQuad gets, by the lengths of curves across it on the screen.
//
// Source    Concheiro 2013, section 6.3 (a KSDice covers so many pixels); lengths by five points are a reconstruction
// Work      lengths: 1-D, one item per octet of KSQuads, of which none that stays is near returning at once; sizes: 1-D,
//           each item as many of the KSQuads that stay
// Reads     octets    uint [8 * octet_count]  as nurbs/rpns/geometry.cl has them
//           quads     uint [16 * quad_count]  surface, first control point, span records of u and v, four edges: twice the
//                                             edge's number, 1: it runs the other way; first corner, and corners of a row,
//                                             1: on a surface's border
//           edges     uint [8 * edge_count]   surface, first control point, span record across and along, 1: it runs along u,
//                                             lane of `fives` that it lies at, and of those on a surface's border whether
//                                             other surfaces share it, or it collapsed to a point
//           surfaces  uint [16 * surfaces]    as nurbs/surface.cl has them
//           firsts    uint [records]          as nurbs/rpns/geometry.cl has them
//           controls  float[4 * controls]     as nurbs/surface.cl has them
//           fives     float[64 * records]     as nurbs/rpns/curves.cl has them
//           places    float[5 * 8 * stride]   as nurbs/rpns/lengths.cl has them
//           flags     uchar[quads]            1: the KSQuad stays
//           kept      uint [quads]            KSQuads that stay, in order
//           total     uint [1]                how many
// Writes    factors   float[4 * edge_count]   segments, and breaks as nurbs/rpns/curves.cl has them; a surface's edges at
//                                             knots of u go row after row, then those at knots of v column after column
//           middles   float[8 * quads]        the same of each KSQuad's middle along u, and along v
//           sizes     float[8 * quads]        of those that stay: segments along u and v, breaks of u and of v
//           vertex_counts, triangle_counts  uint [quads]
// Needs     nurbs/rpns/lengths.cl
// Plain     nurbs/rpns/sampling.py
// Defines   ADAPTIVE (1: by the screen), TOLERANT (1: KSQuads on borders get twice as many), UNIFORM (1: places are even)

#define COLLAPSED 0xFFFFFFFEu
#define RPNS_TWO(lane) (float8)(vload4(columns_of[lane], c), vload4(columns_of[lane + 4], c))

// does one of the KSQuads that these edges are sides of stay? Those from a row and a column before on
static inline bool rpns_is_near(__global const uchar *flags, const uint quad, const uint i, const uint j, const uint width, const uint count)
{
    uint found = 0;
    for (uint row = i ? 0 : 1; row < 2; ++row) {
        const uint first = quad + row * width - width;
        if (j) found |= flags[first - 1];
        for (uint lane = 0; lane < count; ++lane) found |= flags[first + lane];
    }
    return found != 0;
}

static inline __attribute__((always_inline)) void rpns_sample(const uint8 row, const uint16 surface,
    __global const uint *edges, __global const uint *firsts, __global const float *controls, __global const float *five,
    __global const float *places, __global float *factors, __global float *middles, const float4 screen_x,
    const float4 screen_y, const float4 screen_w, const float side, const float finest, const uint stride, const uint p, const uint q)
{
    const uint count = row.s4, width = surface.sa, height = surface.s1 - 1;
    const uint i = (row.s5 - surface.s9) / width, j = (row.s5 - surface.s9) % width;
    const float4 origin = (float4)(as_float3(surface.sbcd), 1.0f); // of its control points
    const float x0 = dot(screen_x, origin), y0 = dot(screen_y, origin), w0 = dot(screen_w, origin);
    uint columns_of[8];
    for (uint lane = 0; lane < 8; ++lane) columns_of[lane] = firsts[row.s3 + min(lane, count - 1)];
    screen8 net[64];
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            __global const float *c = controls + 4 * (size_t)(surface.s5 + (row.s1 + k) * surface.s6 + l);
            const fours8 a = transpose_fours(RPNS_TWO(0), RPNS_TWO(1), RPNS_TWO(2), RPNS_TWO(3));
            const screen8 on = {
                fma(a.x, (float8)(screen_x.x), fma(a.y, (float8)(screen_x.y), fma(a.z, (float8)(screen_x.z), a.w * x0))),
                fma(a.x, (float8)(screen_y.x), fma(a.y, (float8)(screen_y.y), fma(a.z, (float8)(screen_y.z), a.w * y0))),
                fma(a.x, (float8)(screen_w.x), fma(a.y, (float8)(screen_w.y), fma(a.z, (float8)(screen_w.z), a.w * w0)))};
            net[8 * k + l] = on;
        }
    __global float *middle = middles + 8 * (size_t)row.s5;
    rpns_put_fours(middle, 2, rpns_along(net, five, places, stride, ALONG_U, MIDDLE, p, q, side, finest), count);
    rpns_put_fours(middle + 4, 2, rpns_along(net, five, places, stride, ALONG_V, MIDDLE, p, q, side, finest), count);
    const uint across = row.s7 + i * width + j, along = row.s7 + (height + 1) * width + j * height + i;
    for (uint k = 0; k < 2; ++k) {
        if (k && i + 1 < height) break; // the next row's
        const fours8 found = rpns_along(net, five, places, stride, ALONG_V, k ? HIGH : LOW, p, q, side, finest);
        rpns_put_fours(factors + 4 * (size_t)(across + k * width), 1, found, count);
    }
    const fours8 first = rpns_along(net, five, places, stride, ALONG_U, LOW, p, q, side, finest);
    rpns_put_fours(factors + 4 * (size_t)along, height, first, count);
    if (j + count == width) {
        const fours8 found = rpns_along(net, five, places, stride, ALONG_U, HIGH, p, q, side, finest);
        float lanes[4][8];
        vstore8(found.x, 0, lanes[0]), vstore8(found.y, 0, lanes[1]), vstore8(found.z, 0, lanes[2]), vstore8(found.w, 0, lanes[3]);
        const float4 last = (float4)(lanes[0][count - 1], lanes[1][count - 1], lanes[2][count - 1], lanes[3][count - 1]);
        vstore4(last, along + (size_t)count * height, factors);
    }
    // a collapsed border has one segment
    const float4 one = (float4)(1.0f, 0.25f, 0.5f, 0.75f);
    for (uint lane = 0; lane < count; ++lane) {
        if (i == 0 && edges[8 * (across + lane) + 6] == COLLAPSED) vstore4(one, across + lane, factors);
        const uint last = across + width + lane;
        if (i + 1 == height && edges[8 * last + 6] == COLLAPSED) vstore4(one, last, factors);
    }
    if (j == 0 && edges[8 * along + 6] == COLLAPSED) vstore4(one, along, factors);
    const uint last = along + count * height;
    if (j + count == width && edges[8 * last + 6] == COLLAPSED) vstore4(one, last, factors);
}

__kernel void rpns_sampler_lengths(
    __global const uint *restrict octets,
    __global const uint *restrict edges,
    __global const uint *restrict surfaces,
    __global const uint *restrict firsts,
    __global const float *restrict controls,
    __global const float *restrict fives,
    __global const float *restrict places,
    __global const uchar *restrict flags,
    __global float *restrict factors,
    __global float *restrict middles,
    const float4 screen_x, // from a point to pixels times w
    const float4 screen_y,
    const float4 screen_w,
    const float side, // of a dice, pixels
    const float finest,
    const uint stride,
    const uint octet_count)
{
    const uint octet = get_global_id(0);
    if (octet >= octet_count) return;

    const uint8 row = vload8(octet, octets);
    const uint16 surface = vload16(row.s0, surfaces);
    const uint number = row.s5 - surface.s9, width = surface.sa, p = surface.s7, q = surface.s8;
    if (row.s6 == 0 && !rpns_is_near(flags, row.s5, number / width, number % width, width, row.s4)) return;
    __global const float *five = fives + 64 * (size_t)row.s2, *own = places + row.s3;
    if (p == 3 && q == 3)
        rpns_sample(row, surface, edges, firsts, controls, five, own, factors, middles, screen_x, screen_y, screen_w, side,
            finest, stride, 3, 3);
    else
        rpns_sample(row, surface, edges, firsts, controls, five, own, factors, middles, screen_x, screen_y, screen_w, side,
            finest, stride, p, q);
}

__kernel void rpns_sampler_sizes(
    __global const uint *restrict quads,
    __global const float *restrict factors,
    __global const float *restrict middles,
    __global const uint *restrict kept,
    __global const uint *restrict total,
    __global float *restrict sizes,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const uint quad_count,
    const uint item_count)
{
    const uint item = get_global_id(0), live = min(total[0], quad_count);
    if (item >= item_count) return;
    const uint end = (uint)((ulong)live * (item + 1) / item_count);
    for (uint slot = (uint)((ulong)live * item / item_count); slot < end; ++slot) {
        const uint number = kept[slot];
        __global const uint *quad = quads + 16 * (size_t)number;
        float4 u = (float4)(1.0f, 0.25f, 0.5f, 0.75f), v = u;
#if ADAPTIVE
        u = vload4(2 * (size_t)number, middles), v = vload4(2 * (size_t)number + 1, middles);
#endif
        v.x = fmax(v.x, fmax(factors[4 * (quad[4] >> 1)], factors[4 * (quad[5] >> 1)]));
        u.x = fmax(u.x, fmax(factors[4 * (quad[6] >> 1)], factors[4 * (quad[7] >> 1)]));
#if TOLERANT && ADAPTIVE
        if (quad[10]) u.x *= 2.0f, v.x *= 2.0f;
#endif
        vstore8((float8)(u.x, v.x, u.yzw, v.yzw), slot, sizes);
        vertex_counts[slot] = ((uint)u.x + 1) * ((uint)v.x + 1);
        triangle_counts[slot] = 2 * (uint)u.x * (uint)v.x;
    }
}
