// What one work-item draws into: a map of keys in tiles of 64 x 64, opened when first touched.
//
// Source    none
// Work      functions only; a triangle too large for one item is queued, and drawn tile by tile by all of them
// Reads     nothing
// Writes    nothing
// Needs     common/coverage.cl common/clip.cl
// Defines   COUNT  1: count fragments instead of keeping the nearest; SHARED  1: many items draw into one map

#define WAITING 256

typedef struct {
    __global long *keys;
    __global uint *open, *queue;
    __global int *large;
    int width, height, across; // pixels, pixels, tiles per row
    uint large_capacity, large_pixels, cull;
} Canvas;

static inline void tile_open(const Canvas *canvas, const uint tile)
{
#ifndef SHARED
    if (canvas->open[tile]) return;
    canvas->open[tile] = 1;
    __global long8 *keys = (__global long8 *)(canvas->keys + (size_t)tile * TILE_PIXELS);
#ifdef COUNT
    for (int k = 0; k < TILE_PIXELS / 8; ++k) keys[k] = 0;
#else
    for (int k = 0; k < TILE_PIXELS / 8; ++k) keys[k] = KEY_EMPTY;
#endif
#endif
}

// a triangle of any size: into this item's map, or to the tiles when it would keep one item busy for too long
static void __attribute__((noinline)) canvas_draw(const Canvas *canvas, const int4 a, const int4 b, const int4 c, const uint id)
{
    Walk walk;
    if (!walk_start(&walk, a, b, c, id, canvas->width, canvas->height, canvas->cull)) return;
    const int4 box = walk.box;
    if ((uint)(box.z - box.x + 1) * (uint)(box.w - box.y + 1) > canvas->large_pixels) {
        const uint slot = atomic_inc(&canvas->queue[1]);
        if (slot < canvas->large_capacity) {
            vstore16((int16)(box, a.xyz, (int)id, b, c), slot, canvas->large);
            return;
        }
    }
    for (int y = box.y / TILE; y <= box.w / TILE; ++y)
        for (int x = box.x / TILE; x <= box.z / TILE; ++x) {
            const uint tile = y * canvas->across + x;
            tile_open(canvas, tile);
            walk_tile(&walk, canvas->keys + (size_t)tile * TILE_PIXELS, x * TILE, y * TILE);
        }
}

static void __attribute__((noinline)) canvas_clip(const Canvas *canvas, const float3 a, const float3 b, const float3 c, const float16 m, const uint id)
{
    float4 corners[CLIP_CORNERS];
    corners[0] = screen_transform(a, m);
    corners[1] = screen_transform(b, m);
    corners[2] = screen_transform(c, m);
    const int count = clip_polygon(corners);
    for (int k = 2; k < count; ++k)
        canvas_draw(canvas, clip_corner(corners[0]), clip_corner(corners[k - 1]), clip_corner(corners[k]), id);
}

// fragments on their way to the map: while one waits, its line of the map comes into the cache
typedef struct {
    uint count, pixels[WAITING + 64];
    long keys[WAITING + 64];
} Waiting;

static inline void waiting_put(const Canvas *canvas, Waiting *waiting)
{
    for (uint k = 0; k < waiting->count; ++k) key_put(canvas->keys + waiting->pixels[k], waiting->keys[k]);
    waiting->count = 0;
}

// the fragments of up to eight rounds of eight triangles from `id` on; bit 8 * round + lane says which there are
static inline void canvas_put(
    const Canvas *canvas, Waiting *waiting, ulong bits, const uint *pixels, const uint *depths, const uint id)
{
    uint count = waiting->count;
    while (bits) {
        const uint slot = 63 - (uint)clz(bits);
        bits ^= 1UL << slot;
        const uint pixel = pixels[slot];
        const long key = ((long)depths[slot] << 32) | (id + (slot & 7));
        tile_open(canvas, pixel / TILE_PIXELS);
#ifdef SHARED
        key_put(canvas->keys + pixel, key);
#else
        prefetch(canvas->keys + pixel, 1);
        waiting->pixels[count] = pixel;
        waiting->keys[count++] = key;
#endif
    }
    waiting->count = count;
    if (count >= WAITING) waiting_put(canvas, waiting);
}
