// Octree, cut: for every vertex the largest node that its finest cell was joined to.
//
// Source    DeCoro & Tatarchuk 2007, slides 31-33
// Work      1-D, one item per chunk of finest cells, of vertices, of triangles or of nodes
// Reads     parents     uint[]                      the root's is itself
//           joins       uint[]                      the node that a node is joined to, or 0xFFFFFFFF; see boxes.cl
//           points      float4[vertex_count]        w: bits of the finest cell's rank
//           triangles   uint[3 * triangle_count]
//           new_ranks   uint[node_count]            output vertex of a node
//           kept        uint[kept_count]            border vertices
// Writes    cut         uint[leaf_count]            the node that a finest cell goes to
//           nodes       uint[vertex_count]          the node that a vertex goes to
//           piece_counts  uint[chunk_count]         triangles whose corners lie in three nodes
//           pieces      uint[3 * triangle_count]    their nodes, one piece per chunk, from the chunk's first row on
//           used        uchar[node_count]           1: a surviving triangle has a corner in it; several items may write
//                                                   the same 1
//           solved      float4[node_count]          w: 0 where not used; more than 0 for what is kept
//           chunk_sums  uint[chunk_count]           used nodes
//           survivors   uint[3 * triangle_count]    output triangles
//           counts      uint[2]                     [1]: output triangles
//           vertex_map  uint[vertex_count]          the output vertex, or 0xFFFFFFFF
// Needs     common/chunk.cl
// Plain     cluster/octree/reference.py

#define NO_NODE 0xFFFFFFFFu

__kernel void octree_cut_leaves(
    __global const uint *restrict parents,
    __global const uint *restrict joins,
    __global uint *restrict cut,
    const uint leaf_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, leaf_count);
    for (uint leaf = rows.x; leaf < rows.y; ++leaf) {
        uint found = leaf;
        for (uint node = leaf; parents[node] != node; node = parents[node])
            found = joins[node] != NO_NODE ? joins[node] : found;
        cut[leaf] = found;
    }
}

__kernel void octree_cut_vertices(
    __global const float4 *restrict points,
    __global const uint *restrict cut,
    __global uint *restrict nodes,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) nodes[v] = cut[as_uint(points[v].w)];
}

// border vertices that stay by themselves, after all nodes
__kernel void octree_cut_keep(
    __global const uint *restrict kept,
    __global uint *restrict nodes,
    __global float4 *restrict solved,
    const uint first,
    const uint kept_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, kept_count);
    for (uint i = rows.x; i < rows.y; ++i) {
        nodes[kept[i]] = first + i;
        solved[first + i] = (float4)(0.0f, 0.0f, 0.0f, 1.0f); // it comes back from the positions
    }
}

__kernel void octree_cut_triangles(
    __global const uint *restrict nodes,
    __global const uint *restrict triangles,
    __global uint *restrict pieces,
    __global uint *restrict piece_counts,
    __global uchar *restrict used,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    // without a branch that nobody could foresee: the next one goes where this one is, if it does not survive
    __global uint *piece = pieces + 3 * (size_t)rows.x;
    uint count = 0;
    for (uint t = rows.x; t < rows.y; ++t) {
        const uint3 v = vload3(t, triangles);
        const uint a = nodes[v.x], b = nodes[v.y], c = nodes[v.z];
        __global uint *out = piece + 3 * (size_t)count;
        out[0] = a;
        out[1] = b;
        out[2] = c;
        count += (a != b) & (b != c) & (c != a);
    }
    for (size_t i = 0; i < 3 * (size_t)count; ++i) used[piece[i]] = 1;
    piece_counts[chunk] = count;
}

__kernel void octree_cut_used(
    __global const uchar *restrict used,
    __global float4 *restrict solved,
    __global uint *restrict chunk_sums,
    const uint node_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, node_count);
    uint count = 0;
    for (uint node = rows.x; node < rows.y; ++node) {
        if (!used[node]) solved[node].w = 0.0f;
        count += used[node];
    }
    chunk_sums[chunk] = count;
}

__kernel void octree_cut_join(
    __global const uint *restrict pieces,
    __global const uint *restrict piece_counts,
    __global const uint *restrict new_ranks,
    __global uint *restrict survivors,
    __global uint *restrict counts,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    const size_t from = 3 * (size_t)rows.x, to = 3 * (size_t)chunk_sum_before(chunk, piece_counts);
    const uint count = piece_counts[chunk];
    for (size_t i = 0; i < 3 * (size_t)count; ++i) survivors[to + i] = new_ranks[pieces[from + i]];
    if (chunk == chunk_count - 1) counts[1] = (uint)(to / 3) + count;
}

__kernel void octree_cut_map(
    __global const uint *restrict nodes,
    __global const uint *restrict new_ranks,
    __global uint *restrict vertex_map,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) vertex_map[v] = new_ranks[nodes[v]];
}
