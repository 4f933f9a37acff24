// Unit normals of a bicubic patch, also where Q_u x Q_v vanishes, as at a collapsed edge.
//
// Source    Concheiro 2013, section 1.2; where there is no normal, that of a place a little nearer to the patch's middle is
//           taken (reconstruction)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     bezier/patch.cl, common/normals.cl
// Plain     bezier/reference.py

#pragma OPENCL FP_CONTRACT OFF

// Q_u x Q_v at one place, scaled
static inline float3 bezier_cross_at(const bezier_patch *patch, const float u, const float v)
{
    const float s = 1.0f - u, t = 1.0f - v;
    const float16 a = patch->rows[0] * patch->scale, b = patch->rows[1] * patch->scale;
    const float16 c = patch->rows[2] * patch->scale, d = patch->rows[3] * patch->scale;
    const float16 r = BEZIER_CUBIC(s * s * s, 3.0f * s * s * u, 3.0f * s * u * u, u * u * u, a, b, c, d);
    const float16 q = BEZIER_QUADRATIC(s * s, 2.0f * s * u, u * u, b - a, c - b, d - c);
    const float4 along_u = BEZIER_CUBIC(
        t * t * t, 3.0f * t * t * v, 3.0f * t * v * v, v * v * v, q.s0123, q.s4567, q.s89ab, q.scdef);
    const float4 along_v = BEZIER_QUADRATIC(
        t * t, 2.0f * t * v, v * v, r.s4567 - r.s0123, r.s89ab - r.s4567, r.scdef - r.s89ab);
    return normals_cross(along_u.xyz, along_v.xyz);
}

// `n` as a unit; where it is none, that of a place nearer to the middle
static inline float3 bezier_unit(const float3 n, const bezier_patch *patch, const float u, const float v)
{
    if (normals_square(n) <= DEGENERATE)
        return normals_unit(bezier_cross_at(patch, u + INWARDS * (0.5f - u), v + INWARDS * (0.5f - v)));
    return normals_unit(n);
}
