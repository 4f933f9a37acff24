// Curves across a KSQuad, along which it is measured and its borders lie: any of its sides, or its middle.
//
// Source    Concheiro 2013, section 6.3 (KSDice sampling; its formulas were not at hand: a reconstruction)
// Work      functions only; what is fused says so with fma
// Reads     fives     float[64 * records]  basis functions of each span at 0, 1/4, 1/2, 3/4 and 1: those of a control point
//                                          in eight lanes, of which five are read
//           controls  float[4 * controls]  as nurbs/surface.cl has them
// Writes    nothing
// Needs     nurbs/basis.cl nurbs/surface.cl
// Defines   RATIONAL, NORMALS, STREAMING (nurbs/surface.cl)
// Plain     nurbs/rpns/sampling.py

#pragma OPENCL FP_CONTRACT OFF

#define LOW 0 // lanes of `fives`
#define MIDDLE 2
#define HIGH 4
#define NEAREST_W 1e-20f // in front of the eye

// control points of the curve at one place of the side that has `across` control points each `step` apart
static inline void rpns_curve(float4 *curve, __global const float *net, __global const float *five, const uint lane,
    const uint across, const uint step, const uint along, const uint stride)
{
    for (uint l = 0; l < along; ++l) {
        float4 sum = vload4((size_t)l * stride, net) * five[lane];
        for (uint k = 1; k < across; ++k)
            sum = fma(vload4((size_t)l * stride + (size_t)k * step, net), (float4)(five[8 * k + lane]), sum);
        curve[l] = sum;
    }
}

// length on the screen of the polyline through five points of a curve, and how it is shared out: breaks at three of them.
// Where some of it is behind the eye the length is infinite
static inline float4 rpns_length(const float4 *curve, __global const float *five, const uint along, const float3 origin,
    const float4 screen_x, const float4 screen_y, const float4 screen_w)
{
    float8 x = (float8)(0.0f), y = x, z = x, w = x;
    for (uint l = 0; l < along; ++l) {
        const float8 n = vload8(l, five);
        x = fma(n, (float8)(curve[l].x), x), y = fma(n, (float8)(curve[l].y), y);
        z = fma(n, (float8)(curve[l].z), z), w = fma(n, (float8)(curve[l].w), w);
    }
    x += w * origin.x, y += w * origin.y, z += w * origin.z;
    const float8 depth = (x * screen_w.x + y * screen_w.y) + (z * screen_w.z + w * screen_w.w);
    const float8 inverse = 1.0f / depth;
    float across[8], down[8], before[8];
    vstore8(((x * screen_x.x + y * screen_x.y) + (z * screen_x.z + w * screen_x.w)) * inverse, 0, across);
    vstore8(((x * screen_y.x + y * screen_y.y) + (z * screen_y.z + w * screen_y.w)) * inverse, 0, down);
    vstore8(depth, 0, before);
    float ends[5] = {0.0f};
    bool seen = before[0] > NEAREST_W;
    for (uint k = 0; k < 4; ++k) {
        const float a = across[k + 1] - across[k], b = down[k + 1] - down[k];
        ends[k + 1] = ends[k] + sqrt(a * a + b * b);
        seen = seen && before[k + 1] > NEAREST_W;
    }
    // each part has some share at the least, so that no place is at the end of two
    const float total = ends[4], share = 1.0f / (1.2f * total);
    const float4 even = (float4)(INFINITY, 0.25f, 0.5f, 0.75f);
    if (!(seen && total < 1e30f)) return even;
    if (!(total > 1e-20f)) return (float4)(0.0f, 0.25f, 0.5f, 0.75f);
    const float part = 0.05f * total;
    return (float4)(total, (ends[1] + part) * share, (ends[2] + 2.0f * part) * share, (ends[3] + 3.0f * part) * share);
}

// how many segments a length asks for
static inline float rpns_segments(const float length, const float side, const float finest)
{
    const float wanted = ceil(length / side);
    return wanted < finest ? fmax(wanted, 1.0f) : finest;
}

// t of vertex k of n, where breaks share out a side: the same to the bit wherever it is asked for
static inline float8 rpns_place(const int8 k, const float n, const float3 breaks)
{
    const float8 s = convert_float8(k) / n;
#if UNIFORM
    return s;
#else
    const int8 second = s >= breaks.x, third = s >= breaks.y, fourth = s >= breaks.z; // Oclgrind nests no selections
    const float8 low = as_float8((second & ~third & as_int(breaks.x)) | (third & ~fourth & as_int(breaks.y))
        | (fourth & as_int(breaks.z)));
    const float8 high = as_float8((~second & as_int(breaks.x)) | (second & ~third & as_int(breaks.y))
        | (third & ~fourth & as_int(breaks.z)) | (fourth & as_int(1.0f)));
    const float8 part = -convert_float8(second + third + fourth);
    return 0.25f * (part + (s - low) / (high - low));
#endif
}
