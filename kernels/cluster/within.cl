// Are two surfaces nowhere farther apart than a bound? Each triangle of one is cut until every piece lies near one
// triangle of the other, which a grid over those finds.
//
// Source    none, ours: the distance from a triangle is convex, so that a piece whose corners are near it is near it whole
// Work      count, fill, pieces: 1-D, one item per chunk of triangles
// Reads     points      float[3 * points]     in units of the diagonal, from the grid's corner
//           triangles   uint[3 * triangle_count]
//           others, other_triangles             the surface that the grid holds
//           list        uint[]                its triangles, cell by cell
// Writes    cells       uint[cells]           triangles of each; scanned and filled, where each cell's list ends
//           list
//           far         uchar[triangle_count] is a corner of some piece of the triangle farther away?
// Needs     common/chunk.cl

#define DEEPEST 10 // cuts of a triangle into four, one in the other

static inline int3 within_cell(const float3 p, const float along, const int3 cells)
{
    return clamp(convert_int3(clamp(p * along, 0.0f, 1e6f)), (int3)(0), cells - 1);
}

// the triangle's cells among those of its box: those that its plane goes through; counts them or lists it there
static inline void within_enter(const uint t, const float3 a, const float3 b, const float3 c, const float along,
    const int3 cells, __global uint *counts, __global uint *list)
{
    const int3 low = within_cell(fmin(a, fmin(b, c)), along, cells), high = within_cell(fmax(a, fmax(b, c)), along, cells);
    const float3 n = cross(b - a, c - a);
    const float reach = (0.5001f * (fabs(n.x) + fabs(n.y) + fabs(n.z)) + 1e-30f) / along;
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const float3 middle = ((float3)(x, y, z) + 0.5f) / along;
                if (low.x != high.x && low.y != high.y && low.z != high.z && fabs(dot(n, middle - a)) > reach) continue;
                const uint at = atomic_inc(counts + ((z * cells.y + y) * cells.x + x));
                if (list) list[at] = t;
            }
}

__kernel void cluster_within_count(
    __global const float *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict cells,
    const float along, // cells per unit
    const int3 sides,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 row = vload3(t, triangles);
        within_enter(t, vload3(row.x, points), vload3(row.y, points), vload3(row.z, points), along, sides, cells, 0);
    }
}

__kernel void cluster_within_fill(
    __global const float *restrict points,
    __global const uint *restrict triangles,
    __global uint *restrict cells,
    __global uint *restrict list,
    const float along,
    const int3 sides,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;
    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint3 row = vload3(t, triangles);
        within_enter(t, vload3(row.x, points), vload3(row.y, points), vload3(row.z, points), along, sides, cells, list);
    }
}

// of a point from a segment
static inline float within_segment(const float3 p, const float3 a, const float3 b)
{
    const float3 ab = b - a, ap = p - a;
    const float square = dot(ab, ab), share = square > 0.0f ? clamp(dot(ap, ab) / square, 0.0f, 1.0f) : 0.0f;
    const float3 off = ap - ab * share;
    return dot(off, off);
}

// square of the distance; of a triangle without area, from its edges
static inline float within_square(const float3 p, const float3 a, const float3 b, const float3 c)
{
    const float3 n = cross(b - a, c - a), ap = p - a;
    const float square = dot(n, n);
    if (square > 1e-36f && dot(cross(b - a, ap), n) >= 0.0f && dot(cross(c - b, p - b), n) >= 0.0f
        && dot(cross(a - c, p - c), n) >= 0.0f) {
        const float height = dot(n, ap);
        return height * height / square;
    }
    return fmin(within_segment(p, a, b), fmin(within_segment(p, b, c), within_segment(p, c, a)));
}

typedef struct {
    __global const float *points;
    __global const uint *triangles, *cells, *list;
    float along, bound;
    int3 sides;
} Within;

// 2 where one triangle is near all three, 1 where some is near the first, 0 where none is
static inline uint within_near(const Within *g, const float3 p, const float3 q, const float3 r)
{
    const int3 low = within_cell(p - g->bound, g->along, g->sides), high = within_cell(p + g->bound, g->along, g->sides);
    const float most = g->bound * g->bound;
    uint near = 0;
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const uint cell = (z * g->sides.y + y) * g->sides.x + x, end = g->cells[cell];
                for (uint i = cell ? g->cells[cell - 1] : 0; i < end; ++i) {
                    const uint3 row = vload3(g->list[i], g->triangles);
                    const float3 a = vload3(row.x, g->points), b = vload3(row.y, g->points), c = vload3(row.z, g->points);
                    if (within_square(p, a, b, c) > most) continue;
                    if (within_square(q, a, b, c) <= most && within_square(r, a, b, c) <= most) return 2;
                    near = 1;
                }
            }
    return near;
}

// is all of a triangle near? Pieces shorter than `least` are taken by their corners
static inline bool within_whole(const Within *g, const float3 a, const float3 b, const float3 c, const float least)
{
    float3 stack[3 * DEEPEST + 1][3];
    uint depths[3 * DEEPEST + 1], top = 1;
    stack[0][0] = a, stack[0][1] = b, stack[0][2] = c;
    depths[0] = 0;
    while (top) {
        --top;
        const float3 p = stack[top][0], q = stack[top][1], r = stack[top][2];
        const uint depth = depths[top], near = within_near(g, p, q, r);
        if (near == 2) continue;
        if (near == 0 || !within_near(g, q, r, p) || !within_near(g, r, p, q)) return false;
        const float3 u = q - p, v = r - q, w = p - r;
        if (depth == DEEPEST || fmax(dot(u, u), fmax(dot(v, v), dot(w, w))) <= least * least) continue;
        const float3 pq = 0.5f * (p + q), qr = 0.5f * (q + r), rp = 0.5f * (r + p);
        for (uint k = 0; k < 4; ++k) depths[top + k] = depth + 1;
        stack[top][0] = p, stack[top][1] = pq, stack[top][2] = rp;
        stack[top + 1][0] = q, stack[top + 1][1] = qr, stack[top + 1][2] = pq;
        stack[top + 2][0] = r, stack[top + 2][1] = rp, stack[top + 2][2] = qr;
        stack[top + 3][0] = qr, stack[top + 3][1] = rp, stack[top + 3][2] = pq;
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
