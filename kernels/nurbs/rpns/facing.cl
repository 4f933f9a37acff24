// Does a KSQuad face away from the eye? Eight at a time, by three techniques.
//
// Source    Concheiro 2013, section 6.4.2 (strong and light quad culling; which quads of the net is a reconstruction); what
//           is certified is ours: with X = w (S - e), S_u x S_v faces away where X . (X_u x X_v) >= 0. X_u x X_v is a Bezier
//           surface of its own; all products of its control points with those of X must be larger than what rounds away
// Work      functions only
// Reads     choose  float[14 * 14]  binomial coefficients
// Writes    nothing
// Plain     nurbs/rpns/reference.py
// Defines   CULLING (0: none, 1: strong, 2: light, 3: certified)

#pragma OPENCL FP_CONTRACT OFF

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

// does a degree's light culling look at this row of quads? The middle of the net, or, where that has few, its ends
static inline bool rpns_is_light(const uint k, const uint p)
{
    return p >= 3 ? k == (p - 1) / 2 || k == p / 2 : k == 0 || k == p - 1;
}

static inline int8 rpns_net_faces_away(const net8 *net, const float3 eye, const uint p, const uint q)
{
    int8 away = (int8)(-1);
    for (uint k = 0; k < p; ++k)
        for (uint l = 0; l < q; ++l) {
            if (CULLING == 2 && !(rpns_is_light(k, p) && rpns_is_light(l, q))) continue;
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

// the control points of a Bezier surface
static inline int8 rpns_faces_away(
    const net8 *net, const float3 eye, const uint p, const uint q, __global const float *choose)
{
    const float8 zero = (float8)(0.0f);
    float8 nx[14 * 14], ny[14 * 14], nz[14 * 14];
    for (uint i = 0; i < 14 * 14; ++i) nx[i] = ny[i] = nz[i] = zero;
    float8 far = zero, near = zero, most_u = zero, most_v = zero, weight = zero;
    for (uint i = 0; i < p; ++i)
        for (uint j = 0; j <= q; ++j) {
            const net8 raw = rpns_less(net[8 * i + 8 + j], net[8 * i + j]), du = rpns_from_eye(raw, eye);
            most_u = fmax(most_u, rpns_size(du)), weight = fmax(weight, fabs(raw.w));
            for (uint k = 0; k <= p; ++k)
                for (uint l = 0; l < q; ++l) {
                    const net8 dv = rpns_from_eye(rpns_less(net[8 * k + 1 + l], net[8 * k + l]), eye);
                    const float share = choose[14 * (p - 1) + i] * choose[14 * p + k] / choose[14 * (2 * p - 1) + i + k]
                        * (choose[14 * q + j] * choose[14 * (q - 1) + l] / choose[14 * (2 * q - 1) + j + l]);
                    const uint at = 14 * (i + k) + j + l;
                    nx[at] += share * (du.y * dv.z - du.z * dv.y);
                    ny[at] += share * (du.z * dv.x - du.x * dv.z);
                    nz[at] += share * (du.x * dv.y - du.y * dv.x);
                }
        }
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            if (l < q) {
                const net8 raw = rpns_less(net[8 * k + 1 + l], net[8 * k + l]);
                most_v = fmax(most_v, rpns_size(rpns_from_eye(raw, eye))), weight = fmax(weight, fabs(raw.w));
            }
            near = fmax(near, rpns_size(net[8 * k + l]));
            far = fmax(far, rpns_size(rpns_from_eye(net[8 * k + l], eye)));
        }
    // sixteen roundings of each product, and of the differences that it is made of
    const float eye_size = fabs(eye.x) + fabs(eye.y) + fabs(eye.z);
    const float8 lost = 2e-6f * (near + weight * eye_size);
    const float8 slack = far * (2e-6f * most_u * most_v + lost * (most_u + most_v));
    int8 away = (int8)(-1);
    for (uint k = 0; k <= p; ++k)
        for (uint l = 0; l <= q; ++l) {
            const net8 x = rpns_from_eye(net[8 * k + l], eye);
            for (uint i = 0; i < 2 * p; ++i)
                for (uint j = 0; j < 2 * q; ++j) {
                    const uint at = 14 * i + j;
                    away &= x.x * nx[at] + x.y * ny[at] + x.z * nz[at] > slack;
                }
        }
    return away;
}
