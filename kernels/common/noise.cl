// Gradient noise in space: d(p) = a times a sum of octaves, each twice as fine and half as high as the one before.
//
// Source    Perlin 2002, Improving Noise (fade 6 t^5 - 15 t^4 + 10 t^3, twelve gradients); Boubekeur & Schlick 2005,
//           section 4 for noise as a displacement
// Work      functions only; OCTAVES of them, TURBULENT 1 sums their absolute values
// Reads     nothing
// Writes    nothing
// Needs     common/displacement.cl
// Plain     refine/displacement.py
// Defines   CHUNK as in common/displacement.cl, OCTAVES, TURBULENT

#pragma OPENCL FP_CONTRACT OFF

#define NOISE_FARTHEST 1e9f // lattice cells from the origin: beyond, floats have no fractions anyway

// one of the twelve directions from the middle of a cube to its edges
static inline float3 noise_gradient(const uint hash)
{
    const uint h = hash & 15;
    const float one = h & 1 ? -1.0f : 1.0f, two = h & 2 ? -1.0f : 1.0f;
    const bool again = h == 12 || h == 14;
    return (float3)((h < 8 ? one : 0.0f) + (again ? two : 0.0f), (h < 8 ? 0.0f : one) + (h < 4 ? two : 0.0f),
        h < 4 || again ? 0.0f : two);
}

static inline float noise_dot(const float3 a, const float x, const float y, const float z)
{
    return a.x * x + a.y * y + a.z * z;
}

// the noise at q, -1 to 1, and its gradient
static inline float4 noise_at(const float3 q, __global const uint *table)
{
    const float3 cell = (float3)(floor(q.x), floor(q.y), floor(q.z));
    const float x = q.x - cell.x, y = q.y - cell.y, z = q.z - cell.z;
    const uint i = (uint)(int)cell.x & 255, j = (uint)(int)cell.y & 255, k = (uint)(int)cell.z & 255;
    const uint a = table[i] + j, b = table[i + 1] + j;
    const uint aa = table[a] + k, ab = table[a + 1] + k, ba = table[b] + k, bb = table[b + 1] + k;
    const float3 g0 = noise_gradient(table[aa]), g1 = noise_gradient(table[ba]), g2 = noise_gradient(table[ab]);
    const float3 g3 = noise_gradient(table[bb]), g4 = noise_gradient(table[aa + 1]), g5 = noise_gradient(table[ba + 1]);
    const float3 g6 = noise_gradient(table[ab + 1]), g7 = noise_gradient(table[bb + 1]);
    const float n0 = noise_dot(g0, x, y, z), n1 = noise_dot(g1, x - 1, y, z), n2 = noise_dot(g2, x, y - 1, z);
    const float n3 = noise_dot(g3, x - 1, y - 1, z), n4 = noise_dot(g4, x, y, z - 1);
    const float n5 = noise_dot(g5, x - 1, y, z - 1), n6 = noise_dot(g6, x, y - 1, z - 1);
    const float n7 = noise_dot(g7, x - 1, y - 1, z - 1);
    const float u = x * x * x * (x * (x * 6 - 15) + 10), v = y * y * y * (y * (y * 6 - 15) + 10);
    const float w = z * z * z * (z * (z * 6 - 15) + 10);
    const float du = 30 * x * x * (x * (x - 2) + 1), dv = 30 * y * y * (y * (y - 2) + 1);
    const float dw = 30 * z * z * (z * (z - 2) + 1);
    // the trilinear blend by powers of u, v and w
    const float ku = n1 - n0, kv = n2 - n0, kw = n4 - n0, kuv = n0 - n1 - n2 + n3, kvw = n0 - n2 - n4 + n6;
    const float kuw = n0 - n1 - n4 + n5, kuvw = n1 + n2 - n3 + n4 - n5 - n6 + n7 - n0;
    const float3 blend = g0 + (g1 - g0) * u + (g2 - g0) * v + (g4 - g0) * w + (g0 - g1 - g2 + g3) * (u * v) +
                         (g0 - g2 - g4 + g6) * (v * w) + (g0 - g1 - g4 + g5) * (u * w) +
                         (g1 + g2 - g3 + g4 - g5 - g6 + g7 - g0) * (u * v * w);
    return (float4)(blend.x + du * (ku + kuv * v + kuw * w + kuvw * v * w),
        blend.y + dv * (kv + kuv * u + kvw * w + kuvw * u * w), blend.z + dw * (kw + kvw * v + kuw * u + kuvw * u * v),
        n0 + ku * u + kv * v + kw * w + kuv * u * v + kvw * v * w + kuw * u * w + kuvw * u * v * w);
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    const planes8 q = displacement_in_diagonals(*p, d);
    float x[8], y[8], z[8], height[8], gx[8], gy[8], gz[8];
    const float8 far = (float8)(NOISE_FARTHEST);
    vstore8(max(min(q.x * d.waves, far), -far), 0, x);
    vstore8(max(min(q.y * d.waves, far), -far), 0, y);
    vstore8(max(min(fma(q.z, (float8)(d.waves), (float8)(d.phase)), far), -far), 0, z);
    for (uint lane = 0; lane < 8; ++lane) {
        float4 sum = (float4)(0.0f);
        float finer = 1.0f, lower = 1.0f;
        for (uint octave = 0; octave < OCTAVES; ++octave) {
            float4 one = noise_at((float3)(x[lane], y[lane], z[lane]) * finer, d.table);
            if (TURBULENT && one.w < 0.0f) one = -one;
            sum.w += one.w * lower;
            sum.x += one.x, sum.y += one.y, sum.z += one.z; // finer times lower is one
            finer *= 2.0f, lower *= 0.5f;
        }
        height[lane] = sum.w, gx[lane] = sum.x, gy[lane] = sum.y, gz[lane] = sum.z;
    }
    const float steep = d.amplitude * d.inverse * d.waves;
    const planes8 g = {vload8(0, gx) * steep, vload8(0, gy) * steep, vload8(0, gz) * steep};
    *p = displacement_raised(*p, *n, vload8(0, height) * d.amplitude);
    *n = displacement_tilted(*n, g);
}

static inline void displace_vectors(planes8 *p, planes8 *n, const uint vectors, const Displacement d)
{
    for (uint i = 0; i < vectors; ++i) displace_eight(&p[i], &n[i], d);
}
