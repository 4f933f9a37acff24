// A height map: d = a (value of a grid at the texture coordinates - bias), repeated beyond 0..1.
//
// Source    Boubekeur & Schlick 2005, section 4 (a vertex texture, which their cards could not filter: both kinds are here);
//           the chain rule for its normal, through the gradients of u and v, is a reconstruction
// Work      functions only; a float buffer and no image, so that a device without images and a CPU do the same sums.
//           Slopes are those of the filtered map in either case: steps have none
// Reads     table  uint[2 + width * height]  width, height, then bits of float: values less the bias, lowest v first
// Writes    nothing
// Needs     common/displacement.cl
// Plain     refine/height_map.py
// Defines   CHUNK, ATTRIBUTES (8: u, v and the gradients of both, per diagonal), NEAREST (1: no filter)

#pragma OPENCL FP_CONTRACT OFF

// along one axis of so many values, which stand in the middles of their cells: the two about a coordinate, and how far
// it is from one to the other
typedef struct {
    int low[8], high[8];
    float8 part;
} height_map_pair;

static inline void height_map_find(height_map_pair *pair, const float8 coordinate, const uint count)
{
    const float8 inside = coordinate - floor(coordinate); // up to 1, as a small negative one rounds
    const float8 x = fma(inside, (float8)((float)count), (float8)(-0.5f)), cell = floor(x);
    const int8 last = (int8)((int)count - 1), first = (int8)(0);
    const int8 i = convert_int8(cell), next = i + 1;
    const int8 below = i < first, beyond = next > last;
    vstore8(max(min((last & below) | (i & ~below), last), first), 0, pair->low);
    vstore8(max(min(next & ~beyond, last), first), 0, pair->high);
    pair->part = x - cell;
}

static inline float8 height_map_mix(const float8 a, const float8 b, const float8 t) { return fma(t, b - a, a); }

// value less bias at u and v, and how it rises along both
static inline void height_map_at(const float8 u, const float8 v, __global const uint *table, float8 *value, float8 *rises)
{
    const uint width = table[0], height = table[1];
    __global const float *values = (__global const float *)(table + 2);
    height_map_pair x, y;
    height_map_find(&x, u, width);
    height_map_find(&y, v, height);
    float found[4][8];
    for (uint lane = 0; lane < 8; ++lane) {
        __global const float *low = values + (size_t)y.low[lane] * width, *high = values + (size_t)y.high[lane] * width;
        found[0][lane] = low[x.low[lane]], found[1][lane] = low[x.high[lane]];
        found[2][lane] = high[x.low[lane]], found[3][lane] = high[x.high[lane]];
    }
    const float8 a = vload8(0, found[0]), b = vload8(0, found[1]), c = vload8(0, found[2]), d = vload8(0, found[3]);
    rises[0] = (float)width * height_map_mix(b - a, d - c, y.part);
    rises[1] = (float)height * height_map_mix(c - a, d - b, x.part);
#if NEAREST
    const int8 right = x.part >= 0.5f, up = y.part >= 0.5f;
    *value = float8_pick(up, float8_pick(right, d, c), float8_pick(right, b, a));
#else
    *value = height_map_mix(height_map_mix(a, b, x.part), height_map_mix(c, d, x.part), y.part);
#endif
}

// one vector; n has unit length
static inline void displace_eight(planes8 *p, planes8 *n, const Displacement d)
{
    float8 value, rises[2];
    height_map_at(d.at[0], d.at[1], d.table, &value, rises);
    const float steep = d.amplitude * d.inverse;
    const float8 along_u = rises[0] * steep, along_v = rises[1] * steep;
    const planes8 g = {fma(along_v, d.at[5], along_u * d.at[2]), fma(along_v, d.at[6], along_u * d.at[3]),
        fma(along_v, d.at[7], along_u * d.at[4])};
    *p = displacement_raised(*p, *n, value * d.amplitude);
    *n = displacement_tilted(*n, g);
}
