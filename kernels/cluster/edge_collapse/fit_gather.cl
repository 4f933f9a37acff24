// Edge collapse, the last stage: how far samples of the input are above the triangles nearest to them.
//
// Source    ours
// Work      1-D, one item per chunk of vertices; one sample against eight triangles at once
// Reads     places      float4[row_count]         output vertices, near 1
//           counts      uint[2]                   vertices, triangles of the output
//           owned, met  uint[map_count * (row_count + 1)]   the last part: where each vertex's samples and corners end
//           samples, ring                         as in fit_sort.cl
// Writes    sums        float8[3 * triangles out] of each row's samples: weights, then weights times heights above the
//                                                 triangle, for its vertex, the next one and the one before
// Needs     common/chunk.cl cluster/edge_collapse/fit.cl
// Plain     cluster/edge_collapse/fit_reference.py

#define FIT_GROUPS 4 // of eight triangles at a vertex; one with more has no samples
#define FIT_ALIKE 1.0001f // squares of distances are: nearest to the side between them, a sample counts for both

// eight triangles at a vertex: gradients of the shares of their next and previous vertices, unit normals, heights over the
// three sides, and something to be added to squares of distances from those that are none
typedef struct {
    float8 ax, ay, az, bx, by, bz, nx, ny, nz, own, next, last, none;
} FitEight;

static inline void fit_eight(FitEight *eight, __global const uint *ring, const uint count, const float3 p,
    __global const float4 *places)
{
    float8 x1 = 0.0f, y1 = 0.0f, z1 = 0.0f, x2 = 0.0f, y2 = 0.0f, z2 = 0.0f;
    float corners[6][8];
    vstore8(x1, 0, corners[0]), vstore8(x1, 0, corners[1]), vstore8(x1, 0, corners[2]);
    vstore8(x1, 0, corners[3]), vstore8(x1, 0, corners[4]), vstore8(x1, 0, corners[5]);
    for (uint i = 0; i < count; ++i) {
        const uint3 corner = vload3(i, ring);
        const float3 q = places[corner.y].xyz - p, r = places[corner.z].xyz - p;
        corners[0][i] = q.x, corners[1][i] = q.y, corners[2][i] = q.z;
        corners[3][i] = r.x, corners[4][i] = r.y, corners[5][i] = r.z;
    }
    x1 = vload8(0, corners[0]), y1 = vload8(0, corners[1]), z1 = vload8(0, corners[2]);
    x2 = vload8(0, corners[3]), y2 = vload8(0, corners[4]), z2 = vload8(0, corners[5]);
    const float8 nx = y1 * z2 - z1 * y2, ny = z1 * x2 - x1 * z2, nz = x1 * y2 - y1 * x2;
    const float8 square = nx * nx + ny * ny + nz * nz;
    const float8 over = square > FIT_LEAST ? 1.0f / square : (float8)(0.0f), unit = sqrt(over), length = sqrt(square);
    eight->none = square > FIT_LEAST ? (float8)(0.0f) : (float8)(FIT_NOWHERE);
    eight->nx = nx * unit, eight->ny = ny * unit, eight->nz = nz * unit;
    eight->ax = (y2 * nz - z2 * ny) * over, eight->ay = (z2 * nx - x2 * nz) * over, eight->az = (x2 * ny - y2 * nx) * over;
    eight->bx = (ny * z1 - nz * y1) * over, eight->by = (nz * x1 - nx * z1) * over, eight->bz = (nx * y1 - ny * x1) * over;
    const float8 dx = x2 - x1, dy = y2 - y1, dz = z2 - z1;
    eight->own = length / sqrt(fmax(dx * dx + dy * dy + dz * dz, (float8)(FIT_LEAST)));
    eight->next = length / sqrt(fmax(x2 * x2 + y2 * y2 + z2 * z2, (float8)(FIT_LEAST)));
    eight->last = length / sqrt(fmax(x1 * x1 + y1 * y1 + z1 * z1, (float8)(FIT_LEAST)));
}

// adds up what the samples of a vertex at p weigh, and how high they are, for the corners of each of its triangles; a
// constant number of groups keeps it all in registers
static inline __attribute__((always_inline)) void fit_sum(const FitEight *eights, const uint groups, __global const float4 *samples,
    const uint count, const uint every, const float3 p, float8 (*totals)[6])
{
    float8 square[FIT_GROUPS], next[FIT_GROUPS], before[FIT_GROUPS], height[FIT_GROUPS], sums[FIT_GROUPS][6];
    for (uint g = 0; g < groups; ++g)
        for (uint k = 0; k < 6; ++k) sums[g][k] = 0.0f;
    for (uint i = 0; i < count; i += every) {
        const float4 sample = samples[i];
        const float3 y = sample.xyz - p;
        float8 least = FIT_NOWHERE;
        for (uint g = 0; g < groups; ++g) {
            const FitEight *e = eights + g;
            next[g] = e->ax * y.x + e->ay * y.y + e->az * y.z;
            before[g] = e->bx * y.x + e->by * y.y + e->bz * y.z;
            height[g] = e->nx * y.x + e->ny * y.y + e->nz * y.z;
            const float8 inside = fmin((1.0f - next[g] - before[g]) * e->own,
                fmin(fmin(next[g] * e->next, before[g] * e->last), (float8)(0.0f)));
            square[g] = height[g] * height[g] + inside * inside + e->none;
            least = fmin(least, square[g]);
        }
        const float4 four = fmin(least.lo, least.hi);
        const float2 two = fmin(four.lo, four.hi);
        const float nearest = fmin(two.x, two.y);
        if (!(nearest < FIT_NOWHERE)) continue;
        for (uint g = 0; g < groups; ++g) {
            const float8 own = 1.0f - next[g] - before[g];
            const float8 a = fmax(next[g], (float8)(0.0f)), b = fmax(before[g], (float8)(0.0f));
            const float8 weight = square[g] <= nearest * FIT_ALIKE ? (float8)(sample.w) : (float8)(0.0f);
            const float8 share = own > 0.0f ? weight / (own + a + b) : (float8)(0.0f);
            const float8 high = share * height[g];
            sums[g][0] += own * share;
            sums[g][1] += a * share;
            sums[g][2] += b * share;
            sums[g][3] += own * high;
            sums[g][4] += a * high;
            sums[g][5] += b * high;
        }
    }
    for (uint g = 0; g < groups; ++g)
        for (uint k = 0; k < 6; ++k) totals[g][k] = sums[g][k];
}

// each sample of a vertex counts for the nearest of its triangles, unless it lies past the side opposite to the vertex
__kernel void edge_collapse_fit_gather(
    __global const float4 *restrict places,
    __global const uint *restrict counts,
    __global const uint *restrict owned,
    __global const uint *restrict met,
    __global const float4 *restrict samples,
    __global const uint *restrict ring,
    __global float8 *restrict sums,
    const uint every, // of so many samples of a vertex one is looked at
    const uint room,
    const uint row_count,
    const uint map_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || counts[1] > room) return;

    const size_t last = (size_t)(map_count - 1) * (row_count + 1);
    owned += last;
    met += last;
    const uint2 range = chunk_rows(chunk, chunk_count, counts[0]);
    for (uint v = range.x; v < range.y; ++v) {
        const uint start = v ? met[v - 1] : 0, corners = met[v] - start;
        const uint first = v ? owned[v - 1] : 0, past = owned[v];
        __global const uint *own = ring + 3 * (size_t)start;
        const uint groups = corners <= 8 * FIT_GROUPS ? (corners + 7) / 8 : 0;
        const float3 p = places[v].xyz;
        FitEight eights[FIT_GROUPS];
        float8 totals[FIT_GROUPS][6];
        for (uint g = 0; g < groups; ++g)
            fit_eight(eights + g, own + 24 * g, min(corners - 8 * g, 8u), p, places);
        if (groups == 1) fit_sum(eights, 1, samples + first, past - first, every, p, totals);
        else if (groups) fit_sum(eights, groups, samples + first, past - first, every, p, totals);
        for (uint g = 0; g < groups; ++g) {
            float planes[6][8];
            for (uint k = 0; k < 6; ++k) vstore8(totals[g][k], 0, planes[k]);
            for (uint i = 0; i < min(corners - 8 * g, 8u); ++i)
                sums[start + 8 * g + i] = (float8)(planes[0][i], planes[1][i], planes[2][i], planes[3][i],
                    planes[4][i], planes[5][i], 0.0f, 0.0f);
        }
        for (uint i = groups ? corners : 0; i < corners; ++i) sums[start + i] = 0.0f;
    }
}
