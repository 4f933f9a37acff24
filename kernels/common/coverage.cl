// Which pixels does a triangle cover, and how deep is it there? Exact edges in whole sub-pixels, top-left rule.
//
// Source    Pineda 1988, "A parallel algorithm for polygon rasterization"; fill rule as OpenGL and Direct3D drivers have it
// Work      functions only; a pixel belongs to a triangle by integer tests on its centre, so shared edges never overlap
// Reads     nothing
// Writes    nothing
// Needs     common/screen.cl
// Plain     stages/raster_reference.py
// Defines   COUNT, SHARED as in canvas.cl

// one triangle ready to be walked; edge k is inside where f[k] + dx[k] * row - dy[k] * column >= 0, pixels from the corner
typedef struct {
    long f[3];
    int dx[3], dy[3];
    int4 box;                  // first column, first row, last column, last row: pixel centres inside its box and the image
    float x, y, z, zx, zy;     // depth z at the sub-pixel (x, y), and its slopes per sub-pixel
    float near, far;           // of the three corners: slopes of slivers are inexact, depths stay between these
    uint id;
} Walk;

// first and last pixel whose centre lies in [low, high], sub-pixels
static inline int first_centre(const int low) { return (low + SUBPIXELS / 2 - 1) >> 8; }
static inline int last_centre(const int high) { return (high - SUBPIXELS / 2) >> 8; }

// corners are x, y, depth bits; false where nothing can be drawn: no area, no centre in the box, or facing away
static inline bool walk_start(
    Walk *walk, const int4 a, const int4 b, const int4 c, const uint id, const int width, const int height, const uint cull)
{
    const long area = (long)(b.x - a.x) * (c.y - a.y) - (long)(c.x - a.x) * (b.y - a.y);
    if (area == 0 || (cull && area > 0)) return false; // y grows downwards: counter-clockwise is negative
    walk->box.x = max(first_centre(min(a.x, min(b.x, c.x))), 0);
    walk->box.y = max(first_centre(min(a.y, min(b.y, c.y))), 0);
    walk->box.z = min(last_centre(max(a.x, max(b.x, c.x))), width - 1);
    walk->box.w = min(last_centre(max(a.y, max(b.y, c.y))), height - 1);
    if (walk->box.x > walk->box.z || walk->box.y > walk->box.w) return false;

    const int4 q = area > 0 ? b : c, r = area > 0 ? c : b;
    const int px[4] = {a.x, q.x, r.x, a.x}, py[4] = {a.y, q.y, r.y, a.y};
    for (int k = 0; k < 3; ++k) {
        const int dx = px[k + 1] - px[k], dy = py[k + 1] - py[k];
        const long edge = (long)dx * (SUBPIXELS / 2 - py[k]) - (long)dy * (SUBPIXELS / 2 - px[k]);
        const bool owned = dy < 0 || (dy == 0 && dx > 0); // left or top: a centre on it is inside
        walk->f[k] = (edge - (owned ? 0 : 1)) >> 8;       // steps are whole multiples of 256: the sign survives
        walk->dx[k] = dx;
        walk->dy[k] = dy;
    }
    const float za = as_float(a.z), zb = as_float(b.z), zc = as_float(c.z);
    const float x1 = b.x - a.x, y1 = b.y - a.y, z1 = zb - za, x2 = c.x - a.x, y2 = c.y - a.y, z2 = zc - za;
    const float inverse = 1.0f / (float)area;
    walk->x = a.x;
    walk->y = a.y;
    walk->z = za;
    walk->zx = (z1 * y2 - z2 * y1) * inverse;
    walk->zy = (z2 * x1 - z1 * x2) * inverse;
    walk->near = lesser(za, lesser(zb, zc));
    walk->far = greater(za, greater(zb, zc));
    walk->id = id;
    return true;
}

// how a pixel takes a fragment: the smaller key stays, so neither order nor owner matters; COUNT adds instead
static inline void key_put(__global long *key, const long value)
{
#ifdef COUNT
    *key += 1;
#elif defined(SHARED)
    atom_min(key, value);
#else
    *key = min(*key, value); // no branch: whether a fragment is seen is beyond prediction
#endif
}

// the part of a triangle that lies in the tile whose first pixel is (left, top)
static inline void walk_tile(const Walk *walk, __global long *restrict keys, const int left, const int top)
{
    int f[3];
    for (int k = 0; k < 3; ++k) {
        const long start = walk->f[k] + (long)walk->dx[k] * top - (long)walk->dy[k] * left;
        const long reach = (long)max(walk->dx[k], 0) * (TILE - 1) + (long)max(-walk->dy[k], 0) * (TILE - 1);
        if (start + reach < 0) return;
        f[k] = (int)clamp(start, -(1L << 30), 1L << 30); // steps within a tile stay below 2^30
    }
    // groups of eight pixels that lie in the tile whole, as many as the box needs
    const int groups = (min(walk->box.z - left, TILE - 1) - max(walk->box.x - left, 0)) / 8 + 1;
    const int begin = min(max(walk->box.x - left, 0), TILE - 8 * groups);
    const int first = max(walk->box.y - top, 0), last = min(walk->box.w - top, TILE - 1);
    int8 row0 = (f[0] + walk->dx[0] * first - walk->dy[0] * begin) - LANE * walk->dy[0];
    int8 row1 = (f[1] + walk->dx[1] * first - walk->dy[1] * begin) - LANE * walk->dy[1];
    int8 row2 = (f[2] + walk->dx[2] * first - walk->dy[2] * begin) - LANE * walk->dy[2];
    const float8 centre = convert_float8(LANE * SUBPIXELS);
    const float begin_x = (float)((left + begin) * SUBPIXELS + SUBPIXELS / 2) - walk->x;
    for (int row = first; row <= last; ++row) {
        const float zy = walk->zy * ((float)((top + row) * SUBPIXELS + SUBPIXELS / 2) - walk->y);
        int8 f0 = row0, f1 = row1, f2 = row2;
        for (int group = 0; group < groups; ++group) {
            const int8 outside = f0 | f1 | f2;
            f0 -= 8 * walk->dy[0], f1 -= 8 * walk->dy[1], f2 -= 8 * walk->dy[2];
            uint bits = ~lane_signs(outside) & 255;
            if (!bits) continue;
            const float x = begin_x + (float)(8 * SUBPIXELS * group); // whole numbers below 2^24: exact
            const float8 plane = (walk->z + walk->zx * (centre + x)) + zy;
            const float8 z = lesser(greater(plane, (float8)(walk->near)), (float8)(walk->far));
            __global long *at = keys + row * TILE + begin + 8 * group;
#ifdef SHARED
            int depths[8];
            vstore8(as_int8(z), 0, depths);
            for (; bits; bits &= bits - 1) {
                const uint lane = 31 - clz(bits & -bits);
                key_put(at + lane, ((long)depths[lane] << 32) | walk->id);
            }
#else
            const long8 old = vload8(0, at);
#ifdef COUNT
            const int8 covered = ~(outside >> 31);
            const int16 wide = SHUFFLE16(covered, covered, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
            vstore8(old - as_long8(wide), 0, at);
#else
            const int8 id = (int)walk->id, deep = outside < 0 ? (int8)(0x7fffffff) : as_int8(z); // outside: behind everything
            const long8 key = as_long8(SHUFFLE16(id, deep, 0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15));
            vstore8(key < old ? key : old, 0, at);
#endif
#endif
        }
        row0 += walk->dx[0], row1 += walk->dx[1], row2 += walk->dx[2];
    }
}
