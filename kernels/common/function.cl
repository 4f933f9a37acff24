// A function of the user's as the height: float displace(float3 position, float3 normal, float2 uv, float time).
//
// Source    Boubekeur & Schlick 2005, section 4 (procedural displacement); that its gradient is taken by central differences
//           along two tangents is a reconstruction, the tangents are those of Duff et al. 2017, Building an Orthonormal
//           Basis, Revisited
// Work      functions only; five calls of the function for each vertex, lane by lane. Zeros lose their sign before: the two
//           sides of an edge hand it the same bits
// Reads     nothing
// Writes    nothing
// Needs     common/displacement.cl
// Plain     refine/function.py
// Defines   CHUNK, ATTRIBUTES as in common/displacement.cl: none, or u, v and the gradients of both, per diagonal

#pragma OPENCL FP_CONTRACT OFF

#define FUNCTION_STEEPEST 1e9f // rises beyond count as this: their squares are finite

// x y z of points, x y z of normals, u, v
typedef struct {
    float8 of[8];
} function_places;

static inline void function_heights(const function_places *at, const float time, float8 *heights)
{
    float in[8][8], out[8];
    for (uint k = 0; k < 8; ++k) vstore8(at->of[k] + 0.0f, 0, in[k]);
    for (uint lane = 0; lane < 8; ++lane)
        out[lane] = function_called((float3)(in[0][lane], in[1][lane], in[2][lane]),
            (float3)(in[3][lane], in[4][lane], in[5][lane]), (float2)(in[6][lane], in[7][lane]), time);
    *heights = vload8(0, out);
}

// two unit vectors across n and each other, functions of n alone
static inline void function_tangents(const planes8 n, planes8 *across)
{
    const float8 one = (float8)(1.0f);
    const float8 sign = float8_pick(n.z < 0.0f, -one, one); // alike for zeros of either sign
    const float8 a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    across[0].x = fma(sign * n.x, n.x * a, one), across[0].y = sign * b, across[0].z = -sign * n.x;
    across[1].x = b, across[1].y = fma(n.y, n.y * a, sign), across[1].z = -n.y;
}

// height and gradient at p; the gradient lies across n, and is zero where the function has no finite one
static inline void function_at(const planes8 p, const planes8 n, const Displacement *d, float8 *height, planes8 *gradient)
{
    planes8 across[2];
    function_tangents(n, across);
    function_places at = {{p.x, p.y, p.z, n.x, n.y, n.z, (float8)(0.0f), (float8)(0.0f)}};
#if ATTRIBUTES
    at.of[6] = d->at[0], at.of[7] = d->at[1];
#endif
    float8 heights[5];
    for (uint k = 0; k < 5; ++k) {
        function_places moved = at;
        if (k) {
            const planes8 t = across[(k - 1) / 2];
            const float8 step = (float8)(k & 1 ? d->amplitude : -d->amplitude);
            moved.of[0] = fma(step, t.x, p.x), moved.of[1] = fma(step, t.y, p.y), moved.of[2] = fma(step, t.z, p.z);
#if ATTRIBUTES
            const float8 part = step * d->inverse;
            for (uint i = 0; i < 2; ++i) {
                const float8 *g = d->at + 2 + 3 * i;
                moved.of[6 + i] = fma(part, fma(t.z, g[2], fma(t.y, g[1], t.x * g[0])), at.of[6 + i]);
            }
#endif
        }
        function_heights(&moved, d->phase, &heights[k]);
    }
    const float per_step = 0.5f / d->amplitude;
    const float8 most = (float8)(FUNCTION_STEEPEST);
    float8 rise[2];
    for (uint i = 0; i < 2; ++i) {
        const float8 rises = (heights[1 + 2 * i] - heights[2 + 2 * i]) * per_step;
        rise[i] = float8_pick(rises == rises, max(min(rises, most), -most), (float8)(0.0f));
    }
    *height = heights[0];
    gradient->x = fma(rise[1], across[1].x, rise[0] * across[0].x);
    gradient->y = fma(rise[1], across[1].y, rise[0] * across[0].y);
    gradient->z = fma(rise[1], across[1].z, rise[0] * across[0].z);
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    float8 height;
    planes8 gradient;
    function_at(*p, *n, &d, &height, &gradient);
    *p = displacement_raised(*p, *n, height);
    *n = displacement_tilted(*n, gradient);
}

static inline void displace_vectors(planes8 *p, planes8 *n, const uint vectors, const Displacement d)
{
    for (uint i = 0; i < vectors; ++i) displace_eight(&p[i], &n[i], d);
}
