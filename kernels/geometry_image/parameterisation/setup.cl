// Spherical parameterisation, set-up: move the vertices of one colour inside their stars so that the map stretches less.
//
// Source    Praun & Hoppe 2003, section 4 (one vertex at a time); Sander et al. 2001 (stretch); energy as in stars.py
// Work      1-D, one item per vertex of the colour: no two are neighbours, so no item reads what another writes
// Reads     vertices  uint  [vertex_count]       grouped by colour
//           starts    uint  [vertex_count + 1]   a vertex's first corner
//           after     uint  [corner_count]       next vertex in the corner's triangle
//           last      uint  [corner_count]       previous vertex
//           rest      double[4 * corner_count]   area / 16, squared edges after-last, last-own, own-after
// Writes    sphere    double[3 * all vertices]   unit length; read as well
// Defines   DOWNHILL_TRIALS RANDOM_TRIALS DOWNHILL_FACTOR STEP INVERSE_STRETCH

// float64 throughout: coarse triangles have determinants down to 1e-6 and none may be turned over
static inline double3 point(__global const double *sphere, const uint v)
{
    return (double3)(sphere[3 * v], sphere[3 * v + 1], sphere[3 * v + 2]);
}

static inline double along(const double3 a, const double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline double3 across(const double3 a, const double3 b)
{
    return (double3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double3 unit_or_zero(const double3 a)
{
    const double square = along(a, a);
    return square > 0.0 ? a / sqrt(square) : a;
}

typedef struct {
    __global const double *sphere;
    __global const uint *after;
    __global const uint *last;
    __global const double *rest;
    uint begin, end;
} Star;

static inline double star_energy(const Star star, const double3 a)
{
    double sum = 0.0;
    for (uint k = star.begin; k < star.end; ++k) {
        const double3 b = point(star.sphere, star.after[k]), c = point(star.sphere, star.last[k]);
        const double3 u = b - a, w = c - a, x = c - b, normal = across(u, w);
        const double m = along(normal, normal), det = along(a, normal);
        if (!(det > 1e-300 && m > 1e-40)) return INFINITY;
        const double area = star.rest[4 * k], l_bc = star.rest[4 * k + 1];
        const double l_ca = star.rest[4 * k + 2], l_ab = star.rest[4 * k + 3];
        const double bracket = along(u, w) * l_bc - along(u, x) * l_ca + along(w, x) * l_ab;
        sum += 8.0 * area * bracket / (sqrt(m) * det)
             + INVERSE_STRETCH / (256.0 * area)
                   * (along(u, u) * (l_bc + l_ca - l_ab) + along(x, x) * (l_ab + l_ca - l_bc)
                      + along(w, w) * (l_ab + l_bc - l_ca));
    }
    return sum;
}

static inline double3 star_gradient(const Star star, const double3 a)
{
    double3 sum = 0.0;
    for (uint k = star.begin; k < star.end; ++k) {
        const double3 b = point(star.sphere, star.after[k]), c = point(star.sphere, star.last[k]);
        const double3 u = b - a, w = c - a, x = c - b, normal = across(u, w);
        const double m = along(normal, normal), det = along(a, normal);
        if (!(det > 1e-300 && m > 1e-40)) continue;
        const double area = star.rest[4 * k], l_bc = star.rest[4 * k + 1];
        const double l_ca = star.rest[4 * k + 2], l_ab = star.rest[4 * k + 3];
        const double q = 8.0 * area / m, over_h = sqrt(m) / det;
        const double e = q * (along(u, w) * l_bc - along(u, x) * l_ca + along(w, x) * l_ab);
        const double3 turn = 2.0 * (along(u, w) * (u + w) - u * along(w, w) - w * along(u, u));
        sum += (q * (x * (l_ca - l_ab) - (u + w) * l_bc) - e / m * turn - e * (across(b, c) / det - turn / (2.0 * m)))
                   * over_h
             - INVERSE_STRETCH / (128.0 * area) * (u * (l_bc + l_ca - l_ab) + w * (l_ab + l_bc - l_ca));
    }
    return sum;
}

static inline double hashed(const uint key)
{
    uint z = key;
    z = (z ^ (z >> 16)) * 0x21F0AAADu;
    z = (z ^ (z >> 15)) * 0x735A2D97u;
    return (double)(z ^ (z >> 15)) / 2147483648.0 - 1.0;
}

__kernel void parameterisation_setup_star(
    __global const uint *restrict vertices,
    __global const uint *restrict starts,
    __global const uint *restrict after,
    __global const uint *restrict last,
    __global const double *restrict rest,
    __global double *sphere,
    const uint turn,
    const uint first,
    const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count) return;

    const uint v = vertices[first + i];
    const Star star = {sphere, after, last, rest, starts[first + i], starts[first + i + 1]};
    double3 here = point(sphere, v);
    double best = star_energy(star, here);
    double square = 0.0;
    for (uint k = star.begin; k < star.end; ++k) {
        const double3 spoke = point(sphere, after[k]) - here;
        square += along(spoke, spoke);
    }
    const double radius = STEP * sqrt(square / (double)(star.end - star.begin));

    const double3 slope = -star_gradient(star, here);
    double3 origin = here, direction = unit_or_zero(slope - here * along(slope, here));
    double scale = 1.0;
    for (uint k = 0; k < DOWNHILL_TRIALS; ++k, scale *= DOWNHILL_FACTOR) {
        const double3 trial = unit_or_zero(origin + direction * (scale * radius));
        const double energy = star_energy(star, trial);
        if (energy < best) { best = energy; here = trial; }
    }

    uint key = v * 2654435761u + turn * 40503u;
    double3 any;
    any.x = hashed(key += 0x9E3779B9u);
    any.y = hashed(key += 0x9E3779B9u);
    any.z = hashed(key += 0x9E3779B9u);
    origin = here;
    direction = unit_or_zero(any - here * along(any, here));
    for (uint k = 0; k < RANDOM_TRIALS; ++k) {
        const double3 trial = unit_or_zero(origin + direction * (radius * (k & 1 ? -1.0 : 1.0) / (double)(1u << (k >> 1))));
        const double energy = star_energy(star, trial);
        if (energy < best) { best = energy; here = trial; }
    }
    sphere[3 * v] = here.x;
    sphere[3 * v + 1] = here.y;
    sphere[3 * v + 2] = here.z;
}
