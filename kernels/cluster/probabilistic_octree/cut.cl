// Probabilistic octree, cut: the slot of the coarsest level that the threshold allows, read from the table for each vertex.
//
// Source    DeCoro & Tatarchuk 2007, slides 31-33: scanning or binary search along the way to the root, the parent where a
//           node was lost
// Work      1-D, one item per chunk of vertices
// Reads     points  float4[vertex_count]           w: bits of the finest cell's code
//           keys    int[2 * slot_count]            largest key, largest negative key
//           errors  float[slot_count]
// Writes    nodes   uint[vertex_count]             slot that the vertex goes to
// Needs     common/chunk.cl cluster/octree/cell.cl cluster/probabilistic_octree/key.cl
// Plain     cluster/probabilistic_octree/reference.py

#define NO_SLOT 0xFFFFFFFFu

// the node's slot, or NO_SLOT where another key was written to it, or none: the root is always there
static inline uint cut_read(__global const int2 *restrict keys, const uint code, const uint level, const uint finest,
    const uint slot_count, const uint seed)
{
    if (!level) return 0;
    const int key = key_of(code, level, finest);
    const uint slot = key_slot(key, slot_count, seed);
    const int2 found = keys[slot];
    return found.x == key && found.y == -key ? slot : NO_SLOT;
}

__kernel void probabilistic_octree_cut_linear(
    __global const float4 *restrict points,
    __global const int2 *restrict keys,
    __global const float *restrict errors,
    __global uint *restrict nodes,
    const float limit,
    const uint finest,
    const uint seed,
    const uint slot_count,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) {
        uint chosen = 0;
        for (uint level = 0; level <= finest; ++level) {
            const uint slot = cut_read(keys, as_uint(points[v].w), level, finest, slot_count, seed);
            if (slot == NO_SLOT) continue;
            chosen = slot; // the finest one that is there, unless a coarser one will do
            if (errors[slot] <= limit) break;
        }
        nodes[v] = chosen;
    }
}

// as if errors fell from level to level; a lost node is answered for by the nearest one above it
__kernel void probabilistic_octree_cut_binary(
    __global const float4 *restrict points,
    __global const int2 *restrict keys,
    __global const float *restrict errors,
    __global uint *restrict nodes,
    const float limit,
    const uint finest,
    const uint seed,
    const uint slot_count,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) {
        const uint code = as_uint(points[v].w);
        uint low = 0, high = finest + 1, chosen = 0, finest_slot = 0, finest_level = 0; // the answer lies in low .. high
        bool met = false;
        while (low < high) {
            const uint middle = (low + high) / 2;
            uint level = middle, slot = cut_read(keys, code, level, finest, slot_count, seed);
            while (slot == NO_SLOT && level > low) slot = cut_read(keys, code, --level, finest, slot_count, seed);
            if (slot != NO_SLOT && errors[slot] <= limit) {
                chosen = slot;
                met = true;
                high = level;
            } else {
                if (slot != NO_SLOT && level >= finest_level) {
                    finest_slot = slot;
                    finest_level = level;
                }
                low = middle + 1;
            }
        }
        nodes[v] = met ? chosen : finest_slot;
    }
}
