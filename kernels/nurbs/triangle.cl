// The basis functions of B-splines at a place of a span, by the triangular table.
//
// Source    Piegl & Tiller, The NURBS Book, 1997, algorithms A2.2 and A2.3
// Work      functions only. All terms of a sum have one sign, so that spans of any lengths lose nothing
// Reads     span  float[48]  k_r = (x_i - x_{i-r}) / h, r < 8; l_a = (x_{i+a} - x_{i+1}) / h, 1 <= a <= 8; then
//                            1 / (k_r + 1 + l_a), of degree d = r + a from number d (d - 1) / 2 + r on
// Writes    nothing
// Plain     nurbs/reference.py

#pragma OPENCL FP_CONTRACT OFF

#define SPAN_FLOATS 48
#define NURBS_WIDTH(d, r) ((d) * ((d) - 1) / 2 + (r))

// All N_{i-k,p} by k, and slopes by k, both (p + 1) and p of them, at t of the span; s = 1 - t.
#define NURBS_TRIANGLE(name, T)                                                                                        \
    static inline void name(T *values, T *slopes, __global const float *span, const T t, const T s, const uint p)      \
    {                                                                                                                  \
        values[0] = (T)(1.0f);                                                                                         \
        for (uint d = 1; d <= p; ++d) {                                                                                \
            T carried = (T)(0.0f);                                                                                     \
            for (uint r = 0; r < d; ++r) {                                                                             \
                const T share = values[r] * span[16 + NURBS_WIDTH(d, r)];                                              \
                if (d == p) slopes[r] = share * (float)p;                                                              \
                values[r] = carried + share * (t + span[r]);                                                           \
                carried = share * (s + span[7 + d - r]);                                                               \
            }                                                                                                          \
            values[d] = carried;                                                                                       \
        }                                                                                                              \
    }
NURBS_TRIANGLE(nurbs_triangle, float)
NURBS_TRIANGLE(nurbs_triangle8, float8)
