// Edge collapse, fragment stage: quadrics about their own vertices, and where two of them meet best, eight pairs at once.
//
// Source    Garland & Heckbert 1997, section 5; about the vertex itself b and c of a new quadric are 0, and all sums are
//           of the size of an edge, which is what float32 needs
// Work      functions only
// Reads     nothing
// Writes    nothing

#define RIDGE 1e-6f  // of the trace: what a flat sum is solved with
#define TIE 1e-6f    // times trace times length^2: among equals, the short edge first
#define LEAST 1e-30f // a trace below it has no direction
#define LEVELLED 0.5f // of the volume that a collapse would take is made up for
#define FOLDED 0.1f   // square of the share of the area that is left of it where normals are added up

#define INLINE static inline __attribute__((always_inline))

// eight of f(x) = (x - p) A (x - p) + 2 b (x - p) + c, the weighted squares of distances from planes, about the vertex p
typedef struct {
    float8 xx, xy, xz, yy, yz, zz, bx, by, bz, c, px, py, pz;
} Quadrics;

// weight times the square of the distance from a plane through the vertex: A
INLINE float8 quadric_plane(const float3 n, const float weight)
{
    const float3 m = n * weight;
    return (float8)(m.x * n.x, m.x * n.y, m.x * n.z, m.y * n.y, m.y * n.z, m.z * n.z, 0.0f, 0.0f);
}

// the sums of two, about the points where they are least, near the middles; returns what they cost there
INLINE float8 quadric_merge(const Quadrics *u, const Quadrics *v, Quadrics *sum)
{
    const float8 dx = 0.5f * (v->px - u->px), dy = 0.5f * (v->py - u->py), dz = 0.5f * (v->pz - u->pz);
    // both about the middle: u's goes by d, v's by -d
    const float8 ux = u->bx + u->xx * dx + u->xy * dy + u->xz * dz;
    const float8 uy = u->by + u->xy * dx + u->yy * dy + u->yz * dz;
    const float8 uz = u->bz + u->xz * dx + u->yz * dy + u->zz * dz;
    const float8 vx = v->bx - v->xx * dx - v->xy * dy - v->xz * dz;
    const float8 vy = v->by - v->xy * dx - v->yy * dy - v->yz * dz;
    const float8 vz = v->bz - v->xz * dx - v->yz * dy - v->zz * dz;
    const float8 bx = ux + vx, by = uy + vy, bz = uz + vz;
    const float8 c = u->c + v->c + dx * (u->bx + ux - v->bx - vx) + dy * (u->by + uy - v->by - vy)
        + dz * (u->bz + uz - v->bz - vz);
    const float8 xx = u->xx + v->xx, xy = u->xy + v->xy, xz = u->xz + v->xz;
    const float8 yy = u->yy + v->yy, yz = u->yz + v->yz, zz = u->zz + v->zz;
    const float8 trace = xx + yy + zz, square = 4.0f * (dx * dx + dy * dy + dz * dz);
    // L D L^T of the sum with the ridge; pivots that rounding took below the ridge are the ridge
    const float8 ridge = RIDGE * fmax(trace, (float8)(LEAST));
    const float8 i0 = 1.0f / (xx + ridge);
    const float8 l1 = xy * i0, l2 = xz * i0;
    const float8 i1 = 1.0f / fmax(yy + ridge - l1 * xy, ridge);
    const float8 e = yz - l1 * xz;
    const float8 l3 = e * i1;
    const float8 i2 = 1.0f / fmax(zz + ridge - l2 * xz - l3 * e, ridge);
    const float8 w1 = l1 * bx - by, w2 = l2 * bx - bz - l3 * w1;
    float8 z = w2 * i2;
    float8 y = w1 * i1 - l3 * z;
    float8 x = -bx * i0 - l1 * y - l2 * z;
    const float8 far = x * x + y * y + z * z;
    // no step is longer than the edge; one that is no number is none
    const float8 back = sqrt(square / fmax(far, (float8)(LEAST)));
    const float8 step = far <= square ? (float8)(1.0f) : far < (float8)(INFINITY) ? back : (float8)(0.0f);
    x = step > 0.0f ? x * step : (float8)(0.0f);
    y = step > 0.0f ? y * step : (float8)(0.0f);
    z = step > 0.0f ? z * step : (float8)(0.0f);
    sum->bx = bx + xx * x + xy * y + xz * z;
    sum->by = by + xy * x + yy * y + yz * z;
    sum->bz = bz + xz * x + yz * y + zz * z;
    sum->c = fmax(c + x * (bx + sum->bx) + y * (by + sum->by) + z * (bz + sum->bz), (float8)(0.0f));
    sum->xx = xx;
    sum->xy = xy;
    sum->xz = xz;
    sum->yy = yy;
    sum->yz = yz;
    sum->zz = zz;
    sum->px = 0.5f * (u->px + v->px) + x;
    sum->py = 0.5f * (u->py + v->py) + y;
    sum->pz = 0.5f * (u->pz + v->pz) + z;
    return sum->c + TIE * trace * square;
}

// the first of the sums about a point that lies elsewhere by s
INLINE void quadric_move(Quadrics *sum, const float3 s)
{
    const float bx = sum->bx.s0, by = sum->by.s0, bz = sum->bz.s0;
    sum->bx.s0 += sum->xx.s0 * s.x + sum->xy.s0 * s.y + sum->xz.s0 * s.z;
    sum->by.s0 += sum->xy.s0 * s.x + sum->yy.s0 * s.y + sum->yz.s0 * s.z;
    sum->bz.s0 += sum->xz.s0 * s.x + sum->yz.s0 * s.y + sum->zz.s0 * s.z;
    const float more = s.x * (bx + sum->bx.s0) + s.y * (by + sum->by.s0) + s.z * (bz + sum->bz.s0);
    sum->c.s0 = fmax(sum->c.s0 + more, 0.0f);
    sum->px.s0 += s.x;
    sum->py.s0 += s.y;
    sum->pz.s0 += s.z;
}
