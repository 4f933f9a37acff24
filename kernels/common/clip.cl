// Triangles that cross the near plane or leave the guard band, cut to what fixed-point screen coordinates can hold.
//
// Source    Sutherland & Hodgman 1974, "Reentrant polygon clipping"
// Work      functions only; a cut edge is walked from its inside end, so two triangles that share it get the same corner
// Reads     nothing
// Writes    nothing
// Needs     common/screen.cl
// Plain     stages/raster_reference.py

#define CLIP_CORNERS 9 // a triangle and one more corner per plane, and one to spare

// x, y in sub-pixels, depth and w, all times w; rounds exactly as the vertex stage does
static inline float4 screen_transform(const float3 p, const float16 m)
{
    const float4 x = (float4)(m.s0, m.s4, m.s8, m.sc), y = (float4)(m.s1, m.s5, m.s9, m.sd);
    const float4 z = (float4)(m.s2, m.s6, m.sa, m.se), one = (float4)(m.s3, m.s7, m.sb, m.sf);
    return x * p.x + y * p.y + z * p.z + one;
}

static inline float clip_distance(const float4 corner, const int plane)
{
    switch (plane) {
    case 0: return corner.z;
    case 1: return corner.x + GUARD * corner.w;
    case 2: return GUARD * corner.w - corner.x;
    case 3: return corner.y + GUARD * corner.w;
    default: return GUARD * corner.w - corner.y;
    }
}

// cuts in place; how many corners are left, 0 when fewer than 3 or when a corner is not a number
static int clip_polygon(float4 corners[CLIP_CORNERS])
{
    int count = 3;
    for (int plane = 0; plane < 5 && count >= 3; ++plane) {
        float4 kept[CLIP_CORNERS];
        int n = 0;
        for (int k = 0; k < count; ++k) {
            const float4 a = corners[k], b = corners[k + 1 == count ? 0 : k + 1];
            const float da = clip_distance(a, plane), db = clip_distance(b, plane);
            if (da >= 0.0f && n < CLIP_CORNERS) kept[n++] = a;
            if ((da >= 0.0f) != (db >= 0.0f) && n < CLIP_CORNERS)
                kept[n++] = da >= 0.0f ? a + (b - a) * (da / (da - db)) : b + (a - b) * (db / (db - da));
        }
        for (int k = 0; k < n; ++k) corners[k] = kept[k];
        count = n;
    }
    for (int k = 0; k < count; ++k)
        if (!(corners[k].w > 0.0f && corners[k].w < INFINITY)) return 0;
    return count >= 3 ? count : 0;
}

// a corner as the vertex stage would have stored it
static inline int4 clip_corner(const float4 corner)
{
    const float inverse = 1.0f / corner.w;
    const float x = clamp(corner.x * inverse, -GUARD, GUARD), y = clamp(corner.y * inverse, -GUARD, GUARD);
    const float z = max(corner.z * inverse, 0.0f) + 0.0f;
    return (int4)((int)floor(x + 0.5f), (int)floor(y + 0.5f), as_int(z), as_int(inverse));
}
