// A sine wave around the origin, raised along the normal: d(p) = a sin(f |p|), eight vertices at a time.
//
// Source    Boubekeur & Schlick 2005, section 4; the raised surface's normal is a reconstruction by the chain rule, which
//           takes the normal for constant
// Work      functions only; in steps, since the chain of one vector is too long for a core to begin the next meanwhile
// Reads     nothing
// Writes    nothing
// Needs     common/packed.cl, common/trigonometry.cl

// wave: amplitude in model units, waves per diagonal, phase in turns, 1 / diagonal
static inline planes8 wave_in_diagonals(const planes8 p, const float4 wave)
{
    const planes8 q = {p.x * wave.w, p.y * wave.w, p.z * wave.w};
    return q;
}

// f |p| in turns, and a f / |p|: how steep the wave is along p, but for its cosine
static inline void wave_phase(const planes8 p, const float4 wave, float8 *turns, float8 *steep)
{
    const planes8 q = wave_in_diagonals(p, wave);
    // off zero, where there is no direction: q takes the slope to 0 there
    const float8 square = max(fma(q.z, q.z, fma(q.y, q.y, q.x * q.x)), 1e-30f);
    const float8 inverse = float8_rsqrt(square);
    *turns = fma(square * inverse, (float8)(wave.y), (float8)(wave.z));
    *steep = inverse * (wave.x * wave.w * 6.28318531f * wave.y); // in this order finite for every model
}

// turns become the height above the surface, and steep gets its cosine
static inline void wave_height(float8 *turns, float8 *steep, const float4 wave)
{
    float8 sine, cosine;
    sine_cosine_of_turns(*turns, &sine, &cosine);
    *turns = sine * wave.x;
    *steep = *steep * cosine;
}

static inline planes8 wave_raised(const planes8 p, const planes8 n, const float8 height)
{
    const planes8 raised = {fma(height, n.x, p.x), fma(height, n.y, p.y), fma(height, n.z, p.z)};
    return raised;
}

// d(p) = a sin(f |p|) rises by g = a f cos(f |p|) p / |p|: N (1 + g N) - g is N less the tangential part of g
static inline planes8 wave_tilted(const planes8 p, const planes8 n, const float8 steep, const float4 wave)
{
    const planes8 q = wave_in_diagonals(p, wave);
    const planes8 g = {q.x * steep, q.y * steep, q.z * steep};
    const float8 along = fma(g.z, n.z, fma(g.y, n.y, fma(g.x, n.x, (float8)(1.0f))));
    const planes8 tilted = {fma(n.x, along, -g.x), fma(n.y, along, -g.y), fma(n.z, along, -g.z)};
    return planes8_normalise(tilted);
}
