#version 330
// Vertex stage of a stored mesh: positions to clip space, normals as they are.
uniform mat4 world_to_clip;
in vec3 position;
in vec3 normal;
out vec3 surface_position; // for transform feedback
out vec3 shaded_normal;

void main()
{
    surface_position = position;
    shaded_normal = normal;
    gl_Position = world_to_clip * vec4(position, 1.0);
}
