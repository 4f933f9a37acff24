// Vertex stage of the frame: where on the screen does each vertex fall, in whole sub-pixels?
//
// Source    fixed-point screen coordinates as GPUs keep them (8 sub-pixel bits); y grows downwards, row 0 is on top
// Work      1-D, one item per 8 vertices; items past vertex_count only help to clear flags
// Reads     positions  float[3 * vertex_count]   model units
//           live       uint [2]                  live vertices, live triangles
// Writes    screen     int  [4 * vertex_count, padded to 8 vertices]   x, y in 1/256 pixel | depth 0..1 and 1 / w as float bits
//           flags      uint [flag_count]         cleared: nothing touched, nothing queued in this frame
// Needs     common/screen.cl
// Plain     stages/raster_reference.py

// eight vertices at once: planes in, one 16-byte record per vertex out
static inline void screen_store(const float8 px, const float8 py, const float8 pz, const float16 m, __global int *screen)
{
    const float8 x = m.s0 * px + m.s1 * py + m.s2 * pz + m.s3;
    const float8 y = m.s4 * px + m.s5 * py + m.s6 * pz + m.s7;
    const float8 z = m.s8 * px + m.s9 * py + m.sa * pz + m.sb;
    const float8 w = m.sc * px + m.sd * py + m.se * pz + m.sf;
    const float8 guard = GUARD * w;
    // written so that a NaN is outside; the guard planes on both sides imply w >= 0
    int8 code = ~(z >= 0.0f) & OUTSIDE_NEAR;
    code |= ~(x >= -guard) & OUTSIDE_LEFT;
    code |= ~(x <= guard) & OUTSIDE_RIGHT;
    code |= ~(y >= -guard) & OUTSIDE_TOP;
    code |= ~(y <= guard) & OUTSIDE_BOTTOM;
    code |= ~((w > 0.0f) & (w < INFINITY)) & OUTSIDE_NEAR;
    const float8 inverse = 1.0f / w;
    const int8 inside = code == 0;
    const int8 a = screen_round(x * inverse) & inside;
    const int8 b = screen_round(y * inverse) & inside;
    const int8 c = as_int8(z * inverse + 0.0f) & inside; // + 0: a negative zero would order before everything
    const int8 d = inside ? as_int8(inverse) : code | OUTSIDE;
    const fours8 rows = transpose_fours(as_float8(a), as_float8(b), as_float8(c), as_float8(d));
    vstore8(as_int8((float8)(rows.x.lo, rows.y.lo)), 0, screen);
    vstore8(as_int8((float8)(rows.z.lo, rows.w.lo)), 1, screen);
    vstore8(as_int8((float8)(rows.x.hi, rows.y.hi)), 2, screen);
    vstore8(as_int8((float8)(rows.z.hi, rows.w.hi)), 3, screen);
}

__kernel void stages_vertex_transform(
    __global const float *restrict positions,
    __global const uint *restrict live,
    __global int *restrict screen,
    __global uint *restrict flags,
    const float16 to_screen, // rows: x and y in sub-pixels, depth in 0..1, w; all times w
    const uint tiles_open, // 1 where all tiles were cleared beforehand
    const uint flag_count,
    const uint vertex_count)
{
    const size_t i = get_global_id(0);
    for (size_t f = i; f < flag_count; f += get_global_size(0)) flags[f] = f < FLAGS_OPEN ? 0 : tiles_open;

    const uint count = min(live[0], vertex_count);
    const size_t v = 8 * i;
    if (v >= count) return;
    float8 x, y, z;
    if (v + 8 <= count) {
        const float8 a = vload8(0, positions + 3 * v), b = vload8(1, positions + 3 * v), c = vload8(2, positions + 3 * v);
        x = (float8)(a.s036, b.s147, c.s25);
        y = (float8)(a.s147, b.s25, c.s036);
        z = (float8)(a.s25, b.s036, c.s147);
    } else { // the last vertex again: records past the end exist but are never looked at
        float lanes[24];
        for (uint k = 0; k < 8; ++k) {
            const size_t source = min(v + k, (size_t)count - 1);
            lanes[k] = positions[3 * source];
            lanes[8 + k] = positions[3 * source + 1];
            lanes[16 + k] = positions[3 * source + 2];
        }
        x = vload8(0, lanes);
        y = vload8(1, lanes);
        z = vload8(2, lanes);
    }
    screen_store(x, y, z, to_screen, screen + 4 * v);
}
