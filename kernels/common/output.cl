// Eight vertices at a time to their place in the output, whatever its alignment: row after row of a parametric map.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    out  float[3 * vertices]  packed
// Needs     common/packed.cl
// Defines   STREAMING (common/packed.cl)

// Rows go straight to their place, or, where stores go past the caches, by way of a work-item's own store: only whole
// aligned vectors may go past them.
#if STREAMING
#define OUTPUT __private
#define OUTPUT_BEGIN(name, count, place) float name[3 * (count)]
#define OUTPUT_END(name, count, place) output_flush(name, count, place)
#else
#define OUTPUT __global
#define OUTPUT_BEGIN(name, count, place) __global float *restrict name = (place)
#define OUTPUT_END(name, count, place)
#endif

// eight vertices, of which the first `room` may be written
static inline void output_put(OUTPUT float *out, const planes8 a, const uint room)
{
    const packed8 rows = packed_rows(a);
    if (room >= 8) {
        vstore8(rows.first, 0, out);
        vstore8(rows.second, 1, out);
        vstore8(rows.third, 2, out);
    } else {
        float some[24];
        vstore8(rows.first, 0, some), vstore8(rows.second, 1, some), vstore8(rows.third, 2, some);
        for (uint k = 0; k < 3 * room; ++k) out[k] = some[k];
    }
}

// `count` vertices of the work-item's own store, from a multiple of eight on
static inline void output_flush(const float *stage, const uint count, __global float *restrict out)
{
    const uint whole = 3 * (count / 8);
    for (uint i = 0; i < whole; ++i) PACKED_STORE(vload8(i, stage), out + 8 * i);
    for (uint f = 8 * whole; f < 3 * count; ++f) out[f] = stage[f];
}
