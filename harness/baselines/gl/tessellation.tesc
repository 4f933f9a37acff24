#version 400
// Control stage: as many segments along every edge.
layout(vertices = 3) out;
uniform float segments;
in vec3 corner_position[];
in vec3 corner_normal[];
flat in int corner_number[];
out vec3 patch_position[];
out vec3 patch_normal[];
flat out int patch_number[];

void main()
{
    patch_position[gl_InvocationID] = corner_position[gl_InvocationID];
    patch_normal[gl_InvocationID] = corner_normal[gl_InvocationID];
    patch_number[gl_InvocationID] = corner_number[gl_InvocationID];
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = segments;
    gl_TessLevelInner[0] = segments;
}
