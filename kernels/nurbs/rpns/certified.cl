// Can it be shown that no point of a KSQuad faces the eye? Eight at a time, out of the control points of Bezier surfaces.
//
// Source    ours: with X = w (S - e), S_u x S_v faces away where X . (X_u x X_v) >= 0; what can be told of its control points
//           must be larger than what rounds away
// Work      functions only
// Reads     choose  float[14 * 14]  binomial coefficients
// Writes    nothing
// Needs     nurbs/rpns/facing.cl
// Plain     nurbs/rpns/reference.py
// Defines   RATIONAL (0: all weights are 1)

#pragma OPENCL FP_CONTRACT ON // fewer roundings than are reckoned with

static inline float8 rpns_size(const net8 a) { return fabs(a.x) + fabs(a.y) + fabs(a.z); }

static inline float8 rpns_square(const net8 a) { return a.x * a.x + a.y * a.y + a.z * a.z; }

static inline net8 rpns_less(const net8 a, const net8 b)
{
    const net8 found = {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
    return found;
}

static inline bool rpns_any(const int8 lanes)
{
    const ulong4 words = as_ulong4(lanes);
    return (words.x | words.y | words.z | words.w) != 0;
}

// X . (X_u x X_v) at the corners alone, but for positive factors: where one faces the eye, all is said
static inline __attribute__((always_inline)) int8 rpns_corners_face_away(const net8 *net, const float3 eye, const uint p, const uint q)
{
    int8 away = (int8)(-1);
    for (uint k = 0; k <= p; k += p)
        for (uint l = 0; l <= q; l += q) {
            const uint i = k ? p - 1 : 0, j = l ? q - 1 : 0;
            const net8 du = rpns_less(net[8 * i + 8 + l], net[8 * i + l]), dv = rpns_less(net[8 * k + 1 + j], net[8 * k + j]);
            const net8 x = rpns_from_eye(net[8 * k + l], eye);
            away &= rpns_det(x, rpns_from_eye(du, eye), rpns_from_eye(dv, eye)) >= 0.0f;
        }
    return away;
}

// The same more closely, of wide KSQuads: X lies in the box of its control points, and so does its product with each control
// point of X_u x X_v, which are summed times their binomial coefficients
static inline int8 rpns_faces_away_closely(
    const net8 *net, const float3 eye, const uint p, const uint q, __global const float *choose)
{
    const float8 zero = (float8)(0.0f);
    int8 away = (int8)(-1);
    net8 dv[64];
    float8 near = zero, most_u = zero, most_v = zero, weight = zero;
    net8 low = rpns_from_eye(net[0], eye), high = low;
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            const net8 x = rpns_from_eye(net[8 * k + l], eye);
            low.x = fmin(low.x, x.x), low.y = fmin(low.y, x.y), low.z = fmin(low.z, x.z);
            high.x = fmax(high.x, x.x), high.y = fmax(high.y, x.y), high.z = fmax(high.z, x.z);
            near = fmax(near, rpns_size(net[8 * k + l]));
            if (l == q) continue;
            const net8 raw = rpns_less(net[8 * k + 1 + l], net[8 * k + l]), d = rpns_from_eye(raw, eye);
            const float8 times = (float8)(choose[14 * p + k] * choose[14 * (q - 1) + l]);
            most_v = fmax(most_v, rpns_size(d));
            if (RATIONAL) weight = fmax(weight, fabs(raw.w));
            dv[8 * k + l].x = d.x * times, dv[8 * k + l].y = d.y * times, dv[8 * k + l].z = d.z * times;
        }
    float8 nx[14 * 14], ny[14 * 14], nz[14 * 14];
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) nx[14 * i + j] = ny[14 * i + j] = nz[14 * i + j] = zero;
    for (uint i = 0; i < p; ++i)
        for (uint j = 0; j <= q; ++j) {
            const net8 raw = rpns_less(net[8 * i + 8 + j], net[8 * i + j]), d = rpns_from_eye(raw, eye);
            const float8 times = (float8)(choose[14 * (p - 1) + i] * choose[14 * q + j]);
            most_u = fmax(most_u, rpns_size(d));
            if (RATIONAL) weight = fmax(weight, fabs(raw.w));
            const float8 x = d.x * times, y = d.y * times, z = d.z * times;
            for (uint k = 0; k <= p; ++k)
                for (uint l = 0; l < q; ++l) {
                    const net8 other = dv[8 * k + l];
                    const uint at = 14 * (i + k) + j + l;
                    nx[at] += y * other.z - z * other.y;
                    ny[at] += z * other.x - x * other.z;
                    nz[at] += x * other.y - y * other.x;
                }
        }
    // roundings as above
    const float eye_size = fabs(eye.x) + fabs(eye.y) + fabs(eye.z), rounding = 6e-8f * (float)(24 + p * q);
    const float8 lost = 2e-6f * (near + weight * eye_size);
    const float8 far = fmax(fabs(low.x), fabs(high.x)) + fmax(fabs(low.y), fabs(high.y)) + fmax(fabs(low.z), fabs(high.z));
    const float8 slack = far * (rounding * most_u * most_v + lost * (most_u + most_v));
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) {
            const uint at = 14 * i + j;
            const float8 least = fmin(low.x * nx[at], high.x * nx[at]) + fmin(low.y * ny[at], high.y * ny[at])
                + fmin(low.z * nz[at], high.z * nz[at]);
            away &= least > slack * (choose[14 * (2 * p - 1) + i] * choose[14 * (2 * q - 1) + j]);
        }
    return away;
}

// X lies no further from the middle of its corners than its furthest control point. With the middle in its place
// X . (X_u x X_v) is a Bezier surface, whose control points are sums of all products times their binomial coefficients; it
// is off by no more than that distance times the longest tangents
static inline __attribute__((always_inline)) int8 rpns_faces_away(
    const net8 *net, const float3 eye, const uint p, const uint q, __global const float *choose)
{
    int8 away = rpns_corners_face_away(net, eye, p, q);
    if (!rpns_any(away)) return away;

    const float8 zero = (float8)(0.0f);
    float8 most_u = zero, most_v = zero, long_u = zero, long_v = zero, near = zero, weight = zero, far = zero;
    net8 middle = {zero, zero, zero, zero}; // of the corners
    for (uint k = 0; k <= p; k += p)
        for (uint l = 0; l <= q; l += q) {
            const net8 x = rpns_from_eye(net[8 * k + l], eye);
            middle.x += 0.25f * x.x, middle.y += 0.25f * x.y, middle.z += 0.25f * x.z;
        }
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            far = fmax(far, rpns_square(rpns_less(rpns_from_eye(net[8 * k + l], eye), middle)));
            near = fmax(near, rpns_size(net[8 * k + l]));
        }
    net8 dv[64];
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l < q; ++l) {
            const net8 raw = rpns_less(net[8 * k + 1 + l], net[8 * k + l]), d = rpns_from_eye(raw, eye);
            const float8 times = (float8)(choose[14 * p + k] * choose[14 * (q - 1) + l]);
            most_v = fmax(most_v, rpns_size(d)), long_v = fmax(long_v, rpns_square(d));
            if (RATIONAL) weight = fmax(weight, fabs(raw.w));
            dv[8 * k + l].x = d.x * times, dv[8 * k + l].y = d.y * times, dv[8 * k + l].z = d.z * times;
        }
    float8 sums[14 * 14];
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) sums[14 * i + j] = zero;
    for (uint i = 0; i < p; ++i)
        for (uint j = 0; j <= q; ++j) {
            const net8 raw = rpns_less(net[8 * i + 8 + j], net[8 * i + j]), d = rpns_from_eye(raw, eye);
            const float8 times = (float8)(choose[14 * (p - 1) + i] * choose[14 * q + j]);
            most_u = fmax(most_u, rpns_size(d)), long_u = fmax(long_u, rpns_square(d));
            if (RATIONAL) weight = fmax(weight, fabs(raw.w));
            const float8 x = (middle.y * d.z - middle.z * d.y) * times, y = (middle.z * d.x - middle.x * d.z) * times;
            const float8 z = (middle.x * d.y - middle.y * d.x) * times;
            for (uint k = 0; k <= p; ++k)
                for (uint l = 0; l < q; ++l) {
                    const net8 other = dv[8 * k + l];
                    sums[14 * (i + k) + j + l] += x * other.x + y * other.y + z * other.z;
                }
        }
    // roundings of each product, of the sums and of the differences that it is made of
    const float eye_size = fabs(eye.x) + fabs(eye.y) + fabs(eye.z), rounding = 6e-8f * (float)(24 + p * q);
    const float8 beside = sqrt(far), here = rpns_size(middle);
    const float8 lost = 2e-6f * (near + weight * eye_size);
    const float8 apart = 1.0001f * beside * sqrt(long_u) * sqrt(long_v);
    const float8 slack = here * (rounding * most_u * most_v + lost * (most_u + most_v));
    away &= fmin(far, fmin(long_u, long_v)) > 1e-30f; // else squares may have vanished
    int8 wide = away; // that only the distance between two X keeps from facing away
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) {
            const float8 sum = sums[14 * i + j], times = choose[14 * (2 * p - 1) + i] * choose[14 * (2 * q - 1) + j];
            wide &= sum > slack * times, away &= sum > (slack + apart) * times;
        }
    wide &= ~away;
    return rpns_any(wide) ? away | (wide & rpns_faces_away_closely(net, eye, p, q, choose)) : away;
}
