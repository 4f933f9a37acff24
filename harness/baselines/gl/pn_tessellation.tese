#version 400
// Evaluation stage of curved PN triangles: the cubic's point and the quadratic's normal at the tessellator's weights.
// Vlachos et al. 2001, sections 3.1 and 3.3.
layout(triangles, equal_spacing, ccw) in;
uniform mat4 world_to_clip;
in vec3 patch_position[];
in vec3 patch_normal[];
in vec3 near_point[];
in vec3 far_point[];
in vec3 middle_normal[];
flat in int patch_number[];
patch in vec3 centre_point;
out vec3 surface_position;
out vec3 shaded_normal;
out vec3 weights; // for transform feedback
flat out ivec3 corners; // whose weights these are: gl_PrimitiveID starts again where llvmpipe splits a draw

void main()
{
    weights = gl_TessCoord;
    corners = ivec3(patch_number[0], patch_number[1], patch_number[2]);
    float w = weights.x, u = weights.y, v = weights.z;
    float uu = u * u, vv = v * v, ww = w * w;
    surface_position = w * ww * patch_position[0] + u * uu * patch_position[1] + v * vv * patch_position[2] +
                       3.0 * (w * (w * u * near_point[0] + uu * far_point[0]) +
                              u * (u * v * near_point[1] + vv * far_point[1]) +
                              v * (v * w * near_point[2] + ww * far_point[2])) +
                       6.0 * w * u * v * centre_point;
    shaded_normal = normalize(ww * patch_normal[0] + uu * patch_normal[1] + vv * patch_normal[2] +
                              w * u * middle_normal[0] + u * v * middle_normal[1] + v * w * middle_normal[2]);
    gl_Position = world_to_clip * vec4(surface_position, 1.0);
}
