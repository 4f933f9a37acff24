// Are two surfaces nowhere farther apart than a bound? Each triangle of one is cut until every piece lies near one
// triangle of the other.
//
// Source    none, ours: the distance from a triangle is convex, so that a piece whose corners are near it is near it whole
// Work      1-D, one item per chunk of triangles; a piece against eight triangles at once
// Reads     points      float[3 * points]     in units of the diagonal, from the grid's corner
//           triangles   uint[3 * triangle_count]
//           others, other_triangles             the surface that the grid holds
//           cells, list                       as in within.cl
// Writes    far         uchar[triangle_count] is a corner of some piece of the triangle farther away?
// Needs     common/chunk.cl cluster/within.cl

#define WITHIN_DEEPEST 10 // cuts of a triangle into four, one in the other
#define WITHIN_GROUPS 12 // of eight triangles, known near a piece; where there are more, its parts look for them anew
#define WITHIN_NOWHERE 1e30f

// what is searched, and for which distance
typedef struct {
    __global const float *points;
    __global const uint *triangles, *cells, *list;
    float along, bound; // cells per unit
    int3 sides;
} Within;

typedef struct {
    float3 p, q, r;
    uint depth;
} WithinPiece;

// triangles near a piece: corners x, y, z of each eight
typedef struct {
    float lanes[WITHIN_GROUPS + 1][9][8];
    uint ids[8 * WITHIN_GROUPS + 8];
    uint count; // more than fit where some are not kept
} WithinKnown;

// squares of distances of points, x, y, z from the beginnings of segments
static inline float8 within_segments(const float8 x, const float8 y, const float8 z, const float8 dx, const float8 dy,
    const float8 dz)
{
    const float8 square = dx * dx + dy * dy + dz * dz, along = dx * x + dy * y + dz * z;
    const float8 share = fmin(fmax(along / fmax(square, (float8)(1e-37f)), (float8)(0.0f)), (float8)(1.0f));
    const float8 ox = x - dx * share, oy = y - dy * share, oz = z - dz * share;
    return ox * ox + oy * oy + oz * oz;
}

// squares of distances of a point from eight triangles; of those without area, from their edges
static inline float8 within_squares(const float3 p, const float (*lanes)[8])
{
    const float8 ax = vload8(0, lanes[0]), ay = vload8(0, lanes[1]), az = vload8(0, lanes[2]);
    const float8 bx = vload8(0, lanes[3]), by = vload8(0, lanes[4]), bz = vload8(0, lanes[5]);
    const float8 cx = vload8(0, lanes[6]), cy = vload8(0, lanes[7]), cz = vload8(0, lanes[8]);
    const float8 ux = bx - ax, uy = by - ay, uz = bz - az, vx = cx - bx, vy = cy - by, vz = cz - bz;
    const float8 wx = ax - cx, wy = ay - cy, wz = az - cz;
    const float8 nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const float8 px = p.x - ax, py = p.y - ay, pz = p.z - az, qx = p.x - bx, qy = p.y - by, qz = p.z - bz;
    const float8 rx = p.x - cx, ry = p.y - cy, rz = p.z - cz;
    const float8 u = (uy * pz - uz * py) * nx + (uz * px - ux * pz) * ny + (ux * py - uy * px) * nz;
    const float8 v = (vy * qz - vz * qy) * nx + (vz * qx - vx * qz) * ny + (vx * qy - vy * qx) * nz;
    const float8 w = (wy * rz - wz * ry) * nx + (wz * rx - wx * rz) * ny + (wx * ry - wy * rx) * nz;
    const float8 square = nx * nx + ny * ny + nz * nz, height = nx * px + ny * py + nz * pz;
    const float8 edges = fmin(within_segments(px, py, pz, ux, uy, uz),
        fmin(within_segments(qx, qy, qz, vx, vy, vz), within_segments(rx, ry, rz, wx, wy, wz)));
    const int8 inside = (square > 1e-36f) & (fmin(u, fmin(v, w)) >= 0.0f);
    return inside ? height * height / fmax(square, (float8)(1e-36f)) : edges;
}

static inline float within_least(const float8 squares)
{
    const float4 four = fmin(squares.lo, squares.hi);
    const float2 two = fmin(four.lo, four.hi);
    return fmin(two.x, two.y);
}

// is one of eight triangles near the whole piece? Squares of distances of the corners from the nearest go along
static inline bool within_eight(const WithinPiece *piece, const float (*lanes)[8], const float most, float8 *nearest)
{
    const float8 p = within_squares(piece->p, lanes), q = within_squares(piece->q, lanes), r = within_squares(piece->r, lanes);
    nearest[0] = fmin(nearest[0], p), nearest[1] = fmin(nearest[1], q), nearest[2] = fmin(nearest[2], r);
    return within_least(fmax(p, fmax(q, r))) <= most;
}

// are all three corners near some triangle?
static inline bool within_corners(const float8 *nearest, const float most)
{
    return within_least(nearest[0]) <= most && within_least(nearest[1]) <= most && within_least(nearest[2]) <= most;
}

// 2 where one known triangle is near the whole piece, 1 where each corner has one that is near, 0 where a corner has none
static inline uint within_known(const WithinKnown *known, const WithinPiece *piece, const float most)
{
    float8 nearest[3] = {WITHIN_NOWHERE, WITHIN_NOWHERE, WITHIN_NOWHERE};
    for (uint g = 0; 8 * g < known->count; ++g)
        if (within_eight(piece, known->lanes[g], most, nearest)) return 2;
    return within_corners(nearest, most) ? 1 : 0;
}

// the same of all triangles in the grid; those near the piece's box are known from then on
static inline uint within_search(const Within *g, const WithinPiece *piece, WithinKnown *known)
{
    const float3 low = fmin(piece->p, fmin(piece->q, piece->r)) - g->bound;
    const float3 high = fmax(piece->p, fmax(piece->q, piece->r)) + g->bound;
    const int3 first = within_cell(low, g->along, g->sides), last = within_cell(high, g->along, g->sides);
    const float most = g->bound * g->bound;
    float8 nearest[3] = {WITHIN_NOWHERE, WITHIN_NOWHERE, WITHIN_NOWHERE};
    uint count = 0;
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const uint cell = (z * g->sides.y + y) * g->sides.x + x, end = g->cells[cell];
                for (uint i = cell ? g->cells[cell - 1] : 0; i < end; ++i) {
                    const uint t = g->list[i];
                    const uint3 row = vload3(t, g->triangles);
                    const float3 a = vload3(row.x, g->points), b = vload3(row.y, g->points), c = vload3(row.z, g->points);
                    const float3 down = fmin(a, fmin(b, c)) - high, up = low - fmax(a, fmax(b, c));
                    if (fmax(fmax(fmax(down.x, down.y), down.z), fmax(fmax(up.x, up.y), up.z)) > 0.0f) continue;
                    uint again = 0;
                    for (uint k = 0; k < min(count, 8u * WITHIN_GROUPS); ++k) again |= known->ids[k] == t;
                    if (again) continue;
                    const uint at = min(count / 8, (uint)WITHIN_GROUPS), lane = count % 8;
                    known->ids[8 * at + lane] = t;
                    float (*to)[8] = known->lanes[at];
                    to[0][lane] = a.x, to[1][lane] = a.y, to[2][lane] = a.z;
                    to[3][lane] = b.x, to[4][lane] = b.y, to[5][lane] = b.z;
                    to[6][lane] = c.x, to[7][lane] = c.y, to[8][lane] = c.z;
                    ++count;
                    if (lane == 7 && within_eight(piece, to, most, nearest)) return 2;
                }
            }
    known->count = count;
    if (!count) return 0;
    if (count % 8) {
        float (*to)[8] = known->lanes[min(count / 8, (uint)WITHIN_GROUPS)];
        for (uint k = 0; k < 9; ++k)
            for (uint lane = count % 8; lane < 8; ++lane) to[k][lane] = to[k][0];
        if (within_eight(piece, to, most, nearest)) return 2;
    }
    return within_corners(nearest, most) ? 1 : 0;
}

// is all of a triangle near? Pieces no longer than `least` are taken by their corners
static inline bool within_whole(const Within *g, const float3 a, const float3 b, const float3 c, const float least)
{
    WithinPiece stack[3 * WITHIN_DEEPEST + 1];
    WithinKnown known;
    stack[0].p = a, stack[0].q = b, stack[0].r = c, stack[0].depth = 0;
    uint top = 1, from = 1; // pieces from there on are parts of the one that triangles are known for
    while (top) {
        --top;
        const WithinPiece piece = stack[top];
        const bool parts = top >= from;
        const uint near = parts ? within_known(&known, &piece, g->bound * g->bound) : within_search(g, &piece, &known);
        if (near == 2) continue;
        if (near == 0) return false;
        if (!parts) from = known.count <= 8 * WITHIN_GROUPS ? top : 3 * WITHIN_DEEPEST + 1;
        const float3 p = piece.p, q = piece.q, r = piece.r, u = q - p, v = r - q, w = p - r;
        if (piece.depth == WITHIN_DEEPEST || fmax(dot(u, u), fmax(dot(v, v), dot(w, w))) <= least * least) continue;
        const float3 pq = 0.5f * (p + q), qr = 0.5f * (q + r), rp = 0.5f * (r + p);
        for (uint k = 0; k < 4; ++k) stack[top + k].depth = piece.depth + 1;
        stack[top].p = p, stack[top].q = pq, stack[top].r = rp;
        stack[top + 1].p = q, stack[top + 1].q = qr, stack[top + 1].r = pq;
        stack[top + 2].p = r, stack[top + 2].q = rp, stack[top + 2].r = qr;
        stack[top + 3].p = qr, stack[top + 3].q = rp, stack[top + 3].r = pq;
        top += 4;
    }
    return true;
}

__kernel void cluster_within_pieces(
    __global const float *restrict points,
    __global const uint *restrict triangles,
    __global const float *restrict others,
    __global const uint *restrict other_triangles,
    __global const uint *restrict cells,
    __global const uint *restrict list,
    __global uchar *restrict far,
    const float along,
    const int3 sides,
    const float bound,
    const float least,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const Within grid = {others, other_triangles, cells, list, along, bound, sides};
    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 row = vload3(t, triangles);
        far[t] = !within_whole(&grid, vload3(row.x, points), vload3(row.y, points), vload3(row.z, points), least);
    }
}
