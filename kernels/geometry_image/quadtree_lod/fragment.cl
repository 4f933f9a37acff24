// Quadtree over a geometry image, fragment stage: which nodes are drawn?
//
// Source    Wang et al., section 3.2, steps 1-4; that the parent must itself be too coarse, not merely not drawn, and
//           the rule in pixels per node are a reconstruction
// Work      1-D, one item per packed texel
// Reads     errors  float [texel_count]       packed, never smaller than a child's
//           bounds  float4[texel_count / 3]   packed, upper part: centre, radius; each holds its children's
// Writes    states  uchar [texel_count]       0 too coarse: its children are looked at; 1 nothing to draw; 2 drawn
// Needs     common/quadtree.cl

// exactly one texel on each way from the root to a leaf is drawn: the first that is fine enough, or the leaf.
// The four nodes of depth 1 are the coarsest: the root's corners are one point
static inline uchar state_of(const bool fine, const bool parent_fine) { return parent_fine ? 1 : fine ? 2 : 0; }

// column and row of a texel's parent, or a column of 0 where there is none to ask; .s2 is the texel's own depth
static inline uint3 parent_of(const uint x, const uint y, const uint n)
{
    const uint side = 1u << n;
    if (y < side) return (uint3)(n > 1 ? side / 2 + x / 2 : 0, side + y / 2, n);
    const uint depth = quadtree_column_depth(x | 1);
    return (uint3)(depth > 1 ? x / 2 : 0, side + (y - side) / 2, depth);
}

// column 0 and the rows above a level's own square hold no node
static inline bool is_node(const uint x, const uint y, const uint n)
{
    return y >> n == 0 || (x > 0 && y - (1u << n) < 1u << quadtree_column_depth(x | 1));
}

__kernel void quadtree_lod_fragment_filter(
    __global const float *restrict errors,
    __global uchar *restrict states,
    const float threshold, // model units
    const uint n,
    const uint texel_count)
{
    const uint texel = get_global_id(0);
    if (texel >= texel_count) return;

    const uint x = texel & ((1u << n) - 1), y = texel >> n;
    const uint3 parent = parent_of(x, y, n);
    const bool root = parent.z == 0;
    const bool fine = parent.z == n || (!root && errors[texel] < threshold);
    const bool parent_fine = parent.x != 0 && errors[(parent.y << n) + parent.x] < threshold;
    states[texel] = is_node(x, y, n) ? state_of(fine, parent_fine) : 1;
}

// error * scale < distance to the node's sphere: the error's size on screen is below the tolerance.
// `slack` outweighs the rounding of two distances, so that no node looks farther away than its parent's parts
static inline bool fine_in_view(
    __global const float *restrict errors,
    __global const float4 *restrict bounds,
    const uint texel,
    const uint depth,
    const uint n,
    const float4 eye_scale,
    const float2 near_slack)
{
#pragma OPENCL FP_CONTRACT OFF
    const float4 bound = bounds[texel - (1u << (2 * n))];
    const float3 apart = bound.xyz - eye_scale.xyz;
    const float square = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
    const float away = (sqrt(square) - bound.w) + (float)depth * near_slack.y;
    return errors[texel] * eye_scale.w < (away > near_slack.x ? away : near_slack.x);
}

__kernel void quadtree_lod_fragment_filter_view(
    __global const float *restrict errors,
    __global const float4 *restrict bounds,
    __global uchar *restrict states,
    const float4 eye_scale, // xyz = eye, w = pixels per model unit at distance 1, per pixel of tolerance
    const float2 near_slack, // smallest distance, slack per depth; model units
    const uint n,
    const uint texel_count)
{
    const uint texel = get_global_id(0);
    if (texel >= texel_count) return;

    const uint x = texel & ((1u << n) - 1), y = texel >> n;
    if (!is_node(x, y, n)) {
        states[texel] = 1;
        return;
    }
    const uint3 parent = parent_of(x, y, n);
    const uint depth = parent.z;
    const bool parent_fine = parent.x != 0
        && fine_in_view(errors, bounds, (parent.y << n) + parent.x, depth - 1, n, eye_scale, near_slack);
    const bool fine = depth == n
        || (depth > 0 && !parent_fine && fine_in_view(errors, bounds, texel, depth, n, eye_scale, near_slack));
    states[texel] = state_of(fine, parent_fine);
}
