// What raises vertices along their normals, eight at a time: a sine wave around the origin, d(p) = a sin(f |p|).
//
// Source    Boubekeur & Schlick 2005, section 4; the raised surface's normal is a reconstruction by the chain rule, which
//           takes the normal for constant
// Work      functions only; many vectors go through in steps, since the chain of one is too long for a core to begin the
//           next meanwhile
// Reads     nothing
// Writes    nothing
// Needs     common/packed.cl, common/trigonometry.cl
// Plain     refine/reference.py
// Defines   CHUNK (a multiple of eight: vertices that go through together at most)

typedef struct {
    float amplitude; // model units
    float waves;     // per diagonal
    float phase;     // turns
    float inverse;   // 1 / diagonal
} Displacement;

static inline planes8 displacement_in_diagonals(const planes8 p, const Displacement d)
{
    const planes8 q = {p.x * d.inverse, p.y * d.inverse, p.z * d.inverse};
    return q;
}

// f |p| in turns, and a f / |p|: how steep the wave is along p, but for its cosine
static inline void displacement_turns(const planes8 p, const Displacement d, float8 *turns, float8 *steep)
{
    const planes8 q = displacement_in_diagonals(p, d);
    // off zero, where there is no direction: q takes the slope to 0 there
    const float8 square = max(fma(q.z, q.z, fma(q.y, q.y, q.x * q.x)), 1e-30f);
    const float8 inverse = float8_rsqrt(square);
    *turns = fma(square * inverse, (float8)(d.waves), (float8)(d.phase));
    *steep = inverse * (d.amplitude * d.inverse * 6.28318531f * d.waves); // in this order finite for every model
}

// the height above the surface at so many turns; steep gets its cosine
static inline float8 displacement_height(const float8 turns, const Displacement d, float8 *steep)
{
    float8 sine, cosine;
    sine_cosine_of_turns(turns, &sine, &cosine);
    *steep = *steep * cosine;
    return sine * d.amplitude;
}

// d(p) rises by g = a f cos(f |p|) p / |p|: N (1 + g N) - g is N less the tangential part of g
static inline planes8 displacement_tilted(const planes8 p, const planes8 n, const float8 steep, const Displacement d)
{
    const planes8 q = displacement_in_diagonals(p, d);
    const planes8 g = {q.x * steep, q.y * steep, q.z * steep};
    const float8 along = fma(g.z, n.z, fma(g.y, n.y, fma(g.x, n.x, (float8)(1.0f))));
    const planes8 tilted = {fma(n.x, along, -g.x), fma(n.y, along, -g.y), fma(n.z, along, -g.z)};
    return planes8_normalise(tilted);
}

static inline planes8 displacement_raised(const planes8 p, const planes8 n, const float8 height)
{
    const planes8 raised = {fma(height, n.x, p.x), fma(height, n.y, p.y), fma(height, n.z, p.z)};
    return raised;
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    float8 turns, steep;
    displacement_turns(*p, d, &turns, &steep);
    const float8 height = displacement_height(turns, d, &steep);
    const planes8 tilted = displacement_tilted(*p, *n, steep, d);
    *p = displacement_raised(*p, *n, height);
    *n = tilted;
}

// up to CHUNK / 8 vectors, in place
static inline void displace_vectors(planes8 *p, planes8 *n, const uint vectors, const Displacement d)
{
    float8 height[CHUNK / 8], steep[CHUNK / 8];
    for (uint i = 0; i < vectors; ++i) displacement_turns(p[i], d, &height[i], &steep[i]);
    for (uint i = 0; i < vectors; ++i) height[i] = displacement_height(height[i], d, &steep[i]);
    for (uint i = 0; i < vectors; ++i) {
        const planes8 tilted = displacement_tilted(p[i], n[i], steep[i], d);
        p[i] = displacement_raised(p[i], n[i], height[i]);
        n[i] = tilted;
    }
}
