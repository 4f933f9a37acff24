// Edge collapse, geometry stage: each block by itself collapses its cheapest edges, one after the other.
//
// Source    Garland & Heckbert 1997, greedy by cost; the blocks and their shared threshold are ours
// Work      1-D; items take the next block until none is left, so which takes which does not matter
// Reads     sorted      uint4[triangle_count]     a b c, row of the input; each block has `EACH` rows
//           schedule    uint[16 * sweeps]
//           quotas      uint[blocks]              triangles that a block may take away, even but for a single one
// Writes    histograms  uint[BINS * blocks]       edges of the blocks that are asked, by cost
//           points      float4[vertex_count]      of vertices that moved
//           loss        uint[vertex_count]        triangles that the block took from vertices that it shares
//           parents     uint[vertex_count]        where a vertex went
//           rows        uint4[triangle_count]     the triangles left, at the front of the block's rows
//           block_live  uint[blocks]
//           state       uint[16]
//           scratch     uint[SLICE_WORDS * items]
//           sequence    uint4[vertex_count]       of each vertex that went, where recorded: sweep, the most that the block
//                                                 had paid, block, its collapses before; by these, a valid order of all
//           moves       float4[vertex_count]      where the vertex that it went to lies then, triangles that went
//           limits      float[vertex_count]       where limited: of the root of what a collapse costs there in the mean
//           held        float8[vertex_count]      where attributes count: quadrics besides those of planes; A, summed up
// Needs     cluster/edge_collapse/collapse.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)
// Plain     cluster/edge_collapse/reference.py

INLINE void geometry_count(const Block *b, Edges *edges, __global uint *histogram)
{
    float costs[8];
    vstore8(block_costs(b, edges), 0, costs);
    for (uint i = 0; i < edges->count; ++i) ++histogram[cost_bin(costs[i])];
}

INLINE void geometry_append(Block *b, Edges *edges, const float threshold)
{
    float costs[8];
    vstore8(block_costs(b, edges), 0, costs);
    if (b->ranks + 8 > EDGES) return;
    for (uint i = 0; i < edges->count; ++i) queue_append(b, edges->u[i], edges->v[i], costs[i], threshold);
}

// the edges of the block, by cost
__kernel void edge_collapse_geometry_sample(
    __global const float4 *restrict points,
    __global const uint4 *restrict sorted,
    __global uint *restrict histograms,
    __global uint *restrict state,
    __global uint *restrict scratch,
    __global const float8 *restrict held,
    const uint holding,
    const float border_weight,
    const uint keep_border,
    const float crease, // cosine
    const uint takers)
{
    const uint item = get_global_id(0);
    if (item >= takers || state[DONE]) return;

    Block b;
    block_open(&b, scratch + (size_t)item * SLICE_WORDS);
    const uint each = state[EACH], blocks = state[BLOCKS], stride = state[STRIDE], live = state[LIVE];
    while (true) {
        const uint index = atomic_inc(state + SAMPLED) * stride;
        if (index >= blocks) return;
        const uint first = index * each;
        block_load(&b, sorted + first, min(first + each, live) - first, points, 0, holding ? held : 0,
            border_weight, keep_border, crease);
        __global uint *histogram = histograms + (size_t)index * BINS;
        for (uint i = 0; i < BINS; ++i) histogram[i] = 0;
        Edges edges = {.more = 0};
        for (uint t = 0; block_edges(&b, &t, &edges);) geometry_count(&b, &edges, histogram);
    }
}

__kernel void edge_collapse_geometry_collapse(
    __global const uint4 *restrict sorted,
    __global const uint *restrict quotas,
    __global const uint *restrict schedule,
    __global float4 *restrict points,
    __global uint *restrict loss,
    __global uint *restrict parents,
    __global uint4 *restrict rows,
    __global uint *restrict block_live,
    __global uint *restrict state,
    __global uint *restrict scratch,
    __global uint4 *restrict sequence,
    __global float4 *restrict moves,
    __global float *restrict limits,
    __global float8 *restrict held,
    const uint holding,
    const uint limited,
    const uint recorded,
    const float border_weight,
    const uint keep_border,
    const float crease, // cosine
    const uint takers)
{
    const uint item = get_global_id(0);
    if (item >= takers || state[DONE]) return;

    Block b;
    block_open(&b, scratch + (size_t)item * SLICE_WORDS);
    const uint each = state[EACH], blocks = state[BLOCKS], live = state[LIVE];
    const float threshold = as_float(state[THRESHOLD]);
    const float turn_limit = as_float(schedule[SWEEP_WORDS * (state[SWEEPS] - 1) + TURN_LIMIT]);
    while (true) {
        const uint index = atomic_inc(state + TAKEN);
        if (index >= blocks) return;
        const uint first = index * each;
        block_load(&b, sorted + first, min(first + each, live) - first, points, limited ? limits : 0,
            holding ? held : 0, border_weight, keep_border, crease);
        Edges edges = {.more = 0};
        for (uint t = 0; block_edges(&b, &t, &edges);) geometry_append(&b, &edges, threshold);
        queue_order(&b);
        int left = quotas[index];
        uint collapses = 0, paid = 0;
        uint u, v, cost;
        while (left > 0 && queue_next(&b, &u, &v, &cost)) {
            const int gone = collapse_gone(&b, u, v);
            if (!gone || gone > left + (blocks == 1)) continue;
            Quadrics one, other, merged;
            block_quadric(&b, u, &one);
            block_quadric(&b, v, &other);
            quadric_merge(&one, &other, &merged);
            around_level(&b, u, v, &merged);
            if (limited && collapse_strays(&b, u, v, &merged)) continue;
            const float3 place = (float3)(merged.px.s0, merged.py.s0, merged.pz.s0);
            if (around_turn(&b, place, turn_limit)) continue;
            collapse_join(&b, u, v, &merged);
            parents[b.ids[u]] = b.ids[v];
            if (holding) held[b.ids[v]] += held[b.ids[u]];
            left -= gone;
            paid = max(paid, cost);
            if (recorded) {
                sequence[b.ids[u]] = (uint4)(state[SWEEPS], paid, index, collapses);
                moves[b.ids[u]] = (float4)(place, gone);
            }
            ++collapses;
            collapse_ask(&b, v, threshold);
        }
        atomic_add(state + COLLAPSES, collapses);
        // back to the mesh: what belongs to the block alone as it is, of what it shares the triangles that went
        for (uint v = 0; v < b.vertices; ++v) {
            const uint id = b.ids[v];
            if (b.kind[v] & WHOLE) {
                points[id] = (float4)(b.places[v].xyz, b.degree[v]);
                if (limited) limits[id] = b.places[v].w;
            } else if (b.degree[v] != b.given[v])
                atomic_add(loss + id, (uint)(b.given[v] - b.degree[v]));
        }
        uint kept = first;
        for (uint t = 0; t < b.triangles; ++t) {
            const ushort4 own = *(__global const ushort4 *)(b.corners + 4 * t);
            if (own.w)
                rows[kept++] = (uint4)(b.ids[own.x], b.ids[own.y], b.ids[own.z], sorted[first + t].w);
        }
        block_live[index] = kept - first;
    }
}
