// What a cell's two coarse triangles emit: the vertices of their masks, points and normals, eight at a time.
//
// Source    Concheiro 2013, section 3.3 (the geometry shader evaluates and emits what was inserted)
// Work      functions only. Sums are those of bezier/patch.cl: a vertex is the same to the bit whichever triangle emits it,
//           and on a border the same as the neighbour's
// Reads     controls, sources          as bezier/cell.cl has them
// Writes    positions  float[3 * vertex_room]  packed; triangle after triangle, row after row
//           normals    float[3 * vertex_room]  packed, unit length; nothing where NORMALS is 0
//           counts     uint [2]                vertices, triangles; zeros where there is no room
// Needs     bezier/cell.cl
// Plain     bezier/candidates.py
// Defines   NORMALS (1: normals too)

#pragma OPENCL FP_CONTRACT OFF

#define CELL_VERTICES 96 // of both triangles, up to a whole vector

// triangles of a mask with so many vertices, some of which are among the nodes on `edges`
static inline uint bezier_faces(const uint vertices, const ulong mask, const ulong edges)
{
    return 2 * vertices - 2 - (uint)popcount(mask & edges);
}

// is there room for all? The first item writes how much there is, or nothing
static inline bool bezier_fits(__global uint *counts, const uint vertices, const uint triangles, const uint vertex_room,
    const uint triangle_room, const uint item)
{
    const bool fits = vertices <= vertex_room && triangles <= triangle_room;
    if (item == 0) vstore2(fits ? (uint2)(vertices, triangles) : (uint2)(0), 0, counts);
    return fits;
}

// differences of a patch's rows, scaled
static inline void bezier_steps(float16 *steps, const bezier_patch *patch)
{
    for (uint k = 0; k < 3; ++k) steps[k] = (patch->rows[k + 1] - patch->rows[k]) * patch->scale;
}

// points at (u, v) of a patch, and unit normals
static inline void bezier_at8(planes8 *point, planes8 *normal, const bezier_patch *patch, const float16 *steps,
    const float8 u, const float8 v)
{
    const float8 s = 1.0f - u, t = 1.0f - v, uu = u * u, ss = s * s, vv = v * v, tt = t * t;
    const float8 u0 = ss * s, u1 = ss * (3.0f * u), u2 = uu * (3.0f * s), u3 = uu * u;
    const float8 v0 = tt * t, v1 = tt * (3.0f * v), v2 = vv * (3.0f * t), v3 = vv * v;
    const float *P = (const float *)patch->rows, *D = (const float *)steps;
    planes8 along_u, along_v;
    float8 *const to = &point->x, *const across = &along_u.x, *const along = &along_v.x;
    for (uint axis = 0; axis < 3; ++axis) {
        float8 c[4], q[4];
        for (uint j = 0; j < 4; ++j) {
            const float *p = P + 4 * j + axis, *d = D + 4 * j + axis;
            c[j] = BEZIER_CUBIC(u0, u1, u2, u3, p[0], p[16], p[32], p[48]);
            if (NORMALS) q[j] = BEZIER_QUADRATIC(ss, 2.0f * s * u, uu, d[0], d[16], d[32]);
        }
        to[axis] = BEZIER_CUBIC(v0, v1, v2, v3, c[0], c[1], c[2], c[3]);
        if (!NORMALS) continue;
        across[axis] = BEZIER_CUBIC(v0, v1, v2, v3, q[0], q[1], q[2], q[3]);
        along[axis] = BEZIER_QUADRATIC(tt, 2.0f * t * v, vv, (c[1] - c[0]) * patch->scale, (c[2] - c[1]) * patch->scale,
            (c[3] - c[2]) * patch->scale);
    }
#if NORMALS
    const int8 is_bad = normals_cross8(normal, along_u, along_v);
    if (normals_any(is_bad)) bezier_mend8(normal, is_bad, patch, u, v);
#endif
}

// the first `count` of eight, at most
static inline void bezier_write8(__global float *restrict out, const planes8 a, const uint count)
{
    const packed8 rows = packed_rows(a);
    if (count >= 8) {
        vstore8(rows.first, 0, out), vstore8(rows.second, 1, out), vstore8(rows.third, 2, out);
    } else {
        float some[24];
        vstore8(rows.first, 0, some), vstore8(rows.second, 1, some), vstore8(rows.third, 2, some);
        for (uint k = 0; k < 3 * count; ++k) out[k] = some[k];
    }
}

// the samples of the cell under the vertices of both masks; returns how many
static inline uint bezier_samples(uchar *samples, const ulong2 masks)
{
    uint count = 0;
    for (uint t = 0; t < 2; ++t) {
        const ulong mask = t ? masks.y : masks.x;
        const uint way = bezier_way(mask);
        const bool is_half = way >= FIRST_HALF;
        const uint4 corners = bezier_corners(is_half ? 0 : way);
        for (uint r = 0; r < (is_half ? HALF_ROWS : CELL_SIDE); ++r)
            for (uint left = is_half ? bezier_half_row(mask, r) : bezier_row_bits(mask, r); left; left &= left - 1, ++count) {
                const uint c = bezier_lowest(left);
                samples[count] = (uchar)(is_half ? bezier_half_sample(way, r, c) : bezier_sample(corners, r, c));
            }
    }
    return count;
}

// vertices at samples of cell `number`, from vertex `first` on
static inline void bezier_emit_at(__global float *restrict positions, __global float *restrict normals,
    __global const float *restrict controls, __global const uint *restrict sources, const uint number,
    const uchar *samples, const uint count, const uint first, const uint side)
{
    const bezier_cell cell = bezier_cell_of(number, (side - 1) / CELL);
    bezier_patch patch;
    bezier_patch_at(&patch, controls, cell.patch);
    float16 steps[3];
    bezier_steps(steps, &patch);
    float u[CELL_VERTICES], v[CELL_VERTICES];
    const uint last = side - 1;
    const float step = 1.0f / (float)last; // exact: a power of two
    for (uint k = 0; k < count; ++k) {
        const uint at = samples[k];
        u[k] = (float)(cell.i + at / CELL_SIDE) * step, v[k] = (float)(cell.j + at % CELL_SIDE) * step;
    }
    for (uint k = count; k % 8; ++k) u[k] = v[k] = 0.5f;
    for (uint k = 0; k < count; k += 8) {
        planes8 p, n;
        bezier_at8(&p, &n, &patch, steps, vload8(0, u + k), vload8(0, v + k));
        bezier_write8(positions + 3 * (size_t)(first + k), p, count - k);
#if NORMALS
        bezier_write8(normals + 3 * (size_t)(first + k), n, count - k);
#endif
    }
#if NORMALS
    if (cell.i && cell.j && cell.i + CELL < last && cell.j + CELL < last) return;
    for (uint k = 0; k < count; ++k) {
        if (u[k] > 0.0f && u[k] < 1.0f && v[k] > 0.0f && v[k] < 1.0f) continue;
        float2 where;
        const uint owner = bezier_source(
            &where, sources, cell.patch, (uint)(u[k] * (float)last), (uint)(v[k] * (float)last), last);
        if (owner == cell.patch && where.x == u[k] && where.y == v[k]) continue;
        bezier_patch_at(&patch, controls, owner);
        bezier_steps(steps, &patch);
        planes8 p, n;
        bezier_at8(&p, &n, &patch, steps, (float8)(where.x), (float8)(where.y));
        vstore3((float3)(n.x.s0, n.y.s0, n.z.s0), first + k, normals);
    }
#endif
}

// vertices of both masks of cell `number`, from vertex `first` on
static inline void bezier_emit(__global float *restrict positions, __global float *restrict normals,
    __global const float *restrict controls, __global const uint *restrict sources, const uint number,
    const ulong2 masks, const uint first, const uint side)
{
    uchar samples[CELL_VERTICES];
    const uint count = bezier_samples(samples, masks);
    bezier_emit_at(positions, normals, controls, sources, number, samples, count, first, side);
}
