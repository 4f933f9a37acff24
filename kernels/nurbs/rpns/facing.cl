// Does a KSQuad face away from the eye, or lie beside the image? Eight at a time, by three techniques.
//
// Source    Concheiro 2013, section 6.4.2 (strong and light quad culling; which quads of the net is a reconstruction); what
//           is certified is ours: with X = w (S - e), S_u x S_v faces away where X . (X_u x X_v) >= 0. With the middle of all X
//           in its place that is a Bezier surface; its control points must be larger than what X is apart, and rounding
// Work      functions only
// Reads     choose  float[14 * 14]  binomial coefficients
// Writes    nothing
// Plain     nurbs/rpns/reference.py
// Defines   RATIONAL (0: all weights are 1)

#pragma OPENCL FP_CONTRACT ON // fewer roundings than are reckoned with

typedef struct {
    float8 x, y, z, w;
} net8;

static inline float8 rpns_det(const net8 a, const net8 b, const net8 c)
{
    return a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
}

// homogeneous points from the eye
static inline net8 rpns_from_eye(const net8 a, const float3 eye)
{
    const net8 found = {a.x - a.w * eye.x, a.y - a.w * eye.y, a.z - a.w * eye.z, a.w};
    return found;
}

// are all control points beyond one side of the image, and so all between them? By more than rounds away
static inline int8 rpns_beside(const net8 *net, const float3 origin, const float4 clip_x, const float4 clip_y,
    const float4 clip_w, const uint p, const uint q)
{
    const float4 o = (float4)(origin, 1.0f);
    const float x0 = dot(clip_x, o), y0 = dot(clip_y, o), w0 = dot(clip_w, o);
    const float4 sizes = fabs(clip_x) + fabs(clip_y) + fabs(clip_w);
    const float moved = dot(sizes, fabs(o)), most = sizes.x + sizes.y + sizes.z;
    float8 low_x = (float8)(-INFINITY), high_x = low_x, low_y = low_x, high_y = low_x, size = (float8)(0.0f);
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            const net8 a = net[8 * k + l];
            const float8 x = clip_x.x * a.x + clip_x.y * a.y + clip_x.z * a.z + x0 * a.w;
            const float8 y = clip_y.x * a.x + clip_y.y * a.y + clip_y.z * a.z + y0 * a.w;
            const float8 w = clip_w.x * a.x + clip_w.y * a.y + clip_w.z * a.z + w0 * a.w;
            low_x = fmax(low_x, w + x), high_x = fmax(high_x, w - x);
            low_y = fmax(low_y, w + y), high_y = fmax(high_y, w - y);
            size = fmax(size, most * (fabs(a.x) + fabs(a.y) + fabs(a.z)) + moved * a.w);
        }
    const float8 slack = -4e-6f * size;
    return (low_x < slack) | (high_x < slack) | (low_y < slack) | (high_y < slack);
}

// does a degree's light culling look at this row of quads? The middle of the net, or, where that has few, its ends
static inline bool rpns_is_light(const uint k, const uint p)
{
    return p >= 3 ? k == (p - 1) / 2 || k == p / 2 : k == 0 || k == p - 1;
}

static inline __attribute__((always_inline)) int8 rpns_net_faces_away(
    const net8 *net, const float3 eye, const uint p, const uint q, const bool light)
{
    int8 away = (int8)(-1);
    for (uint k = 0; k < p; ++k)
        for (uint l = 0; l < q; ++l) {
            if (light && !(rpns_is_light(k, p) && rpns_is_light(l, q))) continue;
            const net8 a = rpns_from_eye(net[8 * k + l], eye), b = rpns_from_eye(net[8 * k + 8 + l], eye);
            const net8 c = rpns_from_eye(net[8 * k + 9 + l], eye), d = rpns_from_eye(net[8 * k + 1 + l], eye);
            away &= (rpns_det(a, b, c) >= 0.0f) & (rpns_det(a, c, d) >= 0.0f);
        }
    return away;
}

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

// the control points of a Bezier surface. X is no further from the middle of its corners than its furthest
// control point: so X . (X_u x X_v) is a Bezier surface with the middle in place of X, whose control points are sums of all products
// times their binomial coefficients, and no more than that distance times the longest tangents beside it
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
    const float8 slack = here * (rounding * most_u * most_v + lost * (most_u + most_v)) + apart;
    away &= fmin(far, fmin(long_u, long_v)) > 1e-30f; // else squares may have vanished
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j)
            away &= sums[14 * i + j] > slack * (choose[14 * (2 * p - 1) + i] * choose[14 * (2 * q - 1) + j]);
    return away;
}
