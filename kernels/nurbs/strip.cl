// Points of surfaces without weights, tile after tile of their grids: control rows are summed along v for all rows of a
// tile at once, and each row of points is a sum of those.
//
// Source    Concheiro 2013, section 6.2, in the order of a tensor product: what is left for a row is the same for each of
//           its floats, wherever spans of v end
// Work      1-D, one item per tile: some rows of a surface's grid
// Reads     tiles      uint [3 * tile_count]      surface, first row, rows
//           surfaces   uint [16 * surface_count]  as nurbs/surface.cl has them
//           samples    uint [4 * samples]         as nurbs/surface.cl has them
//           weights    float[15 * stride]         as nurbs/basis.cl writes them; eight more than samples
//           controls   float[4 * controls]        as nurbs/surface.cl has them
// Writes    positions  float[3 * vertices]        packed; surface after surface, v fastest
// Needs     nurbs/surface.cl
// Plain     nurbs/reference.py
// Defines   TILE_COLUMNS (most columns of a grid), NORMALS (0), RATIONAL (0), STREAMING (0)

#pragma OPENCL FP_CONTRACT OFF

#define ABREAST 8    // rows of points that share what is read of control rows
#define STRIP_ROWS 8 // control rows that a span of degree 7 has
#define STRIP_FLOATS ((3 * TILE_COLUMNS + 39) & ~15) // whole vectors are stored, the last one past the end
#define TILE_WORDS 3

// x y z x y z ... of each column of a tile
typedef struct __attribute__((aligned(64))) {
    float points[STRIP_ROWS][STRIP_FLOATS]; // control row c at c % 8, counted from the origin
    float steps[STRIP_ROWS][STRIP_FLOATS];  // and what it has more than row c - 1
    float base[STRIP_FLOATS];               // the span's first control row, where it lies
    float origin[STRIP_FLOATS];
    uint first, end; // the span's first control row, and that from which on none is there yet
} nurbs_strip_rows;

// control row c at `count` columns of one span from number j of the tile on, of samples whose basis functions are `weights`
static inline __attribute__((always_inline)) void nurbs_strip_span(nurbs_strip_rows *strip, __global const float *net,
    __global const float *weights, const uint stride, const uint q, const uint c, const uint j, const uint count)
{
    const float *before = strip->points[(c + STRIP_ROWS - 1) % STRIP_ROWS];
    float *row = strip->points[c % STRIP_ROWS], *step = strip->steps[c % STRIP_ROWS];
    float4 points[STRIP_ROWS];
    for (uint l = 0; l <= q; ++l) points[l] = vload4(l, net);
    for (uint k = 0; k < count; k += 8) {
        const uint f = 3 * (j + k);
        const float8 zero = (float8)(0.0f);
        planes8 sum = {zero, zero, zero};
        for (uint l = 0; l <= q; ++l) {
            const float8 n = vload8(0, weights + k + l * stride);
            sum.x = fma(n, (float8)(points[l].x), sum.x);
            sum.y = fma(n, (float8)(points[l].y), sum.y);
            sum.z = fma(n, (float8)(points[l].z), sum.z);
        }
        const packed8 packed = packed_rows(sum);
        vstore8(packed.first - vload8(0, before + f), 0, step + f), vstore8(packed.first, 0, row + f);
        vstore8(packed.second - vload8(1, before + f), 1, step + f), vstore8(packed.second, 1, row + f);
        vstore8(packed.third - vload8(2, before + f), 2, step + f), vstore8(packed.third, 2, row + f);
    }
}

// control row c at all columns
static inline void nurbs_strip_row(nurbs_strip_rows *strip, const nurbs_surface *surface, const nurbs_tables *tables,
    const uint c, const uint columns)
{
    for (uint j = 0, count; j < columns; j += count) {
        const uint sample = surface->sample_v + j, stride = tables->stride, q = surface->q;
        const uint4 at = vload4(sample, tables->samples);
        __global const float *net = tables->controls + 4 * (surface->control + c * surface->control_columns + at.x);
        __global const float *weights = tables->weights + sample;
        count = min(at.y - sample, columns - j);
        if (q == 3) nurbs_strip_span(strip, net, weights, stride, 3, c, j, count);
        else nurbs_strip_span(strip, net, weights, stride, q, c, j, count);
    }
}

// the control rows of the span of u that begins with row `first`; what the span before had is kept
static inline void nurbs_strip_to(nurbs_strip_rows *strip, const nurbs_surface *surface, const nurbs_tables *tables,
    const uint first, const uint columns)
{
    float *row = strip->points[first % STRIP_ROWS];
    if (strip->first == first) return;
    if (strip->end <= first) { // no row is there, nor one before it
        strip->end = first;
        float *before = strip->points[(first + STRIP_ROWS - 1) % STRIP_ROWS];
        for (uint f = 0; f < STRIP_FLOATS; f += 8) vstore8((float8)(0.0f), 0, before + f);
    }
    strip->first = first;
    for (; strip->end <= first + surface->p; ++strip->end)
        nurbs_strip_row(strip, surface, tables, strip->end, columns);
    for (uint f = 0; f < 3 * columns; f += 8)
        vstore8(vload8(0, row + f) + vload8(0, strip->origin + f), 0, strip->base + f);
}

// `count` rows of points, eight floats at a time, the last of which may be among those before: each is that of the first
// control row and p steps from there, since basis functions sum to 1; unrolled, as sums that a loop counts go to memory
static inline __attribute__((always_inline)) void nurbs_strip_points(__global float *restrict out,
    const nurbs_strip_rows *strip, __global const float *weights, const uint stride, const uint p, const uint columns,
    const uint count)
{
    const float *steps[STRIP_ROWS];
    float w[STRIP_ROWS + 1][ABREAST]; // of step k: that of all control rows from k on
    for (uint r = 0; r < count; ++r) w[p + 1][r] = 0.0f;
    for (uint k = p; k > 0; --k) {
        steps[k] = strip->steps[(strip->first + k) % STRIP_ROWS];
        for (uint r = 0; r < count; ++r) w[k][r] = w[k + 1][r] + weights[k * stride + r];
    }
    if (columns < 3) {
        for (uint f = 0; f < 3 * columns; ++f)
            for (uint r = 0; r < count; ++r) {
                float sum = strip->base[f];
                for (uint k = 1; k <= p; ++k) sum = fma(steps[k][f], w[k][r], sum);
                out[3 * r * columns + f] = sum;
            }
        return;
    }
    for (uint f = 0; f < 3 * columns; f += 8) {
        const uint at = min(f, 3 * columns - 8);
        const float8 base = vload8(0, strip->base + at);
        float8 sum[ABREAST];
#pragma unroll
        for (uint r = 0; r < count; ++r) sum[r] = base;
#pragma unroll
        for (uint k = 1; k <= p; ++k) {
            const float8 step = vload8(0, steps[k] + at);
#pragma unroll
            for (uint r = 0; r < count; ++r) sum[r] = fma(step, (float8)(w[k][r]), sum[r]);
        }
#pragma unroll
        for (uint r = 0; r < count; ++r) vstore8(sum[r], 0, out + 3 * r * columns + at);
    }
}

__kernel void nurbs_strip(
    __global const uint *restrict tiles,
    __global const uint *restrict surfaces,
    __global const uint *restrict samples,
    __global const float *restrict weights,
    __global const float *restrict controls,
    __global float *restrict positions,
    const uint stride,
    const uint tile_count)
{
    if (get_global_id(0) >= tile_count) return;

    __global const uint *tile = tiles + TILE_WORDS * get_global_id(0);
    const uint row = tile[1], rows = tile[2];
    const nurbs_tables tables = {samples, weights, controls, 0, 0, 0, stride};
    nurbs_surface surface;
    nurbs_surface_of(&surface, surfaces + SURFACE_WORDS * tile[0]);
    const uint columns = surface.columns;
    nurbs_strip_rows strip;
    strip.first = UINT_MAX, strip.end = 0;
    for (uint k = 0; k < columns + 3; ++k) vstore3(surface.origin, k, strip.origin); // whole vectors
    for (uint i = row, count; i < row + rows; i += count) {
        const uint sample = surface.sample_u + i, p = surface.p;
        __global const float *w = weights + sample;
        __global float *out = positions + 3 * (surface.first_vertex + (size_t)i * columns);
        nurbs_strip_to(&strip, &surface, &tables, samples[4 * sample], columns);
        count = min(samples[4 * sample + 1] - sample, row + rows - i) < ABREAST ? 1 : ABREAST;
        if (p == 3 && count == 1) nurbs_strip_points(out, &strip, w, stride, 3, columns, 1);
        else if (p == 3) nurbs_strip_points(out, &strip, w, stride, 3, columns, ABREAST);
        else if (count == 1) nurbs_strip_points(out, &strip, w, stride, p, columns, 1);
        else nurbs_strip_points(out, &strip, w, stride, p, columns, ABREAST);
    }
}
