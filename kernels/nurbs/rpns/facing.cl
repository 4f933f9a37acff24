// Does a KSQuad face away from the eye, or lie beside the image? Eight at a time, by two techniques.
//
// Source    Concheiro 2013, section 6.4.2 (strong and light quad culling; which quads of the net is a reconstruction)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     nurbs/rpns/reference.py

#pragma OPENCL FP_CONTRACT ON // fewer roundings than nurbs/rpns/certified.cl reckons with

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
