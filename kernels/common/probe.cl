// Does this driver inline its own built-ins? The same arithmetic, once by name and once by operator.
//
// Source    none: a defect of some PoCL builds, which compile their library for another feature set than the host's
// Work      1-D, one item per value; items past count return at once
// Reads     values  float[count]
// Writes    values  float[count]

__kernel void probe_builtin(__global float *restrict values, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) return;
    float x = values[i];
    for (int k = 0; k < 8; ++k) x = mad(x, 0.5f, 1.0f);
    values[i] = x;
}

__kernel void probe_operator(__global float *restrict values, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) return;
    float x = values[i];
    for (int k = 0; k < 8; ++k) x = x * 0.5f + 1.0f;
    values[i] = x;
}
