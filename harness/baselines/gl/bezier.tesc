#version 400
// Control stage of Bezier patches: as many segments along every edge. The sixteen control points go on as they are.
layout(vertices = 16) out;
uniform float segments;
in vec4 control[];
flat in int control_patch[];
out vec4 patch_control[];
patch out int patch_index;

void main()
{
    patch_control[gl_InvocationID] = control[gl_InvocationID];
    patch_index = control_patch[0];
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = gl_TessLevelOuter[3] = segments;
    gl_TessLevelInner[0] = gl_TessLevelInner[1] = segments;
}
