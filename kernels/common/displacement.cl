// What raises vertices along their normals, eight at a time: a height d(p) over the place of the undisplaced point.
//
// Source    Boubekeur & Schlick 2005, section 4; the raised surface's normal is a reconstruction by the chain rule, which
//           takes the normal for constant: N less the tangential part of the height's gradient
// Work      functions only; the height itself is that of common/sine.cl or common/noise.cl, joined in front of a surface: each
//           gives `displace_eight` and `displace_vectors`
// Reads     table  uint[512]  of the noise: 0 to 255 in a scattered order, twice
// Writes    nothing
// Needs     common/packed.cl
// Plain     refine/displacement.py
// Defines   CHUNK (a multiple of eight: vertices that go through together at most)

typedef struct {
    float amplitude; // model units
    float waves;     // per diagonal
    float phase;     // turns of the sine, or how far the noise has moved
    float inverse;   // 1 / diagonal
    __global const uint *table;
} Displacement;

static inline planes8 displacement_in_diagonals(const planes8 p, const Displacement d)
{
    const planes8 q = {p.x * d.inverse, p.y * d.inverse, p.z * d.inverse};
    return q;
}

static inline planes8 displacement_raised(const planes8 p, const planes8 n, const float8 height)
{
    const planes8 raised = {fma(height, n.x, p.x), fma(height, n.y, p.y), fma(height, n.z, p.z)};
    return raised;
}

// N (1 + g N) - g is N less the tangential part of the gradient g
static inline planes8 displacement_tilted(const planes8 n, const planes8 g)
{
    const float8 along = fma(g.z, n.z, fma(g.y, n.y, fma(g.x, n.x, (float8)(1.0f))));
    const planes8 tilted = {fma(n.x, along, -g.x), fma(n.y, along, -g.y), fma(n.z, along, -g.z)};
    return planes8_normalise(tilted);
}
