// Along smooth borders all patches have the first one's normals: they are copied, and so equal to the bit.
//
// Source    reconstruction: Concheiro 2013 leaves each patch its own
// Work      1-D, one item per pair; no source is a target
// Reads     pairs    uint [2 * pair_count]  vertex, and vertex whose normal it has
// Writes    normals  float[3 * vertices]    packed, unit length
// Plain     bezier/borders.py

__kernel void bezier_seams(__global const uint *restrict pairs, __global float *normals, const uint pair_count)
{
    const uint k = get_global_id(0);
    if (k >= pair_count) return;
    vstore3(vload3(pairs[2 * k + 1], normals), pairs[2 * k], normals);
}
