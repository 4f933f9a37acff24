#version 400
// Evaluation stage: the point and the unit normal at the weights that the fixed-function tessellator made.
layout(triangles, equal_spacing, ccw) in;
uniform mat4 world_to_clip;
in vec3 patch_position[];
in vec3 patch_normal[];
flat in int patch_number[];
out vec3 surface_position;
out vec3 shaded_normal;
out vec3 weights; // for transform feedback
flat out ivec3 corners; // whose weights these are: gl_PrimitiveID starts again where llvmpipe splits a draw

void main()
{
    weights = gl_TessCoord;
    corners = ivec3(patch_number[0], patch_number[1], patch_number[2]);
    surface_position = weights.x * patch_position[0] + weights.y * patch_position[1] + weights.z * patch_position[2];
    shaded_normal = normalize(weights.x * patch_normal[0] + weights.y * patch_normal[1] + weights.z * patch_normal[2]);
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
