// Edge collapse: a block's triangles and their vertices with quadrics, read into its slice.
//
// Source    none
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     common/transpose.cl cluster/edge_collapse/block.cl
// Defines   BLOCK (cluster/edge_collapse/block.cl)

// columns of eight records of four, record v[i] beginning at four numbers times `stride` times that
INLINE fours8 block_columns(__global const float4 *records, const uint stride, const uint *v)
{
    return transpose_fours((float8)(records[stride * v[0]], records[stride * v[4]]),
        (float8)(records[stride * v[1]], records[stride * v[5]]), (float8)(records[stride * v[2]], records[stride * v[6]]),
        (float8)(records[stride * v[3]], records[stride * v[7]]));
}

// planes upright on the border edges at a vertex, whose neighbours there are in one triangle with it
INLINE void block_border(Block *b, const uint u, const float weight)
{
    const uint once = ++b->stamp, twice = ++b->stamp;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        b->mark[w.x] = b->mark[w.x] == once ? twice : once;
        b->mark[w.y] = b->mark[w.y] == once ? twice : once;
    }
    const float3 p = b->places[u].xyz;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        const float3 x = b->places[w.x].xyz - p, y = b->places[w.y].xyz - p;
        const float3 normal = cross(x, y), a = cross(x, normal), z = cross(y, normal);
        const float aa = dot(a, a), zz = dot(z, z);
        if (b->mark[w.x] == once && aa > 0.0f) b->planes[u] += quadric_plane(a, weight * dot(x, x) / aa);
        if (b->mark[w.y] == once && zz > 0.0f) b->planes[u] += quadric_plane(z, weight * dot(y, y) / zz);
    }
}

// planes upright on the creases at a vertex, edges whose two triangles' normals have a cosine below the limit
INLINE void block_creases(Block *b, const uint u, const float weight, const float crease)
{
    const float3 p = b->places[u].xyz;
    for (uint c = b->head[u]; c != NONE; c = b->next[c]) {
        const uint2 w = block_others(b, c);
        const float3 x = b->places[w.x].xyz - p, n = cross(x, b->places[w.y].xyz - p);
        for (uint d = b->head[u]; d != NONE; d = b->next[d]) {
            const uint2 other = block_others(b, d);
            if (other.y != w.x) continue;
            const float3 m = cross(b->places[other.x].xyz - p, x);
            if (dot(n, m) >= crease * sqrt(dot(n, n) * dot(m, m))) continue;
            const float3 one = cross(x, n), two = cross(x, m);
            const float oo = dot(one, one), tt = dot(two, two);
            if (oo > 0.0f) b->planes[u] += quadric_plane(one, weight * dot(x, x) / oo);
            if (tt > 0.0f) b->planes[u] += quadric_plane(two, weight * dot(x, x) / tt);
        }
    }
}

// the block's triangles, their vertices with quadrics, and which of these may go: those all of whose triangles it has
INLINE void block_load(Block *b, __global const uint4 *rows, const uint count, __global const float4 *points,
    __global const float *limits, __global const float8 *held, const float border_weight, const uint keep_border,
    const float crease)
{
    for (b->slot_mask = 63; b->slot_mask < 4 * count - 1;) b->slot_mask = 2 * b->slot_mask + 1;
    for (uint s = 0; s <= b->slot_mask; ++s) b->slots[s] = NONE;
    b->triangles = count;
    b->vertices = b->edge_count = b->queued = b->ranks = b->rank = b->stamp = 0;
    for (uint t = 0; t < count; ++t) {
        const uint4 row = rows[t], ahead = rows[min(t + AHEAD, count - 1)];
        prefetch(points + ahead.x, 1);
        prefetch(points + ahead.y, 1);
        prefetch(points + ahead.z, 1);
        const uint id[3] = {row.x, row.y, row.z};
        uint own[3];
        for (uint k = 0; k < 3; ++k) {
            const uint v = own[k] = block_number(b, id[k], points, limits, held);
            b->corners[4 * t + k] = v;
            b->next[4 * t + k] = b->head[v];
            b->head[v] = 4 * t + k;
            ++b->degree[v];
        }
        b->corners[4 * t + 3] = 1;
        // around a vertex inside the surface every neighbour follows once and goes before once: they cancel out
        for (uint k = 0; k < 3; ++k) b->kind[own[k]] += own[k == 2 ? 0 : k + 1] - own[k == 0 ? 2 : k - 1];
        const float3 p = b->places[own[0]].xyz;
        const float3 n = cross(b->places[own[1]].xyz - p, b->places[own[2]].xyz - p);
        const float square = dot(n, n);
        if (!(square > 0.0f)) continue;
        const float8 plane = quadric_plane(n, 0.5f * rsqrt(square));  // area times the unit normal's square
        const float4 bend = (float4)(n, sqrt(square));
        for (uint k = 0; k < 3; ++k) {
            b->planes[own[k]] += plane;
            b->lines[own[k]] += bend;
        }
    }
    for (uint v = 0; v < b->vertices; ++v) {
        b->given[v] = b->degree[v];
        b->version[v] = b->planes[v].s7 == (float)b->degree[v];
        const bool rim = b->kind[v] != 0;
        b->kind[v] = b->version[v] ? WHOLE : 0;
        // folds are seen in the sum of the normals, so that most vertices need not be looked at edge by edge
        const float4 bend = b->lines[v];
        b->lines[v] = 0.0f;
        const bool bent = crease > FOLD || dot(bend.xyz, bend.xyz) < BENT * bend.w * bend.w;
        if (bent && b->version[v]) block_creases(b, v, border_weight, crease);
        if (rim && b->version[v]) {
            b->kind[v] |= BORDER;
            if (keep_border)
                b->version[v] = 0;
            else
                block_border(b, v, border_weight);
        }
        if (b->version[v]) b->kind[v] |= FREE;
    }
}
