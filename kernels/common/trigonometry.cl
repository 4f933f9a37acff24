// Sine and cosine of an angle in turns, eight at a time.
//
// Source    none: least-maximum fits in r^2 over an eighth of a turn, relative error below 1e-8 before rounding
// Work      functions only; the reduction to an eighth of a turn is exact while |turns| < 2^20
// Reads     nothing
// Writes    nothing

static inline void sine_cosine_of_turns(const float8 turns, float8 *sine, float8 *cosine)
{
    const float8 quarters = floor(fma(turns, (float8)(4.0f), (float8)(0.5f)));
    const float8 r = fma(quarters, (float8)(-0.25f), turns);
    const float8 z = r * r;
    float8 s = fma(z, (float8)(-75.40206132f), (float8)(81.59255341f));
    s = fma(z, s, (float8)(-41.34166263f));
    s = fma(z, s, (float8)(6.28318529f)) * r;
    float8 c = fma(z, (float8)(59.22040324f), (float8)(-85.44285201f));
    c = fma(z, c, (float8)(64.93931621f));
    c = fma(z, c, (float8)(-19.73920865f));
    c = fma(z, c, (float8)(1.0f));

    // by quarter: s c | c -s | -s -c | -c s
    const int8 quarter = convert_int8(quarters);
    const int8 odd = -(quarter & 1);
    *sine = as_float8(((as_int8(c) & odd) | (as_int8(s) & ~odd)) ^ ((quarter & 2) << 30));
    *cosine = as_float8(((as_int8(s) & odd) | (as_int8(c) & ~odd)) ^ (((quarter + 1) & 2) << 30));
}
