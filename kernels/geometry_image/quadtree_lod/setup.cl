// Quadtree over a geometry image, set-up: how far does each node's flat stand-in lie from its samples?
//
// Source    Wang et al., section 3.1; what a node's error is, and that it is saturated, is a reconstruction
// Work      1-D, one item per node of one level; a level is launched when the one below it is done
// Reads     positions  float [3 * side * side]   row-major samples, side = 2^n + 1, model units
//           corners    float [3 * (2^depth + 1)^2]   where the level's vertices lie
// Writes    errors     float [texel_count]       packed; the larger of the node's own and its children's, model units;
//                                                leaves 0
//           bounds     float [4 * texel_count / 3]   packed, upper part, four planes: x, y, z, radius of a sphere that
//                                                    holds the children's
// Needs     common/quadtree.cl
// Plain     geometry_image/quadtree_lod/reference.py

static inline float3 sample(__global const float *restrict positions, const uint i, const uint j, const uint n)
{
    const size_t at = 3 * ((size_t)j * ((1u << n) + 1) + i);
    return (float3)(positions[at], positions[at + 1], positions[at + 2]);
}

// the area around a sample, as far as it lies in the node: steps to the neighbours, halved where there is but one
static inline float area_at(
    __global const float *restrict positions, const uint i, const uint j, const uint2 low, const uint2 high, const uint n)
{
    const uint left = i > low.x ? i - 1 : i, right = i < high.x ? i + 1 : i;
    const uint below = j > low.y ? j - 1 : j, above = j < high.y ? j + 1 : j;
    const float3 across = sample(positions, right, j, n) - sample(positions, left, j, n);
    const float3 up = sample(positions, i, above, n) - sample(positions, i, below, n);
    const float3 both = cross(across, up);
    return 0.25f * sqrt(dot(both, both));
}

__kernel void quadtree_lod_setup_error(
    __global const float *restrict positions,
    __global const float *restrict corners,
    __global float *errors,
    const float per_area, // one over the whole area: the node's share of the squared error; 0: its largest distance
    const uint depth,
    const uint n,
    const uint node_count)
{
    const uint node = get_global_id(0);
    if (node >= node_count) return;

    const uint x = node & ((1u << depth) - 1), y = node >> depth, size = 1u << (n - depth);
    const uint2 low = (uint2)(x * size, y * size), high = low + size;
    const float3 p = sample(corners, x, y, depth), q = sample(corners, x + 1, y, depth);
    const float3 r = sample(corners, x + 1, y + 1, depth), s = sample(corners, x, y + 1, depth);
    const bool anti = quadtree_anti_diagonal(low.x, low.y, size, n);
    const float step = 1.0f / (float)size;
    float worst = 0.0f, sum = 0.0f;
    for (uint j = 0; j <= size; ++j) {
        float row = 0.0f;
        for (uint i = 0; i <= size; ++i) {
            const float u = (float)i * step, v = (float)j * step;
            float3 flat;
            if (anti)
                flat = i + j <= size ? p + u * (q - p) + v * (s - p) : r + (1.0f - u) * (s - r) + (1.0f - v) * (q - r);
            else
                flat = i >= j ? p + u * (q - p) + v * (r - q) : p + v * (s - p) + u * (r - s);
            const float3 apart = sample(positions, low.x + i, low.y + j, n) - flat;
            const float square = dot(apart, apart);
            worst = fmax(worst, square);
            if (per_area != 0.0f) row += square * area_at(positions, low.x + i, low.y + j, low, high, n);
        }
        sum += row;
    }
    float error = sqrt(per_area != 0.0f ? sum * per_area : worst);
    if (depth + 1 < n)
        for (uint child = 0; child < 4; ++child)
            error = fmax(error, errors[quadtree_texel(depth + 1, 2 * x + (child & 1), 2 * y + (child >> 1), n)]);
    errors[quadtree_texel(depth, x, y, n)] = error;
}

static inline float4 bound_at(__global const float *bounds, const uint texel, const uint plane)
{
    return (float4)(bounds[texel], bounds[plane + texel], bounds[2 * plane + texel], bounds[3 * plane + texel]);
}

__kernel void quadtree_lod_setup_bound(
    __global const float *restrict positions,
    __global float *bounds,
    const uint depth,
    const uint n,
    const uint node_count)
{
    const uint node = get_global_id(0);
    if (node >= node_count) return;

    const uint x = node & ((1u << depth) - 1), y = node >> depth, size = 1u << (n - depth);
    const uint leaves = 1u << (2 * n), plane = leaves / 2; // leaves have no bounds: nothing asks how far they are
    float3 centre = 0.0f;
    float radius = 0.0f;
    if (depth + 1 == n) {
        for (uint k = 0; k < 9; ++k) centre += sample(positions, x * size + k % 3, y * size + k / 3, n);
        centre /= 9.0f;
        for (uint k = 0; k < 9; ++k)
            radius = fmax(radius, distance(centre, sample(positions, x * size + k % 3, y * size + k / 3, n)));
    } else {
        float4 child[4];
        for (uint k = 0; k < 4; ++k) {
            child[k] = bound_at(bounds, quadtree_texel(depth + 1, 2 * x + (k & 1), 2 * y + (k >> 1), n) - leaves, plane);
            centre += 0.25f * child[k].xyz;
        }
        for (uint k = 0; k < 4; ++k) radius = fmax(radius, distance(centre, child[k].xyz) + child[k].w);
    }
    const uint texel = quadtree_texel(depth, x, y, n) - leaves;
    bounds[texel] = centre.x;
    bounds[plane + texel] = centre.y;
    bounds[2 * plane + texel] = centre.z;
    bounds[3 * plane + texel] = radius;
}
