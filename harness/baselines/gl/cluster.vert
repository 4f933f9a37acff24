#version 400
// Vertex stage of quadric clustering: the position in cell edges from the box corner, and the cell that holds it.
// DeCoro & Tatarchuk 2007, slide 12; rounded step by step as the kernels round, so that the cells are the same.
uniform vec4 low;      // box corner times w; w a power of two
uniform vec4 per_axis; // cells per unit; w units per scaled model unit
uniform ivec3 cells;
in vec3 position;
out vec3 corner_point;
flat out int corner_cell;

void main()
{
    precise vec3 offset = position * low.w - low.xyz;
    precise vec3 point = offset * per_axis.w;
    precise vec3 along = point * per_axis.xyz;
    ivec3 cell = min(ivec3(along), cells - 1);
    corner_point = point;
    corner_cell = (cell.z * cells.y + cell.y) * cells.x + cell.x;
}
