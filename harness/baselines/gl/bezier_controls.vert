#version 400
// Before tessellation: a control point as it is, and whose it is.
in vec4 control_point;
out vec4 control;
flat out int control_patch; // gl_PrimitiveID starts again where llvmpipe splits a draw

void main()
{
    control = control_point;
    control_patch = gl_VertexID / 16;
}
