// Edge collapse, the last stage: each vertex that is left moves to where the triangles at it fit the input best.
//
// Source    ours; least squares of distances from planes as in Chen & Medioni, Object Modelling by Registration of Multiple
//           Range Images, 1992, solved by steps of a Jacobi iteration
// Work      functions only
// Reads     nothing
// Writes    nothing

#define FIT_NONE 0xFFFFFFFFu
#define FIT_LEAST 1e-36f // square of twice the area; below it a triangle has no plane
#define FIT_NOWHERE 1e30f // square of the distance from no triangle

// the other corners of corner c, in the triangle's order
static inline uint2 fit_others(const uint c)
{
    const uint k = c % 3, t = c - k;
    return (uint2)(t + (k + 1) % 3, t + (k + 2) % 3);
}
