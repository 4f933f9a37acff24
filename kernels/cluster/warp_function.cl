// Vertex clustering, set-up: a user's warp asked at even steps along each axis.
//
// Source    none: the user's own; it stands before this file as `float warp(const float t, const int axis)`
// Work      1-D, one item per step of an axis
// Reads     nothing
// Writes    values     float[3 * (WARP_STEPS + 1)]     warp(t, axis) at t = 0 .. 1, of x, then y, then z
// Plain     cluster/warped.py
// Defines   WARP_STEPS

__kernel void cluster_warp_function_table(
    __global float *restrict values,
    const uint value_count)
{
    const uint i = get_global_id(0);
    if (i >= value_count) return;

    const uint axis = i / (WARP_STEPS + 1), step = i % (WARP_STEPS + 1);
    values[i] = warp_called((float)step / (float)WARP_STEPS, (int)axis);
}
