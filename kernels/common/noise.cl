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

// the hashes of a cell's eight corners, in bits of their number x y z, eight cells at a time
static inline void noise_hashes(const int8 i, const int8 j, const int8 k, __global const uint *table, int hashes[8][8])
{
    int cells[3][8];
    vstore8(i & 255, 0, cells[0]);
    vstore8(j & 255, 0, cells[1]);
    vstore8(k & 255, 0, cells[2]);
    for (uint lane = 0; lane < 8; ++lane) {
        const uint x = cells[0][lane], y = cells[1][lane], z = cells[2][lane];
        const uint a = table[x] + y, b = table[x + 1] + y;
        const uint aa = table[a] + z, ab = table[a + 1] + z, ba = table[b] + z, bb = table[b + 1] + z;
        hashes[0][lane] = table[aa], hashes[1][lane] = table[ba];
        hashes[2][lane] = table[ab], hashes[3][lane] = table[bb];
        hashes[4][lane] = table[aa + 1], hashes[5][lane] = table[ba + 1];
        hashes[6][lane] = table[ab + 1], hashes[7][lane] = table[bb + 1];
    }
}

// one of the twelve directions from the middle of a cube to its edges, and in w how far (x, y, z) lies along it
static inline fours8 noise_gradient(const int8 hash, const float8 x, const float8 y, const float8 z)
{
    const int8 h = hash & 15, one = as_int8((float8)(1.0f));
    const int8 u = one ^ (h << 31), v = one ^ ((h & 2) << 30); // 1 or -1 by the low two bits
    const int8 low = h < 8, lowest = h < 4, again = (h == 12) | (h == 14);
    fours8 g;
    g.x = as_float8((u & low) | (v & again)); // never both
    g.y = as_float8(u & ~low) + as_float8(v & lowest);
    g.z = as_float8(v & ~(lowest | again));
    g.w = fma(g.z, z, fma(g.y, y, g.x * x));
    return g;
}

static inline float8 noise_mix(const float8 a, const float8 b, const float8 t) { return fma(t, b - a, a); }

static inline fours8 noise_mixed(const fours8 a, const fours8 b, const float8 t)
{
    const fours8 m = {noise_mix(a.x, b.x, t), noise_mix(a.y, b.y, t), noise_mix(a.z, b.z, t), noise_mix(a.w, b.w, t)};
    return m;
}

static inline float8 noise_fade(const float8 t) { return t * t * t * fma(t, fma(t, (float8)(6.0f), (float8)(-15.0f)), (float8)(10.0f)); }
static inline float8 noise_slope(const float8 t) { return 30.0f * t * t * fma(t, t - 2.0f, (float8)(1.0f)); }

// the noise at q, -1 to 1, in w, and its gradient
static inline fours8 noise_at(const planes8 q, __global const uint *table)
{
    const float8 cx = floor(q.x), cy = floor(q.y), cz = floor(q.z);
    const float8 x = q.x - cx, y = q.y - cy, z = q.z - cz;
    int hashes[8][8];
    noise_hashes(convert_int8(cx), convert_int8(cy), convert_int8(cz), table, hashes);
    fours8 g[8];
    for (uint corner = 0; corner < 8; ++corner)
        g[corner] = noise_gradient(vload8(0, hashes[corner]), corner & 1 ? x - 1.0f : x, corner & 2 ? y - 1.0f : y,
            corner & 4 ? z - 1.0f : z);
    const float8 u = noise_fade(x), v = noise_fade(y), w = noise_fade(z);
    const fours8 near_low = noise_mixed(g[0], g[1], u), near_high = noise_mixed(g[2], g[3], u);
    const fours8 far_low = noise_mixed(g[4], g[5], u), far_high = noise_mixed(g[6], g[7], u);
    const fours8 near = noise_mixed(near_low, near_high, v), far = noise_mixed(far_low, far_high, v);
    fours8 sum = noise_mixed(near, far, w);
    // the blend changes too: along x by the differences of the corners, along y and z by those of what was blended
    const float8 along_x = noise_mix(
        noise_mix(g[1].w - g[0].w, g[3].w - g[2].w, v), noise_mix(g[5].w - g[4].w, g[7].w - g[6].w, v), w);
    const float8 along_y = noise_mix(near_high.w - near_low.w, far_high.w - far_low.w, w);
    sum.x = fma(noise_slope(x), along_x, sum.x);
    sum.y = fma(noise_slope(y), along_y, sum.y);
    sum.z = fma(noise_slope(z), far.w - near.w, sum.z);
    return sum;
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    planes8 q = displacement_in_diagonals(*p, d);
    const float8 far = (float8)(NOISE_FARTHEST);
    q.x = max(min(q.x * d.waves, far), -far);
    q.y = max(min(q.y * d.waves, far), -far);
    q.z = max(min(fma(q.z, (float8)(d.waves), (float8)(d.phase)), far), -far);
    fours8 sum = noise_at(q, d.table);
    if (TURBULENT) {
        const int8 sign = as_int8(sum.w) & (int)0x80000000;
        sum.x = as_float8(as_int8(sum.x) ^ sign), sum.y = as_float8(as_int8(sum.y) ^ sign);
        sum.z = as_float8(as_int8(sum.z) ^ sign), sum.w = as_float8(as_int8(sum.w) ^ sign);
    }
    float lower = 1.0f;
    for (uint octave = 1; octave < OCTAVES; ++octave) {
        q.x *= 2.0f, q.y *= 2.0f, q.z *= 2.0f, lower *= 0.5f;
        const fours8 one = noise_at(q, d.table);
        const int8 sign = TURBULENT ? as_int8(one.w) & (int)0x80000000 : (int8)(0);
        sum.w = fma(as_float8(as_int8(one.w) ^ sign), (float8)(lower), sum.w);
        sum.x += as_float8(as_int8(one.x) ^ sign); // twice as fine and half as high: as steep
        sum.y += as_float8(as_int8(one.y) ^ sign);
        sum.z += as_float8(as_int8(one.z) ^ sign);
    }
    const float steep = d.amplitude * d.inverse * d.waves;
    const planes8 g = {sum.x * steep, sum.y * steep, sum.z * steep};
    *p = displacement_raised(*p, *n, sum.w * d.amplitude);
    *n = displacement_tilted(*n, g);
}

static inline void displace_vectors(planes8 *p, planes8 *n, const uint vectors, const Displacement d)
{
    for (uint i = 0; i < vectors; ++i) displace_eight(&p[i], &n[i], d);
}
