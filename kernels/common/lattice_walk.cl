// A walk along the vertices of a triangular pattern, written as points and unit normals in whole vectors of eight.
//
// Source    Boubekeur & Schlick 2005, section 3.2 (barycentric pattern)
// Work      functions only; a surface is what is joined before this file: a type `lattice_surface` and
//
//               void    lattice_surface_of(lattice_surface *, __global const float *, size_t)   of a triangle
//               planes8 lattice_point(const lattice_surface *, float8 u, float8 v)         weights of P1 and P2
//               planes8 lattice_normal(const lattice_surface *, float8 u, float8 v)        of any length
//               planes8 lattice_edge_point(const lattice_surface *, float8 t)              the edge P1 P2 from its end of
//               planes8 lattice_edge_normal(const lattice_surface *, float8 t)             lower number on, exact at both
//               bool    lattice_from_p2(const lattice_surface *)                           is that end P2?
//
//           Neighbours agree to the bit where lattice_point at v = 0, at u = 0 and lattice_edge_point are the same sums
//           of the same numbers, each from the edge's end of lower number: P0 is the lowest of its triangle
// Reads     pattern    float[2 * stride]  planes of u and v, 0..1, at least eight more than there are vertices; the
//                                         vertices of edge P1 P2 come last
// Writes    positions  float[3 * vertices]
//           normals    float[3 * vertices]
// Needs     common/packed.cl, common/displacement.cl
// Defines   CHUNK (a multiple of eight: vertices of a work-item), DISPLACED (1: by what stands in front), ATTRIBUTES
//           (common/displacement.cl), STREAMING (common/packed.cl)

#pragma OPENCL FP_CONTRACT OFF

typedef struct {
    __global const float *weights;
    uint stride;
    uint last_row; // the first vertex of edge P1 P2
} lattice_pattern;

// eight vertices from the pattern's k on, some of which may be of the last row
static inline void lattice_eight(
    const lattice_pattern pattern, const lattice_surface *s, const Displacement d, const uint k, planes8 *p, planes8 *n)
{
    const float8 u = vload8(0, pattern.weights + k), v = vload8(0, pattern.weights + pattern.stride + k);
    const int8 is_last = (int8)(k) + (int8)(0, 1, 2, 3, 4, 5, 6, 7) >= (int8)(pattern.last_row);
    const float8 t = lattice_from_p2(s) ? u : v;
    *p = planes8_pick(is_last, lattice_edge_point(s, t), lattice_point(s, u, v));
    *n = planes8_normalise(planes8_pick(is_last, lattice_edge_normal(s, t), lattice_normal(s, u, v)));
#if DISPLACED
    Displacement here = d;
#if ATTRIBUTES
    displacement_inside(&here, u, v);
    displacement_on_edge(&here, is_last, t, lattice_from_p2(s));
#endif
    displace_eight(p, n, here);
#endif
}

// whole vectors before the last row: `positions`, `normals` and the pattern's `k` at the first, `count` vertices
static inline void lattice_inside(const lattice_pattern pattern, const lattice_surface *s, const Displacement d,
    const uint k, const uint count, __global float *restrict positions, __global float *restrict normals)
{
    __global const float *restrict us = pattern.weights + k;
    __global const float *restrict vs = us + pattern.stride;
    const uint vectors = count / 8;
    // one stream of stores at a time: whole cache lines leave the core
#if DISPLACED
    planes8 p[CHUNK / 8], n[CHUNK / 8];
    for (uint i = 0; i < vectors; ++i) {
        const float8 u = vload8(i, us), v = vload8(i, vs);
        p[i] = lattice_point(s, u, v);
        n[i] = planes8_normalise(lattice_normal(s, u, v));
#if ATTRIBUTES
        Displacement here = d;
        displacement_inside(&here, u, v);
        displace_eight(&p[i], &n[i], here);
#endif
    }
#if !ATTRIBUTES
    displace_vectors(p, n, vectors, d);
#endif
    for (uint i = 0; i < vectors; ++i) packed_store8(p[i], positions + 24 * i);
    for (uint i = 0; i < vectors; ++i) packed_store8(n[i], normals + 24 * i);
#else
    for (uint i = 0; i < vectors; ++i)
        packed_store8(lattice_point(s, vload8(i, us), vload8(i, vs)), positions + 24 * i);
    for (uint i = 0; i < vectors; ++i)
        packed_store8(planes8_normalise(lattice_normal(s, vload8(i, us), vload8(i, vs))), normals + 24 * i);
#endif
}

// `count` output vertices from `vertex` on, of one triangle; the first is the pattern's k
static inline void lattice_walk(const lattice_pattern pattern, const lattice_surface *s, const Displacement d,
    const uint k, const ulong vertex, const uint count, packed_stage *stage, __global float *restrict positions,
    __global float *restrict normals)
{
    const uint to_vector = min(count, -(uint)vertex & 7u);
    const uint before = min(count, pattern.last_row - min(k, pattern.last_row));
    const uint inside = before > to_vector ? (before - to_vector) & ~7u : 0;
    if (inside) {
        const ulong at = 3 * (vertex + to_vector);
        lattice_inside(pattern, s, d, k + to_vector, inside, positions + at, normals + at);
    }
    // what is left: before the first whole vector, and after the last
    uint at = to_vector ? 0 : inside;
    while (at < count) {
        const uint taken = min(8 - ((uint)(vertex + at) & 7), count - at);
        planes8 p, n;
        lattice_eight(pattern, s, d, k + at, &p, &n);
        packed_stage_put(stage, p, n, taken, vertex + at, positions, normals);
        at += at < to_vector ? taken + inside : taken;
    }
}
