// A kernel whose result the doctor knows: eight times x -> x / 2 + 1.
//
// Source    none
// Work      1-D, one item per value; items past count return at once
// Reads     values  float[count]
// Writes    values  float[count]

__kernel void probe(__global float *restrict values, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) return;
    float x = values[i];
    for (int k = 0; k < 8; ++k) x = mad(x, 0.5f, 1.0f);
    values[i] = x;
}
