// Along smooth borders all patches have the first one's normals: they are copied, and so equal to the bit.
//
// Source    reconstruction: Concheiro 2013 leaves each patch its own
// Work      1-D, one item per 32 pairs; no source is a target
// Reads     pairs    uint [2 * pair_count]  vertex, and vertex whose normal it has
// Writes    normals  float[3 * vertices]    packed, unit length
// Plain     bezier/borders.py

__kernel void bezier_seams(__global const uint *restrict pairs, __global float *normals, const uint pair_count)
{
    const uint first = get_global_id(0) * 32;
    if (first >= pair_count) return;
    const uint end = min(first + 32, pair_count);
    for (uint k = first; k < end; ++k) vstore3(vload3(pairs[2 * k + 1], normals), pairs[2 * k], normals);
}
