// The point of least summed quadric error, eight quadrics at once.
//
// Source    DeCoro & Tatarchuk 2007, slide 15; Lindstrom 2000 moves the solve to the mean; Tikhonov regularisation for his SVD
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     cluster/quadric_clustering/reference.py

typedef struct {
    float8 xx, xy, xz, yy, yz, zz; // A = sum of area/3 n n^T, cells^2
    float8 x, y, z;                // b, or A mean + b once moved to the mean
} quadric8;

typedef struct { float8 x, y, z; } quadric_point8;

// -(A + ridge I)^-1 g by L D L^T, and the product of the pivots, which is the determinant: cofactors would cancel in float32
static inline quadric_point8 quadric_step8(const quadric8 q, const float8 ridge, float8 *determinant)
{
    const float8 d0 = q.xx + ridge, r0 = 1.0f / d0;
    const float8 l10 = q.xy * r0, l20 = q.xz * r0;
    const float8 d1 = q.yy + ridge - l10 * q.xy, r1 = 1.0f / d1;
    const float8 e21 = q.yz - l20 * q.xy, l21 = e21 * r1;
    const float8 d2 = q.zz + ridge - l20 * q.xz - l21 * e21;
    const float8 u1 = q.y - l10 * q.x;
    const float8 u2 = q.z - l20 * q.x - l21 * u1;
    quadric_point8 s;
    s.z = -u2 / d2;
    s.y = -u1 * r1 - l21 * s.z;
    s.x = -q.x * r0 - l10 * s.y - l20 * s.z;
    *determinant = d0 * d1 * d2;
    return s;
}

// no comparison of a NaN is true: a step that went wrong counts as too long
static inline int8 quadric_short8(const quadric_point8 s, const float limit)
{
    return s.x * s.x + s.y * s.y + s.z * s.z <= limit * limit;
}

static inline int quadric_all8(const int8 mask)
{
    const int4 four = mask.lo & mask.hi;
    const int2 two = four.lo & four.hi;
    return two.x & two.y;
}
