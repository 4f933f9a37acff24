#version 400
// Control stage of curved PN triangles: each invocation has a corner and the edge that leaves it, the first the centre.
// Vlachos et al. 2001, sections 3.1 and 3.3.
layout(vertices = 3) out;
uniform float segments;
uniform float per_segment; // pixels of a unit at distance 1 over those of a segment; 0: as many segments along every edge
uniform vec3 eye;
in float corner_span[]; // mean length of the edges around the corner
in vec3 corner_position[];
in vec3 corner_normal[];
flat in int corner_number[];
out vec3 patch_position[];
out vec3 patch_normal[];
out vec3 near_point[]; // control points of the edge to the next corner
out vec3 far_point[];
out vec3 middle_normal[]; // and its control normal
flat out int patch_number[];
patch out vec3 centre_point;

// beside a on the edge to b: a third of the way, bent into the tangent plane
vec3 handle(vec3 a, vec3 b, vec3 normal)
{
    return (2.0 * a + b - dot(b - a, normal) * normal) / 3.0;
}

// unit length; `otherwise` where there is no direction
vec3 unit(vec3 a, vec3 otherwise)
{
    float square = dot(a, a);
    return square > 1e-24 ? a * inversesqrt(square) : otherwise;
}

// of the edge between a and b; where it vanishes, the mean of its ends
vec3 middle(vec3 a, vec3 b, vec3 normal_a, vec3 normal_b)
{
    vec3 d = b - a, sum = normal_a + normal_b;
    float square = dot(d, d);
    float v = square > 0.0 ? 2.0 * dot(d, sum) / square : 0.0;
    return unit(sum - v * d, unit(sum, normal_a));
}

// how deeply a corner asks to be refined
float tag(int i)
{
    float away = max(distance(corner_position[i], eye), 1e-18);
    return clamp(log2(max(corner_span[i] / away * per_segment, 1e-18)), 0.0, log2(segments));
}

// segments of the edge from corner i to corner j, the same from both sides
float edge_level(int i, int j)
{
    return per_segment > 0.0 ? exp2(ceil(0.5 * (tag(i) + tag(j)))) : segments;
}

void main()
{
    int i = gl_InvocationID, j = (i + 1) % 3;
    vec3 a = corner_position[i], b = corner_position[j];
    patch_position[gl_InvocationID] = a;
    patch_normal[gl_InvocationID] = corner_normal[i];
    patch_number[gl_InvocationID] = corner_number[i];
    near_point[gl_InvocationID] = handle(a, b, corner_normal[i]);
    far_point[gl_InvocationID] = handle(b, a, corner_normal[j]);
    middle_normal[gl_InvocationID] = middle(a, b, corner_normal[i], corner_normal[j]);
    barrier();
    if (i == 0) {
        vec3 edges = vec3(0.0), corners = vec3(0.0);
        for (int k = 0; k < 3; ++k) {
            edges += near_point[k] + far_point[k];
            corners += corner_position[k];
        }
        centre_point = edges / 4.0 - corners / 6.0; // E + (E - V) / 2, E = edges / 6, V = corners / 3
        // the tessellator's outer levels stand across from their corner
        gl_TessLevelOuter[0] = edge_level(1, 2);
        gl_TessLevelOuter[1] = edge_level(2, 0);
        gl_TessLevelOuter[2] = edge_level(0, 1);
        gl_TessLevelInner[0] = max(max(gl_TessLevelOuter[0], gl_TessLevelOuter[1]), gl_TessLevelOuter[2]);
    }
}
