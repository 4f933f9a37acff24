// A sine wave around the origin: d(p) = a sin(f |p|).
//
// Source    Boubekeur & Schlick 2005, section 4
// Work      functions only; many vectors go through in steps, since the chain of one is too long for a core to begin the
//           next meanwhile
// Reads     nothing
// Writes    nothing
// Needs     common/displacement.cl, common/trigonometry.cl
// Plain     refine/displacement.py
// Defines   CHUNK as in common/displacement.cl

// f |p| in turns, and a f / |p|: how steep the wave is along p, but for its cosine
static inline void sine_turns(const planes8 p, const Displacement d, float8 *turns, float8 *steep)
{
    const planes8 q = displacement_in_diagonals(p, d);
    // off zero, where there is no direction: q takes the slope to 0 there
    const float8 square = max(fma(q.z, q.z, fma(q.y, q.y, q.x * q.x)), 1e-30f);
    const float8 inverse = float8_rsqrt(square);
    *turns = fma(square * inverse, (float8)(d.waves), (float8)(d.phase));
    *steep = inverse * (d.amplitude * d.inverse * 6.28318531f * d.waves); // in this order finite for every model
}

// the height above the surface at so many turns; steep gets its cosine
static inline float8 sine_height(const float8 turns, const Displacement d, float8 *steep)
{
    float8 sine, cosine;
    sine_cosine_of_turns(turns, &sine, &cosine);
    *steep = *steep * cosine;
    return sine * d.amplitude;
}

// d(p) rises by a f cos(f |p|) p / |p|
static inline planes8 sine_tilted(const planes8 p, const planes8 n, const float8 steep, const Displacement d)
{
    const planes8 q = displacement_in_diagonals(p, d);
    const planes8 g = {q.x * steep, q.y * steep, q.z * steep};
    return displacement_tilted(n, g);
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    float8 turns, steep;
    sine_turns(*p, d, &turns, &steep);
    const float8 height = sine_height(turns, d, &steep);
    const planes8 tilted = sine_tilted(*p, *n, steep, d);
    *p = displacement_raised(*p, *n, height);
    *n = tilted;
}

// up to CHUNK / 8 vectors, in place
static inline void displace_vectors(planes8 *p, planes8 *n, const uint vectors, const Displacement d)
{
    float8 height[CHUNK / 8], steep[CHUNK / 8];
    for (uint i = 0; i < vectors; ++i) sine_turns(p[i], d, &height[i], &steep[i]);
    for (uint i = 0; i < vectors; ++i) height[i] = sine_height(height[i], d, &steep[i]);
    for (uint i = 0; i < vectors; ++i) {
        const planes8 tilted = sine_tilted(p[i], n[i], steep[i], d);
        p[i] = displacement_raised(p[i], n[i], height[i]);
        n[i] = tilted;
    }
}
