// Edge collapse in rounds, begin and end of a frame: the mesh as rings of vertices, and triangles as the blocks leave them.
//
// Source    none
// Work      1-D, one item per chunk of vertices, of rows or of blocks of rows
// Reads     points        float4[vertex_count]      w: triangles at the vertex, LOCKED added where it stays
//           numbers       uint[vertices]            of the first generation
//           parents       uint[vertex_count]        where a vertex went
// Writes    places        float4[vertices]          x y z, locked
//           ids           uint[vertices]            the vertex of the mesh
//           degrees       uint[vertices]            triangles
//           absorbed      uint[vertices]
//           touched       uchar[vertices]
//           rims          uint[vertices]
//           cursors       uint[vertices]            corners that a vertex has so far
//           new_ring, ring  uint2[corners]          next, previous vertex of each triangle at a vertex
//           costs         float[corners]
//           roots         uint[vertex_count]        where a vertex went in the end
//           rows          uint4[triangle_count]     a b c, row of the input; a = b where a vertex is named twice
//           block_live    uint[blocks]
//           state         uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl cluster/edge_collapse/setup.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// the mesh as the first generation, but for rings
__kernel void edge_collapse_rounds_ends_begin(
    __global const float4 *restrict points,
    __global float4 *restrict places,
    __global uint *restrict ids,
    __global uint *restrict degrees,
    __global uint *restrict absorbed,
    __global uchar *restrict touched,
    __global uint *restrict rims,
    __global uint *restrict state,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        const float4 p = points[v];
        const bool locked = p.w >= LOCKED;
        places[v] = (float4)(p.xyz, locked);
        ids[v] = v;
        degrees[v] = (uint)(locked ? p.w - LOCKED : p.w);
        absorbed[v] = rims[v] = NONE;
        touched[v] = CHANGED;
    }
    if (chunk == 0) {
        state[VERTICES] = vertex_count;
        state[LIVE] = NONE; // until the corners are counted
    }
}

// the first rings: corners in any order
__kernel void edge_collapse_rounds_ends_scatter(
    __global const uint4 *restrict rows,
    __global const uint *restrict numbers,
    __global uint *restrict cursors,
    __global uint2 *restrict new_ring,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint t = range.x; t < range.y; ++t) {
        const uint4 row = rows[t];
        if (row.x == row.y) continue;
        const uint a = numbers[row.x], b = numbers[row.y], c = numbers[row.z];
        new_ring[atomic_inc(cursors + a)] = (uint2)(b, c);
        new_ring[atomic_inc(cursors + b)] = (uint2)(c, a);
        new_ring[atomic_inc(cursors + c)] = (uint2)(a, b);
    }
}

// and then in the order of their vertices, whichever came first
__kernel void edge_collapse_rounds_ends_order(
    __global const uint *restrict starts,
    __global uint2 *restrict ring,
    __global float *restrict costs,
    __global const uint *restrict state,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    for (uint v = range.x; v < range.y; ++v) {
        const uint begin = starts[v], past = starts[v + 1];
        for (uint e = begin; e < past; ++e) {
            const uint2 item = ring[e];
            uint to = e;
            for (; to > begin && (ring[to - 1].x > item.x || (ring[to - 1].x == item.x && ring[to - 1].y > item.y)); --to)
                ring[to] = ring[to - 1];
            ring[to] = item;
            costs[e] = STALE;
        }
    }
}

// the end: triangles of the mesh by where their corners went, those that are left at the front of their blocks
__kernel void edge_collapse_rounds_ends_roots(
    __global const uint *restrict parents,
    __global uint *restrict roots,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 range = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = range.x; v < range.y; ++v) {
        uint root = v;
        while (parents[root] != root) root = parents[root];
        roots[v] = root;
    }
}

__kernel void edge_collapse_rounds_ends_rows(
    __global const uint *restrict roots,
    __global uint4 *restrict rows,
    __global uint *restrict block_live,
    const uint block,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint blocks = (triangle_count + block - 1) / block;
    const uint begin = (ulong)chunk * blocks / chunk_count, end = (ulong)(chunk + 1) * blocks / chunk_count;
    for (uint b = begin; b < end; ++b) {
        uint kept = b * block;
        for (uint t = b * block; t < min((b + 1) * block, triangle_count); ++t) {
            const uint4 row = rows[t], to = (uint4)(roots[row.x], roots[row.y], roots[row.z], row.w);
            if (row.x != row.y && to.x != to.y && to.y != to.z && to.z != to.x) rows[kept++] = to;
        }
        block_live[b] = kept - b * block;
    }
}
