#version 400
// Before tessellation: a coarse corner as it is.
in vec3 position;
in vec3 normal;
in float span;
out vec3 corner_position;
out vec3 corner_normal;
out float corner_span;
flat out int corner_number; // for transform feedback

void main()
{
    corner_position = position;
    corner_normal = normal;
    corner_span = span;
    corner_number = gl_VertexID;
}
