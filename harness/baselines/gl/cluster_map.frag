#version 400
// Pass 1, fragment stage: four render targets that blending adds up.
flat in vec4 corner_sum, quadric_0, quadric_1, quadric_2;
layout(location = 0) out vec4 target_0;
layout(location = 1) out vec4 target_1;
layout(location = 2) out vec4 target_2;
layout(location = 3) out vec4 target_3;

void main()
{
    target_0 = corner_sum;
    target_1 = quadric_0;
    target_2 = quadric_1;
    target_3 = quadric_2;
}
