#version 400
// Before tessellation: a coarse corner as it is.
in vec3 position;
in vec3 normal;
out vec3 corner_position;
out vec3 corner_normal;
flat out int corner_number; // for transform feedback

void main()
{
    corner_position = position;
    corner_normal = normal;
    corner_number = gl_VertexID;
}
