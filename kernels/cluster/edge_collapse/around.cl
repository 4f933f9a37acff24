// Edge collapse, geometry stage: the triangles at an edge's ends, eight at once: how far they turn, and what is below them.
//
// Source    Lindstrom & Turk, Fast and Memory Efficient Polygonal Simplification, 1998 (volume)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/edge_collapse/edges.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// places of eight triangles' corners
typedef struct {
    fours8 end, x, y;
} Around;

// of `around` from a row on
INLINE void around_read(const Block *b, const uint first, Around *eight)
{
    uint end[8], x[8], y[8];
    for (uint i = 0; i < 8; ++i) {
        const ushort4 row = b->around[first + i];
        end[i] = row.x;
        x[i] = row.y;
        y[i] = row.z;
    }
    eight->end = block_columns(b->places, 1, end);
    eight->x = block_columns(b->places, 1, x);
    eight->y = block_columns(b->places, 1, y);
}

// normals times twice the area, with the end at a place
INLINE void around_normals(const Around *a, const float8 x, const float8 y, const float8 z, fours8 *n)
{
    const float8 ax = a->x.x - x, ay = a->x.y - y, az = a->x.z - z, cx = a->y.x - x, cy = a->y.y - y, cz = a->y.z - z;
    n->x = ay * cz - az * cy;
    n->y = az * cx - ax * cz;
    n->z = ax * cy - ay * cx;
}

INLINE float around_sum(const float8 a)
{
    const float4 four = a.lo + a.hi;
    const float2 two = four.lo + four.hi;
    return two.x + two.y;
}

// would a triangle around the edge turn by more than the limit, with the ends at p? Those without area may do as they like
INLINE bool around_turn(const Block *b, const float3 p, const float limit)
{
    for (uint first = 0; first < b->rest; first += 8) {
        Around a;
        fours8 n, m;
        around_read(b, first, &a);
        around_normals(&a, a.end.x, a.end.y, a.end.z, &n);
        around_normals(&a, p.x, p.y, p.z, &m);
        const float8 nn = n.x * n.x + n.y * n.y + n.z * n.z, mm = m.x * m.x + m.y * m.y + m.z * m.z;
        const float8 nm = n.x * m.x + n.y * m.y + n.z * m.z;
        const int8 keeps = (nm > 0.0f) & (nm * nm >= limit * nn * mm);
        const int8 counts = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int8)(b->rest - first);
        const ulong4 turns = as_ulong4((nn > 0.0f) & counts & ~keeps);
        if (turns.x | turns.y | turns.z | turns.w) return true;
    }
    return false;
}

// half of the volume is made up for that a collapse would take from, or add to, what is below the surface: planes of the
// mesh as it has become leave bends too flat. Not where the surface folds back on itself
INLINE void around_level(Block *b, const uint u, const uint v, Quadrics *merged)
{
    for (uint i = 0; i < b->both; ++i) b->around[b->rest + i] = b->around[LAST - i];
    const uint count = b->rest + b->both;
    for (uint i = count; i < count + 8; ++i) b->around[i] = (ushort4)(u, u, u, 0); // without area
    const float3 p = (float3)(merged->px.s0, merged->py.s0, merged->pz.s0);
    const float3 edge = b->places[v].xyz - b->places[u].xyz;
    float8 x = 0.0f, y = 0.0f, z = 0.0f, volumes = 0.0f, areas = 0.0f;
    for (uint first = 0; first < count; first += 8) {
        Around a;
        fours8 n;
        around_read(b, first, &a);
        around_normals(&a, a.end.x, a.end.y, a.end.z, &n);
        x += n.x, y += n.y, z += n.z;
        volumes += n.x * (a.end.x - p.x) + n.y * (a.end.y - p.y) + n.z * (a.end.z - p.z);
        areas += sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    }
    const float3 normal = (float3)(around_sum(x), around_sum(y), around_sum(z));
    const float square = dot(normal, normal), area = around_sum(areas);
    if (!(square > FOLDED * area * area)) return;
    const float3 s = normal * (LEVELLED * around_sum(volumes) / square);
    if (dot(s, s) < dot(edge, edge)) quadric_move(merged, s);
}
