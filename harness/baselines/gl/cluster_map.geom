#version 400
// Pass 1, geometry stage: a third of the triangle's quadric goes to the texel of each corner's cell, as a point.
// DeCoro & Tatarchuk 2007, slides 12-13: area/3 [n; d][n; d]^T, the corner and 1.
layout(triangles) in;
layout(points, max_vertices = 3) out;
uniform ivec2 map_size;
in vec3 corner_point[];
flat in int corner_cell[];
flat out vec4 corner_sum; // x y z, 1
flat out vec4 quadric_0;  // A00 A01 A02 A11
flat out vec4 quadric_1;  // A12 A22 c
flat out vec4 quadric_2;  // b0 b1 b2

void main()
{
    vec3 m = cross(corner_point[1] - corner_point[0], corner_point[2] - corner_point[0]);
    float size = length(m);
    vec3 n = size > 0.0 ? m / size : vec3(0.0);
    float d = -dot(n, corner_point[0]);
    float share = size / 6.0;
    for (int k = 0; k < 3; ++k) {
        corner_sum = vec4(corner_point[k], 1.0);
        quadric_0 = share * vec4(n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y);
        quadric_1 = share * vec4(n.y * n.z, n.z * n.z, d * d, 0.0);
        quadric_2 = share * vec4(d * n, 0.0);
        vec2 texel = vec2(corner_cell[k] % map_size.x, corner_cell[k] / map_size.x);
        gl_Position = vec4((texel + 0.5) / vec2(map_size) * 2.0 - 1.0, 0.0, 1.0);
        EmitVertex();
        EndPrimitive();
    }
}
