// Geometry shader tessellation: a zone of a patch's parametric map becomes triangle strips, virtual vertices on the fly.
//
// Source    Concheiro 2013, chapter 2 (GST): the surface is evaluated before it is sampled, within a zone; powers about
//           the middle of the map are a reconstruction
// Work      1-D, one item per zone of each patch
// Reads     controls   float[64 * patches]  as bezier/patch.cl has it
//           levels     uint [patches]       of the patches, where each has its own
//           offsets    uint [patches]       and where its vertices begin
// Writes    positions  float[3 * vertices]  packed; zone after zone, each as bezier/gst/zones.py has it
//           normals    float[3 * vertices]  packed, unit length; nothing where NORMALS is 0
// Needs     bezier/gst/sample.cl
// Plain     bezier/gst/reference.py
// Defines   NORMALS (1: normals too), REUSE (bezier/gst/sample.cl), ZONE_ROWS, ZONE_COLUMNS, STREAMING (common/output.cl;
//           0 where a zone's vertices are no multiple of eight)

#define STRIP (2 * (ZONE_COLUMNS + 1))
#define ZONE (ZONE_ROWS * STRIP)

// a point of a border curve, by the sum that every system has for it
static inline float4 gst_border_point(
    const float4 a, const float4 b, const float4 c, const float4 d, const uint k, const float step)
{
    const float t = (float)k * step, s = 1.0f - t;
    return BEZIER_CUBIC(s * s * s, 3.0f * s * s * t, 3.0f * s * t * t, t * t * t, a, b, c, d);
}

// points on the patch's borders again, from the border's own control points
static inline void gst_borders(
    OUTPUT float *out, const bezier_patch *patch, const uint i, const uint j, const uint segments, const float step)
{
    for (uint end = 0; end < 2; ++end) {
        const float16 c = patch->rows[end ? 3 : 0];
        if (end ? i + ZONE_ROWS == segments : i == 0) {
            const uint first = end ? (ZONE_ROWS - 1) * STRIP : 1;
            for (uint k = 0; k <= ZONE_COLUMNS; ++k) {
                const float4 p = gst_border_point(c.s0123, c.s4567, c.s89ab, c.scdef, j + k, step);
                vstore3(p.xyz, first + 2 * k, out);
            }
        }
        if (end ? j + ZONE_COLUMNS == segments : j == 0) {
            float4 b[4];
            for (uint k = 0; k < 4; ++k) b[k] = end ? patch->rows[k].scdef : patch->rows[k].s0123;
            for (uint k = 0; k <= ZONE_ROWS; ++k) {
                const float4 p = gst_border_point(b[0], b[1], b[2], b[3], i + k, step);
                const uint lane = end ? STRIP - 2 : 0;
                if (k < ZONE_ROWS) vstore3(p.xyz, k * STRIP + lane + 1, out);
                if (k > 0) vstore3(p.xyz, (k - 1) * STRIP + lane, out);
            }
        }
    }
}

// the zone whose first cell is (i, j)
static inline void gst_zone(OUTPUT float *points, OUTPUT float *directions, const bezier_patch *patch,
    const uint i, const uint j, const uint segments)
{
    const float step = 1.0f / (float)segments;
    gst_surface surface;
    gst_surface_of(&surface, patch);
    gst_strip strip;
    gst_strip_begin(&strip, &surface, (float)i * step - 0.5f);
    for (uint s = 0; s < ZONE_ROWS; ++s) {
        gst_strip_next(&strip, &surface, (float)(i + s) * step - 0.5f, (float)(i + s + 1) * step - 0.5f);
        for (uint l = 0; l < STRIP; l += 8) {
            const uint at = s * STRIP + l, room = ZONE - at;
            const float8 columns = (float)(j + l / 2) + (float8)(0, 0, 1, 1, 2, 2, 3, 3);
            gst_sampled made;
            gst_sample(&made, &strip, &surface, columns * step - 0.5f);
            output_put(points + 3 * at, made.p, room);
#if NORMALS
            planes8 n;
            const int8 is_bad = normals_cross8(&n, made.q, made.r);
            output_put(directions + 3 * at, n, room);
            if (normals_any(is_bad)) {
                int bad[8];
                vstore8(is_bad, 0, bad);
                for (uint k = 0; k < 8 && l + k < STRIP; ++k) {
                    const float u = (float)(i + s + 1 - (k & 1)) * step, v = (float)(j + (l + k) / 2) * step;
                    if (bad[k]) vstore3(bezier_unit((float3)(0.0f), patch, u, v), at + k, directions);
                }
            }
#endif
        }
    }
    gst_borders(points, patch, i, j, segments, step);
}

__kernel void gst_geometry(
    __global const float *restrict controls,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint segments,
    const uint zone_count)
{
    const uint zone = get_global_id(0);
    if (zone >= zone_count) return;

    const uint across = segments / ZONE_COLUMNS, each = across * (segments / ZONE_ROWS);
    const uint i = zone % each / across * ZONE_ROWS, j = zone % across * ZONE_COLUMNS;
    bezier_patch patch;
    bezier_patch_at(&patch, controls, zone / each);
    OUTPUT_BEGIN(points, ZONE, positions + 3 * (size_t)zone * ZONE);
    OUTPUT_BEGIN(directions, NORMALS ? ZONE : 1, normals + (NORMALS ? 3 * (size_t)zone * ZONE : 0));
    gst_zone(points, directions, &patch, i, j, segments);
    OUTPUT_END(points, ZONE, positions + 3 * (size_t)zone * ZONE);
#if NORMALS
    OUTPUT_END(directions, ZONE, normals + 3 * (size_t)zone * ZONE);
#endif
}

#if !STREAMING // zones go where a patch's vertices begin

// the patches of this many segments
__kernel void gst_geometry_levels(
    __global const float *restrict controls,
    __global const uint *restrict levels,
    __global const uint *restrict offsets,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint level,
    const uint patch_count)
{
    const uint segments = 1u << level, across = segments / ZONE_COLUMNS, each = across * (segments / ZONE_ROWS);
    const uint p = get_global_id(0) / each, zone = get_global_id(0) % each;
    if (p >= patch_count || levels[p] != level) return;

    bezier_patch patch;
    bezier_patch_at(&patch, controls, p);
    const size_t first = 3 * ((size_t)offsets[p] + zone * ZONE);
    const uint i = zone / across * ZONE_ROWS, j = zone % across * ZONE_COLUMNS;
    gst_zone(positions + first, normals + (NORMALS ? first : 0), &patch, i, j, segments);
}
#endif
