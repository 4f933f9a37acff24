// Scalar tagged triangles, set-up: control points and normals of each triangle, from its corners, normals and tags.
//
// Source    Boubekeur, Reuter & Schlick 2005; Boubekeur & Schlick 2005, appendix B: a reconstruction (ST-R)
// Work      1-D, one item per triangle
// Reads     corners       float[19 * triangle_count]  P0 P1 P2 N0 N1 N2, 1 where edge P1 P2 begins at P2; model units.
//                                                     Edges begin at their end of lower number, hence P0 is the lowest
//           tags          float[9 * triangle_count]   tension of P0, P1, P2; sharpness of edges P0 P1, P1 P2, P2 P0;
//                                                     their bias
// Writes    coefficients  float[76 * triangle_count]  as refine/cubic_surface.cl has them
// Needs     refine/cubic.cl
// Plain     refine/st_triangles/reference.py

#define QUARTER_TURN_HALVED 0.78539816f // the most that a bias turns a crease

// the normal of this face's side of an edge at one end: pulled towards the face by the edge's sharpness, turned about it
static inline float3 st_side(const float3 normal, const float3 face, const float3 axis, const float sharp, const float turn)
{
    if (sharp == 0.0f) return normal;
    const float3 pulled = cubic_unit(normal * (1.0f - sharp) + face * sharp, face);
    const float angle = sharp * turn * QUARTER_TURN_HALVED;
    const float c = cos(angle), s = sin(angle);
    const float along = cubic_dot(axis, pulled) * (1.0f - c);
    const float3 across = (float3)(axis.y * pulled.z - axis.z * pulled.y, axis.z * pulled.x - axis.x * pulled.z,
        axis.x * pulled.y - axis.y * pulled.x);
    return pulled * c + across * s + axis * along;
}

// where two edges of a face meet: the mean of its sides' normals
static inline float3 st_corner(
    const float3 normal, const float3 one, const float3 other, const float sharp_one, const float sharp_other)
{
    return sharp_one == 0.0f && sharp_other == 0.0f ? normal : cubic_unit(one + other, normal);
}

__kernel void st_triangles_setup(
    __global const float *restrict corners,
    __global const float *restrict tags,
    __global float *restrict coefficients,
    const float scale, // a power of two that brings the model's size near 1
    const uint triangle_count)
{
    const uint t = get_global_id(0);
    if (t >= triangle_count) return;

    __global const float *in = corners + 19 * (size_t)t;
    float3 p[3], n[3];
    for (uint k = 0; k < 3; ++k) {
        p[k] = vload3(k, in);
        n[k] = vload3(3 + k, in);
    }
    const float3 tension = vload3(0, tags + 9 * (size_t)t);
    const float3 sharpness = vload3(1, tags + 9 * (size_t)t), bias = vload3(2, tags + 9 * (size_t)t);
    cubic_triangle c;
    c.from_p2 = in[18] > 0.0f;
    for (uint k = 0; k < 3; ++k) c.p[k] = p[k];

    const float3 loose = (float3)(1.0f) - tension;
    c.bend01 = cubic_bend(p[0], p[1], n[0]) * loose.x, c.bend10 = cubic_bend(p[1], p[0], n[1]) * loose.y;
    c.bend12 = cubic_bend(p[1], p[2], n[1]) * loose.y, c.bend21 = cubic_bend(p[2], p[1], n[2]) * loose.z;
    c.bend20 = cubic_bend(p[2], p[0], n[2]) * loose.z, c.bend02 = cubic_bend(p[0], p[2], n[0]) * loose.x;

    const float sharp01 = sharpness.x, sharp12 = sharpness.y, sharp20 = sharpness.z;
    // about an edge both of its faces turn the same way in space: its axis runs from its end of lower number
    const float3 zero = (float3)(0.0f);
    const float3 d01 = (p[1] - p[0]) * scale, d02 = (p[2] - p[0]) * scale, d12 = (p[2] - p[1]) * scale;
    const float3 axis01 = cubic_unit(d01, zero), axis20 = cubic_unit(d02, zero);
    const float3 axis12 = cubic_unit(c.from_p2 ? -d12 : d12, zero);
    const float3 face = cubic_unit((float3)(d01.y * d02.z - d01.z * d02.y, d01.z * d02.x - d01.x * d02.z,
        d01.x * d02.y - d01.y * d02.x), cubic_unit(n[0] + n[1] + n[2], n[0]));

    const float3 n01 = st_side(n[0], face, axis01, sharp01, bias.x), n10 = st_side(n[1], face, axis01, sharp01, bias.x);
    const float3 n12 = st_side(n[1], face, axis12, sharp12, bias.y), n21 = st_side(n[2], face, axis12, sharp12, bias.y);
    const float3 n20 = st_side(n[2], face, axis20, sharp20, bias.z), n02 = st_side(n[0], face, axis20, sharp20, bias.z);
    c.n[0] = st_corner(n[0], n01, n02, sharp01, sharp20);
    c.n[1] = st_corner(n[1], n12, n10, sharp12, sharp01);
    c.n[2] = st_corner(n[2], n20, n21, sharp20, sharp12);
    c.middle01 = cubic_middle(p[0], p[1], n01, n10, scale);
    c.middle12 = cubic_middle(p[1], p[2], n12, n21, scale);
    c.middle20 = cubic_middle(p[2], p[0], n20, n02, scale);

    c.inner = cubic_inner(&c);
    const float sharp = (sharp01 + sharp12 + sharp20) * THIRD;
    if (sharp > 0.0f) {
        const float3 flattened = cubic_mean(&c, 1.0f - sharp01, 1.0f - sharp12, 1.0f - sharp20);
        c.inner = c.inner * (1.0f - sharp) + flattened * sharp;
    }
    cubic_store(&c, coefficients + COEFFICIENTS * (size_t)t);
}
