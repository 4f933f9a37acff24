// Edge collapse, fragment stage: quadrics about their own vertices, and where two of them meet best.
//
// Source    Garland & Heckbert 1997, section 5; about the vertex itself b and c of a new quadric are 0, and all sums are
//           of the size of an edge, which is what float32 needs
// Work      functions only
// Reads     nothing
// Writes    nothing

// a quadric is a float16: A in s012345 (xx xy xz yy yz zz), c in s6, b in s89a, the point that it is about in scde:
// f(x) = (x - p) A (x - p) + 2 b (x - p) + c

#define RIDGE 1e-6f  // of the trace: what a flat sum is solved with
#define TIE 1e-6f    // times trace times length^2: among equals, the short edge first
#define LEAST 1e-30f // a trace below it has no direction

static inline float3 quadric_times(const float16 q, const float3 d)
{
    return (float3)(q.s0 * d.x + q.s1 * d.y + q.s2 * d.z, q.s1 * d.x + q.s3 * d.y + q.s4 * d.z,
        q.s2 * d.x + q.s4 * d.y + q.s5 * d.z);
}

// weight times the square of the distance from a plane through the vertex
static inline float16 quadric_plane(const float3 n, const float weight)
{
    const float3 m = n * weight;
    return (float16)(m.x * n.x, m.x * n.y, m.x * n.z, m.y * n.y, m.y * n.z, m.z * n.z, 0, 0, (float8)(0.0f));
}

// the sum of two, about the point where it is least, near the middle; returns its cost there
static inline float quadric_merge(const float16 u, const float16 v, float16 *merged)
{
    const float3 d = 0.5f * (v.scde - u.scde);
    const float3 bu = u.s89a + quadric_times(u, d), bv = v.s89a - quadric_times(v, d);
    const float3 b = bu + bv;
    const float c = u.s6 + dot(d, u.s89a + bu) + v.s6 - dot(d, v.s89a + bv);
    float16 sum = u + v;
    const float trace = sum.s0 + sum.s3 + sum.s5, square = 4.0f * dot(d, d);
    float3 y = 0.0f;
    if (trace > LEAST) {
        // L D L^T of the sum with the ridge; pivots that rounding took below the ridge are the ridge
        const float ridge = RIDGE * trace;
        const float d0 = sum.s0 + ridge;
        const float l1 = sum.s1 / d0, l2 = sum.s2 / d0;
        const float d1 = fmax(sum.s3 + ridge - l1 * sum.s1, ridge);
        const float e = sum.s4 - l1 * sum.s2;
        const float l3 = e / d1;
        const float d2 = fmax(sum.s5 + ridge - l2 * sum.s2 - l3 * e, ridge);
        const float y1 = -b.y + l1 * b.x, y2 = -b.z + l2 * b.x - l3 * y1;
        y.z = y2 / d2;
        y.y = y1 / d1 - l3 * y.z;
        y.x = -b.x / d0 - l1 * y.y - l2 * y.z;
        const float far = dot(y, y);
        if (!(far <= square)) y = far < INFINITY ? y * sqrt(square / far) : (float3)(0.0f);
    }
    const float3 moved = b + quadric_times(sum, y);
    const float cost = fmax(c + dot(y, b + moved), 0.0f);
    sum.s6 = cost;
    sum.s89a = moved;
    sum.scde = 0.5f * (u.scde + v.scde) + y;
    *merged = sum;
    return cost + TIE * trace * square;
}
