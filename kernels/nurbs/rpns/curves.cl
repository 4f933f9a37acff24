// Curves across a KSQuad, on which its borders lie, and places along them.
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

#ifndef LOW // as in nurbs/rpns/lengths.cl
#define LOW 0
#define HIGH 4
#endif

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
