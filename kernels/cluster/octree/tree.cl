// Octree, set-up: the occupied cells of every level, from those of the finest one.
//
// Source    DeCoro & Tatarchuk 2007, slides 29-31; along the Morton curve a parent's children are neighbours, so that a
//           node begins where the leading bits of two cells that follow each other differ (reconstruction)
// Work      1-D, one item per chunk of 64-cell words, or of occupied finest cells
// Reads     words         ulong2[word_count]         x: the cells' bits, y: occupied cells before these 64
//           starts        uint[LEVELS]               by level: its first node; the finest level's is 0
// Writes    chunk_sums    uint[chunk_count]          occupied finest cells of each chunk of words
//           codes         uint[leaf_count]           the occupied finest cells, ascending
//           chunk_counts  uint[LEVELS * chunk_count]  nodes that begin in each chunk, by level
//           centres       float4[node_count]         x y z in units of the finest cell edge, the cell's edge
//           parents       uint[node_count]           the root's is itself
//           firsts        uint[node_count]           first child; not written for the finest level
// Needs     common/chunk.cl cluster/octree/cell.cl
// Plain     cluster/octree/reference.py

__kernel void octree_tree_leaves(
    __global const ulong2 *restrict words,
    __global uint *restrict chunk_sums,
    const uint word_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);
    uint count = 0;
    for (uint w = rows.x; w < rows.y; ++w) count += (uint)popcount(words[w].x);
    chunk_sums[chunk] = count;
}

__kernel void octree_tree_codes(
    __global const ulong2 *restrict words,
    __global uint *restrict codes,
    const uint word_count,
    const uint leaf_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, word_count);
    for (uint w = rows.x; w < rows.y; ++w) {
        uint rank = (uint)words[w].y;
        for (ulong bits = words[w].x; bits && rank < leaf_count; bits &= bits - 1)
            codes[rank++] = 64 * w + (uint)popcount((bits & (~bits + 1)) - 1);
    }
}

// bits in which a leaf's cell differs from the one before; all of them for the first
static inline uint tree_changed(__global const uint *restrict codes, const uint leaf)
{
    return leaf ? codes[leaf] ^ codes[leaf - 1] : 0xFFFFFFFFu;
}

__kernel void octree_tree_count(
    __global const uint *restrict codes,
    __global uint *restrict chunk_counts,
    const uint finest,
    const uint leaf_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint counts[LEVELS];
    for (uint level = 0; level < LEVELS; ++level) counts[level] = 0;
    const uint2 rows = chunk_rows(chunk, chunk_count, leaf_count);
    // by the coarsest level of which a node begins, then all below it
    for (uint leaf = rows.x; leaf < rows.y; ++leaf) {
        const uint top = (31 - clz(tree_changed(codes, leaf))) / 3;
        ++counts[finest - min(top, finest)];
    }
    for (uint level = 1; level < LEVELS; ++level) counts[level] = level <= finest ? counts[level] + counts[level - 1] : 0;
    for (uint level = 0; level < LEVELS; ++level) chunk_counts[LEVELS * chunk + level] = counts[level];
}

__kernel void octree_tree_link(
    __global const uint *restrict codes,
    __global const uint *restrict chunk_counts,
    __global const uint *restrict starts,
    __global float4 *restrict centres,
    __global uint *restrict parents,
    __global uint *restrict firsts,
    const uint finest,
    const uint leaf_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    uint next[LEVELS];
    for (uint level = 0; level <= finest; ++level) {
        next[level] = starts[level];
        for (uint c = 0; c < chunk; ++c) next[level] += chunk_counts[LEVELS * c + level];
    }
    const uint2 rows = chunk_rows(chunk, chunk_count, leaf_count);
    for (uint leaf = rows.x; leaf < rows.y; ++leaf) {
        const uint code = codes[leaf], changed = tree_changed(codes, leaf);
        for (uint up = 0; up <= finest; ++up) {
            const uint level = finest - up, node = next[level]++, own = code >> (3 * up);
            const float edge = (float)(1u << up);
            centres[node] = (float4)(((float)octree_gather(own) + 0.5f) * edge, ((float)octree_gather(own >> 1) + 0.5f) * edge,
                ((float)octree_gather(own >> 2) + 0.5f) * edge, edge);
            if (!level) {
                parents[node] = node;
                break;
            }
            const bool begins = changed >> (3 * up + 3);
            const uint parent = next[level - 1] - !begins;
            parents[node] = parent;
            if (!begins) break;
            firsts[parent] = node;
        }
    }
}
