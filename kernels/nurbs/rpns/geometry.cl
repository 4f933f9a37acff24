// The geometry stage: which KSQuads are beside the image or face away from the eye, eight of a row at a time.
//
// Source    Concheiro 2013, section 6.4.2
// Work      1-D, one item per octet of KSQuads
// Reads     octets    uint [8 * octet_count]  surface, first control row, record of u, record of the first v, how many,
//                                             first KSQuad, 1: other surfaces share an edge of one, first edge of the
//                                             surface
//           surfaces  uint [16 * surfaces]    as nurbs/surface.cl has them
//           firsts    uint [records]          first control column of each span
//           beziers   float[64 * records]     from the control points of a span to those of its Bezier curve, 8 x 8
//           choose    float[14 * 14]          binomial coefficients
//           controls  float[4 * controls]     as nurbs/surface.cl has them
// Writes    flags     uchar[quads]            1: it stays
// Needs     common/transpose.cl, nurbs/rpns/certified.cl
// Plain     nurbs/rpns/reference.py
// Defines   CULLING (0: none, 1: strong, 2: light, 3: certified), RATIONAL (0: all weights are 1)

static inline void rpns_add(net8 *sum, const float8 share, const net8 a)
{
    sum->x += share * a.x, sum->y += share * a.y, sum->z += share * a.z;
    if (RATIONAL) sum->w += share * a.w;
}

#if CULLING == 3
// a control point of a span that its Bezier curve's point `a` does not depend on
static inline bool rpns_apart(const uint a, const uint k, const uint p) { return (k == 0 && a > 0) || (k == p && a < p); }

// can it be shown that KSQuads face away? Their nets become those of Bezier surfaces
static inline __attribute__((always_inline)) int8 rpns_certified(net8 *net, const float3 from, __global const float *beziers, const uint8 row,
    const uint p, const uint q, const uint count, __global const float *choose)
{
    const net8 none = {(float8)(0.0f), (float8)(0.0f), (float8)(0.0f), (float8)(RATIONAL ? 0.0f : 1.0f)};
    net8 half_way[64];
    for (uint a = 0; a <= p; ++a)
        for (uint l = 0; l <= q; ++l) {
            net8 sum = none;
            for (uint k = 0; k <= p; ++k)
                if (!rpns_apart(a, k, p)) rpns_add(&sum, (float8)(beziers[64 * row.s2 + 8 * a + k]), net[8 * k + l]);
            half_way[8 * a + l] = sum;
        }
    for (uint b = 0; b <= q; ++b) {
        for (uint a = 0; a <= p; ++a) net[8 * a + b] = none;
        for (uint l = 0; l <= q; ++l) {
            if (rpns_apart(b, l, q)) continue;
            float shares[8];
            for (uint lane = 0; lane < 8; ++lane)
                shares[lane] = beziers[64 * (row.s3 + min(lane, count - 1)) + 8 * b + l];
            const float8 share = vload8(0, shares);
            for (uint a = 0; a <= p; ++a) rpns_add(&net[8 * a + b], share, half_way[8 * a + l]);
        }
    }
    return rpns_faces_away(net, from, p, q, choose);
}
#endif

#define RPNS_TWO(lane) (float8)(vload4(columns_of[lane], c), vload4(columns_of[lane + 4], c))

__kernel void rpns_geometry_cull(
    __global const uint *restrict octets,
    __global const uint *restrict surfaces,
    __global const uint *restrict firsts,
    __global const float *restrict beziers,
    __global const float *restrict choose,
    __global const float *restrict controls,
    __global uchar *restrict flags,
    const float4 eye,    // w = 0: there is none, and all stay
    const float4 clip_x, // from a point to the image, whose sides are at -w and w
    const float4 clip_y,
    const float4 clip_w,
    const uint in_view, // 1: all is within the image
    const uint octet_count)
{
    const uint octet = get_global_id(0);
    if (octet >= octet_count) return;

    const uint8 row = vload8(octet, octets);
    const uint16 surface = vload16(row.s0, surfaces);
    const uint count = row.s4, columns = surface.s6, p = surface.s7, q = surface.s8;
    int8 away = (int8)(0);
    if (CULLING > 0 && eye.w > 0.0f) {
        const float3 from = eye.xyz - as_float3(surface.sbcd);
        net8 net[64];
        uint columns_of[8];
        for (uint lane = 0; lane < 8; ++lane) columns_of[lane] = firsts[row.s3 + min(lane, count - 1)];
        for (uint k = 0; k <= p; ++k)
            for (uint l = 0; l <= q; ++l) {
                __global const float *c = controls + 4 * (size_t)(surface.s5 + (row.s1 + k) * columns + l);
                const fours8 found = transpose_fours(RPNS_TWO(0), RPNS_TWO(1), RPNS_TWO(2), RPNS_TWO(3));
                const net8 planes = {found.x, found.y, found.z, found.w};
                net[8 * k + l] = planes;
            }
        const float3 origin = as_float3(surface.sbcd);
        int8 hidden = (int8)(0);
        if (in_view == 0) hidden = rpns_beside(net, origin, clip_x, clip_y, clip_w, p, q);
        const bool light = CULLING > 1;
        away = p == 3 && q == 3 ? rpns_net_faces_away(net, from, 3, 3, light) : rpns_net_faces_away(net, from, p, q, light);
#if CULLING == 3
        // what the middle of the net does not make likely is not tried
        if (rpns_any(away))
            away = p == 3 && q == 3 ? rpns_certified(net, from, beziers, row, 3, 3, count, choose)
                                    : rpns_certified(net, from, beziers, row, p, q, count, choose);
#endif
        away |= hidden;
    }
    int lanes[8];
    vstore8(away, 0, lanes);
    for (uint lane = 0; lane < count; ++lane) flags[row.s5 + lane] = lanes[lane] ? 0 : 1;
}
