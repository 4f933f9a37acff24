// Uniform grids of NURBS surfaces: basis functions at samples become points and normals of every surface.
//
// Source    Concheiro 2013, figure 6.4a (uniform tessellation per surface)
// Work      1-D over chunks of output vertices, row after row of a surface's grid and surface after surface
// Reads     surfaces   uint [16 * surface_count]  as nurbs/surface.cl has them, by their first vertex
//           samples    uint [4 * samples]         as nurbs/surface.cl has them
//           spans      float[48 * records]        as nurbs/basis.cl has them
//           places     float[2 * stride]          as nurbs/basis.cl has them
//           weights    float[15 * stride]         as nurbs/basis.cl writes them; eight more than samples
//           controls   float[4 * controls]        homogeneous
//           scales     float[quads]               as nurbs/surface.cl has them
// Writes    positions  float[3 * vertices]        packed; surface after surface, v fastest
//           normals    float[3 * vertices]        packed, unit length; nothing where NORMALS is 0
// Needs     nurbs/row.cl
// Plain     nurbs/reference.py
// Defines   CHUNK (a multiple of eight), NORMALS (1: normals too), RATIONAL (nurbs/surface.cl), STREAMING (common/output.cl)

__kernel void nurbs_vertex(
    __global const uint *restrict surfaces,
    __global const uint *restrict samples,
    __global const float *restrict spans,
    __global const float *restrict places,
    __global const float *restrict weights,
    __global const float *restrict controls,
    __global const float *restrict scales,
    __global float *restrict positions,
    __global float *restrict normals,
    const uint stride,
    const uint surface_count,
    const ulong vertex_count)
{
    const ulong first = (ulong)get_global_id(0) * CHUNK;
    if (first >= vertex_count) return;

    const nurbs_tables tables = {samples, weights, controls, scales, spans, places, stride};
    const uint count = (uint)min((ulong)CHUNK, vertex_count - first);
    OUTPUT_BEGIN(points, CHUNK, positions + 3 * first);
    OUTPUT_BEGIN(directions, NORMALS ? CHUNK : 1, normals + (NORMALS ? 3 * first : 0));

    uint low = 0, high = surface_count; // the last surface that begins at `first` or before
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (surfaces[SURFACE_WORDS * middle] <= first) low = middle;
        else high = middle;
    }
    nurbs_curve curve;
    curve.row = UINT_MAX, curve.first = 0;
    for (uint done = 0; done < count; ++low) {
        nurbs_surface surface;
        nurbs_surface_of(&surface, surfaces + SURFACE_WORDS * low);
        const uint vertex = (uint)(first + done - surface.first_vertex);
        uint i = vertex / surface.columns, j = vertex % surface.columns;
        for (; i < surface.rows && done < count; ++i, j = 0)
            while (j < surface.columns && done < count) {
                const uint sample = surface.sample_v + j;
                const uint here = min(samples[4 * sample + 1] - sample, count - done);
                nurbs_run(points + 3 * done, directions + (NORMALS ? 3 * done : 0), &curve, &surface, &tables,
                    surface.sample_u + i, sample, here, count - done, done);
                done += here, j += here;
            }
    }
    OUTPUT_END(points, count, positions + 3 * first);
#if NORMALS
    OUTPUT_END(directions, count, normals + 3 * first);
#endif
}
