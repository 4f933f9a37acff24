// Borders of a KSQuad's grid, moved to the vertices that both sides have; and which of its dices face the eye.
//
// Source    reconstruction: a grid has no fewer segments than its borders, and a vertex on a border moves to the nearest of
//           the border's own; dices: Concheiro 2013, section 6.4.1
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     nurbs/rpns/grid.cl
// Plain     nurbs/rpns/sampling.py
// Defines   WATERTIGHT, DICES (0 leaves the functions of either out), NORMALS, RATIONAL

#pragma OPENCL FP_CONTRACT OFF

#if WATERTIGHT
// vertices of one border of a grid: `places` apart from `first`, n segments; the border itself has m, turned or not
static inline __attribute__((always_inline)) void rpns_border(__global float *positions, __global float *normals, const nurbs_surface *surface,
    __global const float *net, __global const float *five, __global const float *span, const uint across, const uint degree,
    const bool by_u, const uint step, const uint stride, const uint first, const uint apart, const uint n, const float4 factor,
    const uint turned, const float3 low, const float3 high)
{
    float4 curve[8];
    if (n > 1 && by_u) rpns_curve(curve, net, five, 0, across + 1, step, degree + 1, stride);
    const uint m = (uint)factor.x;
    const float8 lanes = (float8)(0, 1, 2, 3, 4, 5, 6, 7);
    float3 before = NORMALS ? vload3(first, normals) : low;
    for (uint begin = 1; begin < n; begin += 8) {
        int at[8];
        float points[3][8];
        const float8 k8 = fmin(lanes + (float)begin, (float8)((float)n)); // whole numbers below 2^24 all along
        const int8 nearest8 = convert_int8((2.0f * factor.x * k8 + (float)n) / (float)(2 * n));
        const int8 own8 = turned ? (int)m - nearest8 : nearest8;
        vstore8(nearest8, 0, at);
        rpns_basis basis;
        rpns_points sum = RPNS_NONE;
        rpns_basis_at(&basis, span, rpns_place(own8, factor.x, factor.yzw), degree);
        // in the order of a grid's own sums, along v first: neighbours with as many segments move nothing
        if (by_u) {
            for (uint l = 0; l <= degree; ++l) {
                RPNS_ADD(sum, basis.values[l], curve[l]);
                if (RATIONAL) sum.w = fma(basis.values[l], (float8)(curve[l].w), sum.w);
            }
        } else {
            for (uint k = 0; k <= across; ++k) {
                rpns_points column = RPNS_NONE;
                for (uint l = 0; l <= degree; ++l) {
                    const float4 here = vload4((size_t)l * stride + (size_t)k * step, net);
                    RPNS_ADD(column, basis.values[l], here);
                    if (RATIONAL) column.w = fma(basis.values[l], (float8)(here.w), column.w);
                }
                rpns_sum(&sum, (float8)(five[8 * k]), column);
            }
        }
        const float8 inverse = RATIONAL ? 1.0f / sum.w : (float8)(1.0f);
        vstore8(sum.x * inverse + surface->origin.x, 0, points[0]);
        vstore8(sum.y * inverse + surface->origin.y, 0, points[1]);
        vstore8(sum.z * inverse + surface->origin.z, 0, points[2]);
        for (uint lane = 0; lane < 8 && begin + lane < n; ++lane) {
            const uint k = begin + lane, vertex = first + k * apart, own = (uint)at[lane];
            const float3 inner = (float3)(points[0][lane], points[1][lane], points[2][lane]);
            vstore3(own == 0 ? low : own == m ? high : inner, vertex, positions);
#if NORMALS
            if (m == n) continue;
            // a vertex that moves has a normal between its own and its neighbour's
            const float3 here = vload3(vertex, normals), after = vload3(vertex + apart, normals);
            const float moved = (float)(own * n) - (float)(k * m); // in 1/m of a segment
            const float share = fabs(moved) / (float)m;
            if (moved != 0.0f && share < 1.0f) {
                const float3 sum = here + share * ((moved > 0.0f ? after : before) - here);
                const float square = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
                if (square > 1e-6f) vstore3(sum * (1.0f / sqrt(square)), vertex, normals);
            }
            before = here;
#endif
        }
    }
}
#endif

#if DICES
// three coordinates of eight vertices from the eye; where there are fewer the last stands in
static inline planes8 rpns_eight(__global const float *positions, const uint count, const float4 eye)
{
    planes8 found;
    if (count >= 8) {
        const float8 a = vload8(0, positions), b = vload8(1, positions), c = vload8(2, positions);
        found.x = (float8)(a.s036, b.s147, c.s25);
        found.y = (float8)(a.s147, b.s25, c.s036);
        found.z = (float8)(a.s25, b.s036, c.s147);
    } else {
        float lanes[3][8];
        for (uint lane = 0; lane < 8; ++lane)
            for (uint k = 0; k < 3; ++k) lanes[k][lane] = positions[3 * min(lane, count - 1) + k];
        found.x = vload8(0, lanes[0]), found.y = vload8(0, lanes[1]), found.z = vload8(0, lanes[2]);
    }
    found.x -= eye.x, found.y -= eye.y, found.z -= eye.z;
    return found;
}

static inline float8 rpns_turn(const planes8 a, const planes8 b, const planes8 c)
{
    return a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
}

// which dices of a grid have a triangle that faces the eye; how many
static inline uint rpns_facing(__global const float *positions, __global uchar *facing, const uint u, const uint v, const float4 eye)
{
    uint found = 0;
    for (uint i = 0; i < u; ++i)
        for (uint j = 0; j < v; j += 8) {
            const uint at = i * (v + 1) + j, count = min(v - j, 8u);
            planes8 corner[4];
            for (uint k = 0; k < 4; ++k) {
                const uint vertex = at + (k == 1 || k == 2 ? v + 1 : 0) + (k > 1);
                corner[k] = rpns_eight(positions + 3 * vertex, (u + 1) * (v + 1) - vertex, eye);
            }
            const int8 seen = (rpns_turn(corner[0], corner[1], corner[2]) < 0.0f)
                | (rpns_turn(corner[0], corner[2], corner[3]) < 0.0f);
            int lanes[8];
            vstore8(seen, 0, lanes);
            for (uint k = 0; k < count; ++k) {
                const uint stays = lanes[k] != 0 || !(eye.w > 0.0f);
                facing[at + k] = (uchar)stays, found += stays;
            }
        }
    return found;
}
#endif
