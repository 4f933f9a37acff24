// Vertices around which the triangles of a mesh are not one fan, open or closed: where it is no surface.
//
// Source    none; the link condition of a combinatorial manifold, vertex by vertex
// Work      1-D, one item per chunk of triangles, or of vertices; corners are chained in any order, which is not seen
// Reads     triangles   uint[3 * triangle_count]   no vertex twice in one
// Writes    heads       uint[vertex_count]         0xFFFFFFFF before; then one of the vertex's corners
//           next        uint[3 * triangle_count]   another corner of the same vertex, 0xFFFFFFFF after the last
//           troubled    uchar[vertex_count]        1: not one fan, or one of two triangles back to back
// Needs     common/chunk.cl
// Plain     cluster/links.py

#define NO_CORNER 0xFFFFFFFFu
#define MOST 48 // triangles at a vertex; those with more are called troubled

__kernel void cluster_links_chain(
    __global const uint *restrict triangles,
    __global uint *restrict heads,
    __global uint *restrict next,
    const uint triangle_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, triangle_count);
    for (uint c = 3 * rows.x; c < 3 * rows.y; ++c) next[c] = atomic_xchg(heads + triangles[c], c);
}

// the one of `wanted` that holds `value`; count where there is none, more than that where there are several
static inline uint links_one(const uint *wanted, const uint count, const uint value)
{
    uint found = count, times = 0;
    for (uint i = 0; i < count; ++i)
        if (wanted[i] == value) {
            found = i;
            ++times;
        }
    return times > 1 ? MOST + 1 : found;
}

__kernel void cluster_links_test(
    __global const uint *restrict triangles,
    __global const uint *restrict heads,
    __global const uint *restrict next,
    __global uchar *restrict troubled,
    const uint vertex_count,
    const uint chunk_count)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunk_count) return;

    const uint2 rows = chunk_rows(chunk, chunk_count, vertex_count);
    for (uint v = rows.x; v < rows.y; ++v) {
        uint from[MOST], to[MOST], count = 0;
        for (uint c = heads[v]; c != NO_CORNER && count <= MOST; c = next[c]) {
            if (count < MOST) {
                const uint k = c % 3, first = c - k;
                from[count] = triangles[first + (k == 2 ? 0 : k + 1)];
                to[count] = triangles[first + (k == 0 ? 2 : k - 1)];
            }
            ++count;
        }
        troubled[v] = count > MOST;
        if (!count || count > MOST) continue;
        uint walked = 1, at = 0;
        while (walked <= count && (at = links_one(from, count, to[at])) != 0 && at < count) ++walked;
        if (at == count) { // an open fan: also the other way from where the walk began
            at = 0;
            while (walked <= count && (at = links_one(to, count, from[at])) < count) ++walked;
            troubled[v] = walked != count || at != count;
        } else {
            troubled[v] = at != 0 || walked != count || count < 3;
        }
    }
}
