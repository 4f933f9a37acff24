// What a device can do at most: fill, copy, multiply-add and launch, for the shares that tables show.
//
// Source    McCalpin 1995, STREAM (fill, copy); Williams et al. 2009, the roofline model (multiply-add)
// Work      1-D; fill and copy: item i takes `steps` vectors from i * item_step on, vector_step apart (CPU: runs; GPU:
//           neighbours); multiply_add: one item per eight chains
// Reads     source  float[8 * vector_count]
// Writes    values  float[8 * vector_count]
// Defines   STREAMING  1: stores that bypass the caches, where the compiler has them

#if STREAMING && defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define STORE(vector, at) __builtin_nontemporal_store(vector, at)
#endif
#endif
#ifndef STORE
#define STORE(vector, at) *(at) = (vector)
#endif

__kernel void measure_limits_fill(
    __global float8 *restrict values,
    const float value,
    const uint steps,
    const uint item_step,
    const uint vector_step,
    const uint vector_count)
{
    const float8 vector = value;
    uint v = get_global_id(0) * item_step;
    for (uint s = 0; s < steps && v < vector_count; ++s, v += vector_step) STORE(vector, values + v);
}

__kernel void measure_limits_copy(
    __global const float8 *restrict source,
    __global float8 *restrict values,
    const uint steps,
    const uint item_step,
    const uint vector_step,
    const uint vector_count)
{
    uint v = get_global_id(0) * item_step;
    for (uint s = 0; s < steps && v < vector_count; ++s, v += vector_step) STORE(source[v], values + v);
}

// eight independent chains of eight lanes hide the latency of a multiply-add
__kernel void measure_limits_multiply_add(
    __global float8 *restrict values,
    const float factor,
    const float term,
    const uint steps,
    const uint item_count)
{
    const uint i = get_global_id(0);
    if (i >= item_count) return;

    const float8 a = factor, b = term;
    float8 x0 = i, x1 = x0 + 1.0f, x2 = x0 + 2.0f, x3 = x0 + 3.0f;
    float8 x4 = x0 + 4.0f, x5 = x0 + 5.0f, x6 = x0 + 6.0f, x7 = x0 + 7.0f;
    for (uint s = 0; s < steps; ++s) {
        x0 = mad(x0, a, b);
        x1 = mad(x1, a, b);
        x2 = mad(x2, a, b);
        x3 = mad(x3, a, b);
        x4 = mad(x4, a, b);
        x5 = mad(x5, a, b);
        x6 = mad(x6, a, b);
        x7 = mad(x7, a, b);
    }
    values[i] = ((x0 + x1) + (x2 + x3)) + ((x4 + x5) + (x6 + x7));
}

__kernel void measure_limits_empty(__global float *restrict values, const uint item_count)
{
    if (get_global_id(0) < item_count) values[get_global_id(0)] = 0.0f;
}
