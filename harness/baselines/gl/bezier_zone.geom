#version 330
// Geometry stage of geometry shader tessellation: a zone of a patch's parametric map as triangle strips. The patch is
// read once for the zone; each row's curve is made once and used by all of its samples.
// Concheiro 2013, chapter 2 (GST) and section 1.2. 13 values of each of 72 vertices are 936 of the 1024 that may be emitted.
layout(points) in;
layout(triangle_strip, max_vertices = 72) out;
uniform mat4 world_to_clip;
uniform sampler2D controls; // a row for each patch, v fastest; the first one's alpha brings the patch's size near 1
uniform int segments;
uniform ivec2 zone; // cells along u and v
flat in int zone_number[];
out vec3 surface_position;
out vec3 shaded_normal;
out vec2 weights; // for transform feedback
flat out int patch_number;

const float DEGENERATE = 1e-11, INWARDS = 1.0 / 1024.0;

struct Row {
    float u;
    mat4x3 curve; // its control points along v
    mat4x3 across; // those of Q_u over 3, scaled
};

int number; // of the patch
mat4x3 P[4];
float scale;

vec4 cubic(float t)
{
    float s = 1.0 - t;
    return vec4(s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t);
}

vec3 quadratic(float t)
{
    float s = 1.0 - t;
    return vec3(s * s, 2.0 * s * t, t * t);
}

Row row_at(float u)
{
    vec4 b = cubic(u);
    vec3 d = scale * quadratic(u);
    mat4x3 curve = b.x * P[0] + b.y * P[1] + b.z * P[2] + b.w * P[3];
    return Row(u, curve, d.x * (P[1] - P[0]) + d.y * (P[2] - P[1]) + d.z * (P[3] - P[2]));
}

vec3 crossed(Row row, vec4 v, vec3 dv)
{
    vec3 along = dv.x * (row.curve[1] - row.curve[0]) + dv.y * (row.curve[2] - row.curve[1]) +
                 dv.z * (row.curve[3] - row.curve[2]);
    return cross(row.across * v, scale * along);
}

void emit(Row row, float v)
{
    vec4 b = cubic(v);
    vec3 n = crossed(row, b, quadratic(v));
    if (dot(n, n) <= DEGENERATE) {
        float inner = v + INWARDS * (0.5 - v);
        n = crossed(row_at(row.u + INWARDS * (0.5 - row.u)), cubic(inner), quadratic(inner));
    }
    surface_position = row.curve * b;
    shaded_normal = dot(n, n) > 1e-30 ? normalize(n) : vec3(0.0, 0.0, 1.0);
    weights = vec2(row.u, v);
    patch_number = number;
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
    EmitVertex();
}

void main()
{
    int across = segments / zone.y, each = across * (segments / zone.x), place = zone_number[0] % each;
    ivec2 first = ivec2(place / across, place % across) * zone;
    number = zone_number[0] / each;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) P[i][j] = texelFetch(controls, ivec2(4 * i + j, number), 0).xyz;
    scale = texelFetch(controls, ivec2(0, number), 0).w;
    float step = 1.0 / float(segments);
    Row next = row_at(float(first.x) * step);
    for (int r = 0; r < zone.x; ++r) {
        Row here = next;
        next = row_at(float(first.x + r + 1) * step);
        for (int k = 0; k <= zone.y; ++k) {
            float v = float(first.y + k) * step;
            emit(here, v);
            emit(next, v);
        }
        EndPrimitive();
    }
}
