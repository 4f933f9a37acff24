// Curved PN triangles, set-up: the control points and normals of each triangle, from its corners and normals alone.
//
// Source    Vlachos et al. 2001, sections 3.1 (control points) and 3.3 (control normals)
// Work      1-D, one item per triangle
// Reads     corners       float[19 * triangle_count]  P0 P1 P2 N0 N1 N2, 1 where edge P1 P2 begins at P2; model units.
//                                                     Edges begin at their end of lower number, hence P0 is the lowest
// Writes    coefficients  float[76 * triangle_count]  as refine/cubic_surface.cl has them
// Needs     refine/cubic.cl
// Plain     refine/pn_triangles/reference.py
// Defines   LINEAR  1: normals interpolated linearly

__kernel void pn_triangles_setup(
    __global const float *restrict corners,
    __global float *restrict coefficients,
    const float scale, // a power of two that brings the model's size near 1
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count) return;

    __global const float *in = corners + 19 * (size_t)t;
    cubic_triangle c;
    for (uint k = 0; k < 3; ++k) {
        c.p[k] = vload3(k, in);
        c.n[k] = vload3(3 + k, in);
    }
    c.from_p2 = in[18] > 0.0f;
    c.bend01 = cubic_bend(c.p[0], c.p[1], c.n[0]), c.bend10 = cubic_bend(c.p[1], c.p[0], c.n[1]);
    c.bend12 = cubic_bend(c.p[1], c.p[2], c.n[1]), c.bend21 = cubic_bend(c.p[2], c.p[1], c.n[2]);
    c.bend20 = cubic_bend(c.p[2], c.p[0], c.n[2]), c.bend02 = cubic_bend(c.p[0], c.p[2], c.n[0]);
    c.middle01 = cubic_middle(c.p[0], c.p[1], c.n[0], c.n[1], scale);
    c.middle12 = cubic_middle(c.p[1], c.p[2], c.n[1], c.n[2], scale);
    c.middle20 = cubic_middle(c.p[2], c.p[0], c.n[2], c.n[0], scale);
    c.inner = cubic_inner(&c);
    cubic_store(&c, coefficients + COEFFICIENTS * (size_t)t);
}
