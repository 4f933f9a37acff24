#version 400
// Pass 2: each cell's representative, a full-screen triangle over the map.
// DeCoro & Tatarchuk 2007, slides 14-15; the cascade around the mean is a reconstruction, as in the kernels.
uniform sampler2D corner_sums, quadrics_0, quadrics_1, quadrics_2;
uniform int placement; // 0 robust, 1 paper, 2 average
uniform float per_box; // 1 / longest box edge, cell edges
in float down;
out vec4 representative; // x y z in cell edges, 1 where the cell holds something

// -(A + ridge I)^-1 b by LDL^T; cofactors would not survive float32
vec3 solve(float xx, float xy, float xz, float yy, float yz, float zz, vec3 b, float ridge, out float determinant)
{
    float d0 = xx + ridge;
    float l10 = xy / d0, l20 = xz / d0;
    float d1 = yy + ridge - l10 * xy;
    float t21 = yz - l20 * xy;
    float l21 = t21 / d1;
    float d2 = zz + ridge - l20 * xz - l21 * t21;
    determinant = d0 * d1 * d2;
    vec3 y = vec3(b.x, b.y - l10 * b.x, 0.0);
    y.z = b.z - l20 * b.x - l21 * y.y;
    vec3 s;
    s.z = y.z / d2;
    s.y = y.y / d1 - l21 * s.z;
    s.x = y.x / d0 - l10 * s.y - l20 * s.z;
    return -s;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sums = texelFetch(corner_sums, at, 0);
    if (sums.w == 0.0) {
        representative = vec4(0.0);
        return;
    }
    vec4 q0 = texelFetch(quadrics_0, at, 0), q1 = texelFetch(quadrics_1, at, 0);
    vec3 b = texelFetch(quadrics_2, at, 0).xyz;
    float xx = q0.x, xy = q0.y, xz = q0.z, yy = q0.w, yz = q1.x, zz = q1.y, determinant;
    vec3 mean = sums.xyz / sums.w;
    b += vec3(xx * mean.x + xy * mean.y + xz * mean.z, xy * mean.x + yy * mean.y + yz * mean.z,
              xz * mean.x + yz * mean.y + zz * mean.z);
    vec3 best = mean;
    float trace = xx + yy + zz;
    if (placement == 0 && trace > 1e-30) {
        float s = 1.0 / trace;
        for (float ridge = 1e-3; ridge < 0.5; ridge *= 10.0) {
            vec3 step = solve(xx * s, xy * s, xz * s, yy * s, yz * s, zz * s, b * s, ridge, determinant);
            if (dot(step, step) <= 1.0) {
                best = mean + step;
                break;
            }
        }
    } else if (placement == 1) {
        float s = per_box * per_box;
        vec3 step = solve(xx * s, xy * s, xz * s, yy * s, yz * s, zz * s, b * s, 0.0, determinant);
        if (determinant > 1e-11 && dot(step, step) < 1e30) best = mean + step;
    }
    representative = vec4(best, 1.0);
}
