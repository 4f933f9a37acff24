// Edge collapse in rounds, between rounds: vertices that are left, numbered in their order, with their rings.
//
// Source    none; a scan over vertices, two counts at once
// Work      1-D, one item per chunk of vertices, of blocks of rows, or of vertices of the mesh
// Reads     points        float4[vertex_count]      w: triangles at the vertex, LOCKED added where it stays
//           rows          uint4[triangle_count]     a b c, row of the input; a = b where a vertex is named twice
//           degrees       uint[vertices]            triangles now
//           absorbed      uint[vertices]
//           touched       uchar[vertices]
//           rims          uint[vertices]
//           rim_costs     float[vertices]
//           parents       uint[vertex_count]
//           places, ids, starts, ring, costs        of the generation before
// Writes    chunk_sums    uint2[chunk_count]        vertices and corners of each chunk
//           numbers       uint[vertices]            in the next generation; where a vertex went, that one's
//           new_places, new_ids, new_starts, new_ring, new_costs, new_rim_costs
//           cursors       uint[vertices]            corners that a vertex has so far
//           roots         uint[vertex_count]        where a vertex went in the end
//           block_live    uint[blocks]
//           state         uint[16]
// Needs     cluster/edge_collapse/rounds_state.cl cluster/edge_collapse/setup.cl
// Plain     cluster/edge_collapse/rounds_reference.py

// the mesh as the first generation, but for rings
__kernel void edge_collapse_rounds_compact_begin(
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
        touched[v] = 1;
    }
    if (chunk == 0) {
        state[VERTICES] = vertex_count;
        state[LIVE] = NONE; // until the corners are counted
    }
}

__kernel void edge_collapse_rounds_compact_sum(
    __global const uint *restrict degrees,
    __global uint2 *restrict chunk_sums,
    __global uint *restrict state,
    const uint target,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;
    // others may see this already: all that follows is of no use then
    if (chunk == 0 && state[LIVE] <= target) atomic_or(state + DONE, 1u);

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    uint2 sum = (uint2)(0, 0);
    for (uint v = range.x; v < range.y; ++v) sum += (uint2)(degrees[v] > 0, degrees[v]);
    chunk_sums[chunk] = sum;
}

__kernel void edge_collapse_rounds_compact_number(
    __global const float4 *restrict places,
    __global const uint *restrict ids,
    __global const uint *restrict degrees,
    __global const uint *restrict absorbed,
    __global const uchar *restrict touched,
    __global const uint *restrict rims,
    __global const float *restrict rim_costs,
    __global const uint2 *restrict chunk_sums,
    __global uint *restrict numbers,
    __global float4 *restrict new_places,
    __global uint *restrict new_ids,
    __global uint *restrict new_starts,
    __global float *restrict new_rim_costs,
    __global uint *restrict cursors,
    __global uint *restrict state,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    uint2 at = (uint2)(0, 0);
    for (uint c = 0; c < chunk; ++c) at += chunk_sums[c];
    for (uint v = range.x; v < range.y; ++v) {
        const uint degree = degrees[v], gone = absorbed[v], rim = rims[v];
        if (degree == 0) continue;
        numbers[v] = at.x;
        if (gone != NONE) numbers[gone] = at.x;
        new_places[at.x] = places[v];
        new_ids[at.x] = ids[v];
        new_starts[at.x] = at.y;
        cursors[at.x] = at.y;
        new_rim_costs[at.x] = rim == NONE || touched[v] || touched[rim] ? STALE : rim_costs[v];
        at += (uint2)(1, degree);
    }
    if (chunk < chunk_count - 1) return;
    new_starts[at.x] = at.y;
    state[VERTICES + 1 - generation] = at.x;
    state[LIVE] = at.y / 3;
}

// the first rings: corners in any order
__kernel void edge_collapse_rounds_compact_scatter(
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
__kernel void edge_collapse_rounds_compact_order(
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

// rings after a round; an edge both of whose ends' rings are as they were keeps its cost
__kernel void edge_collapse_rounds_compact_rings(
    __global const uint *restrict degrees,
    __global const uint *restrict absorbed,
    __global const uchar *restrict touched,
    __global const uint *restrict numbers,
    __global const uint *restrict starts,
    __global const uint2 *restrict ring,
    __global const float *restrict costs,
    __global const uint *restrict new_starts,
    __global uint2 *restrict new_ring,
    __global float *restrict new_costs,
    __global const uint *restrict state,
    const uint generation,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count || state[DONE]) return;

    const uint2 range = chunk_rows(chunk, chunk_count, state[VERTICES + generation]);
    for (uint v = range.x; v < range.y; ++v) {
        if (degrees[v] == 0) continue;
        const uint own = numbers[v], past = new_starts[own + 1];
        uint at = new_starts[own];
        for (uint w = v; w != NONE; w = w == v ? absorbed[v] : NONE)
            for (uint e = starts[w]; e < starts[w + 1]; ++e) {
                const uint2 old = ring[e], pair = (uint2)(numbers[old.x], numbers[old.y]);
                if (pair.x == pair.y || pair.x == own || pair.y == own || at >= past) continue;
                new_costs[at] = touched[v] | touched[old.x] ? STALE : costs[e];
                new_ring[at++] = pair;
            }
        for (; at < past; ++at) { // none is missing in a manifold
            new_ring[at] = (uint2)(own);
            new_costs[at] = STALE;
        }
    }
}

// the end: triangles of the mesh by where their corners went, those that are left at the front of their blocks
__kernel void edge_collapse_rounds_compact_roots(
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

__kernel void edge_collapse_rounds_compact_rows(
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
