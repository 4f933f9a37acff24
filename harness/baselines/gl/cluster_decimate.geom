#version 400
// Pass 3: a triangle survives when its corners lie in three cells; their representatives are streamed out.
// DeCoro & Tatarchuk 2007, slide 17.
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;
uniform ivec2 map_size;
uniform sampler2D representatives;
flat in int corner_cell[];
out vec3 kept_point;
flat out int kept_cell;

void main()
{
    int a = corner_cell[0], b = corner_cell[1], c = corner_cell[2];
    if (a == b || b == c || c == a) return;
    for (int k = 0; k < 3; ++k) {
        kept_cell = corner_cell[k];
        kept_point = texelFetch(representatives, ivec2(kept_cell % map_size.x, kept_cell / map_size.x), 0).xyz;
        EmitVertex();
    }
    EndPrimitive();
}
