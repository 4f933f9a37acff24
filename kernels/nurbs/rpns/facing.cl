// Does a KSQuad face away from the eye, or lie beside the image? Eight at a time, by three techniques.
//
// Source    Concheiro 2013, section 6.4.2 (strong and light quad culling; which quads of the net is a reconstruction); what
//           is certified is ours: with X = w (S - e), S_u x S_v faces away where X . (X_u x X_v) >= 0. X_u x X_v is a Bezier
//           surface of its own; all products of its control points with those of X must be larger than what rounds away
// Work      functions only
// Reads     choose  float[14 * 14]  binomial coefficients
// Writes    nothing
// Plain     nurbs/rpns/reference.py

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

// the control points of a Bezier surface; X lies in the box of its control points, and so does its product with each of
// those of X_u x X_v, which are summed times their binomial coefficients
static inline __attribute__((always_inline)) int8 rpns_faces_away(
    const net8 *net, const float3 eye, const uint p, const uint q, __global const float *choose)
{
    int8 away = rpns_corners_face_away(net, eye, p, q);
    if (!rpns_any(away)) return away;

    const float8 zero = (float8)(0.0f);
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
            most_v = fmax(most_v, rpns_size(d)), weight = fmax(weight, fabs(raw.w));
            dv[8 * k + l].x = d.x * times, dv[8 * k + l].y = d.y * times, dv[8 * k + l].z = d.z * times;
        }
    float8 nx[14 * 14], ny[14 * 14], nz[14 * 14];
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) nx[14 * i + j] = ny[14 * i + j] = nz[14 * i + j] = zero;
    for (uint i = 0; i < p; ++i)
        for (uint j = 0; j <= q; ++j) {
            const net8 raw = rpns_less(net[8 * i + 8 + j], net[8 * i + j]), d = rpns_from_eye(raw, eye);
            const float8 times = (float8)(choose[14 * (p - 1) + i] * choose[14 * q + j]);
            most_u = fmax(most_u, rpns_size(d)), weight = fmax(weight, fabs(raw.w));
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
    // sixteen roundings of each product, and of the differences that it is made of
    const float eye_size = fabs(eye.x) + fabs(eye.y) + fabs(eye.z);
    const float8 lost = 2e-6f * (near + weight * eye_size);
    const float8 far = fmax(fabs(low.x), fabs(high.x)) + fmax(fabs(low.y), fabs(high.y)) + fmax(fabs(low.z), fabs(high.z));
    const float8 slack = far * (2e-6f * most_u * most_v + lost * (most_u + most_v));
    for (uint i = 0; i < 2 * p; ++i)
        for (uint j = 0; j < 2 * q; ++j) {
            const uint at = 14 * i + j;
            const float8 least = fmin(low.x * nx[at], high.x * nx[at]) + fmin(low.y * ny[at], high.y * ny[at])
                + fmin(low.z * nz[at], high.z * nz[at]);
            away &= least > slack * (choose[14 * (2 * p - 1) + i] * choose[14 * (2 * q - 1) + j]);
        }
    return away;
}
