// A function of the user's asked at given places: what it says there, with its slope, for a check of a refined surface.
//
// Source    none: it calls common/function.cl, as the vertex stage does
// Work      1-D, one item per eight places; the last ones are padded
// Reads     places     float[8 * count]               planes of x y z of points, x y z of unit normals, u, v; model units
//           gradients  float[6 * count]               planes of x y z of the gradients of u and v, per diagonal
// Writes    answers    float[4 * count]               planes of height, model units, and x y z of its gradient
// Needs     common/function.cl
// Plain     refine/function.py
// Defines   CHUNK, ATTRIBUTES as in common/displacement.cl

__kernel void refine_function_answers(
    __global const float *restrict places,
    __global const float *restrict gradients,
    __global float *restrict answers,
    const float4 displacement, // as the struct has it
    const uint count)          // a multiple of eight
{
    const uint i = get_global_id(0);
    if (8 * i >= count) return;

    Displacement d = {displacement.x, displacement.y, displacement.z, displacement.w, 0};
    float8 given[8];
    for (uint k = 0; k < 8; ++k) given[k] = vload8(i, places + (size_t)k * count);
#if ATTRIBUTES
    d.at[0] = given[6], d.at[1] = given[7];
    for (uint k = 0; k < 6; ++k) d.at[2 + k] = vload8(i, gradients + (size_t)k * count);
#endif
    const planes8 p = {given[0], given[1], given[2]}, n = {given[3], given[4], given[5]};
    float8 height;
    planes8 gradient;
    function_at(p, n, &d, &height, &gradient);
    vstore8(height, i, answers);
    vstore8(gradient.x, i, answers + (size_t)count);
    vstore8(gradient.y, i, answers + 2 * (size_t)count);
    vstore8(gradient.z, i, answers + 3 * (size_t)count);
}
