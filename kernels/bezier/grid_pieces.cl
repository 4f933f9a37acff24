// The test "mean", then: edges have what the cells on both sides wish for; nodes of both pieces, vertices and triangles.
//
// Source    none in Concheiro 2013: a reconstruction; strips and emission as there
// Work      1-D, one item per cell
// Reads     controls         float[64 * patches]    as bezier/patch.cl has it
//           sources          uint [8 * patches]     as bezier/cell.cl has it
//           wishes           uint [cell_count]      as bezier/grids.py has them
//           ring             uint [4 * cell_count]  for each edge of each cell, 4 cell + edge, the next that is one with it;
//                                                   before that, as the lowest bit, whether its own is turned
//           rises, corner_ring, held                as bezier/rises.cl has them
//           vertex_offsets   uint [cell_count]      where a cell's vertices begin
//           triangle_offsets uint [cell_count]      where its triangles do
//           vertex_total, triangle_total  uint [1]
// Writes    masks            ulong[2 * cell_count]  nodes of each coarse triangle or half, bits as bezier/cell.cl and
//                                                   bezier/half_strips.cl have them
//           vertex_counts    uint [cell_count]
//           triangle_counts  uint [cell_count]
//           positions        float[3 * vertex_room]    packed
//           normals          float[3 * vertex_room]    packed, unit length; nothing where NORMALS is 0
//           triangles        uint [3 * triangle_room]
//           counts           uint [2]  live vertices and triangles: none where the room does not suffice
// Needs     bezier/half_strips.cl, bezier/emission.cl, bezier/rises.cl
// Plain     bezier/grids.py
// Defines   NORMALS (1: normals too), STREAMING (common/output.cl, 1)

#define TRIANGLE_EDGES 0x1ff81830c66ful // nodes on the edges of a coarse triangle
#define HALF_EDGES 0x1ff80c0603fful     // and of a half

// nine places in the other order
static inline uint pieces_turned(const uint places)
{
    uint found = 0;
    for (uint k = 0; k < CELL_SIDE; ++k) found |= (places >> k & 1) << (CELL - k);
    return found;
}

static inline uint pieces_columns(const uint wish, const uint k) { return wish >> (4 + 5 * k) & 3; }

static inline uint pieces_rows(const uint wish, const uint k) { return wish >> (2 + 5 * k) & 3; }

// of five rows of a half those that it has
static inline uint pieces_five(const uint rows) { return 0x11 | (rows > 0 ? 0x4 : 0) | (rows > 1 ? 0xa : 0); }

// what a cell wishes for on one of its edges
static inline uint pieces_wished(const uint wish, const uint edge)
{
    const uint cut = wish & 3;
    if (cut == 0) return 0x101;
    if ((cut == 1) == (edge < 2)) return half_on(pieces_columns(wish, edge & 1));
    return pieces_five(pieces_rows(wish, 0)) | pieces_five(pieces_rows(wish, 1)) << 4;
}

// what all cells on this edge wish for there
static inline uint pieces_edge(__global const uint *restrict wishes, __global const uint *restrict ring, const uint edge)
{
    uint places = 0, at = edge;
    do {
        const uint own = pieces_wished(wishes[at / 4], at & 3), next = ring[at];
        places |= next & 1 ? pieces_turned(own) : own, at = next >> 1;
    } while (at != edge);
    return ring[edge] & 1 ? pieces_turned(places) : places;
}

// half k of a cell, by what is on its outer edge and its sides
static inline ulong pieces_half(const uint wish, const uint k, const uint outer, const uint left, const uint right)
{
    const uint middle = half_on(max(pieces_columns(wish, 0), pieces_columns(wish, 1)));
    const uint columns = pieces_columns(wish, k), inside = half_on(columns) & 0xfe, rows = pieces_five(pieces_rows(wish, k));
    ulong mask = (ulong)(k ? middle : outer) | (ulong)(k ? outer : middle) << CELL_SIDE * (HALF_ROWS - 1);
    for (uint r = 1; r < HALF_ROWS - 1; ++r) {
        const uint at = 4 * k + r, row = (rows >> r & 1 ? inside : 0) | (left >> at & 1) | (right >> at & 1) << CELL;
        mask |= (ulong)row << CELL_SIDE * r;
    }
    const uint other = (wish >> (6 + 5 * k) & 1) ^ ((wish & 3) == 2); // rows of the second cut are turned by a quarter
    return mask | (ulong)columns << COLUMNS_BIT | (ulong)other << OTHER_CUT | (ulong)(FIRST_HALF + 2 * ((wish & 3) - 1) + k) << 60;
}

__kernel void bezier_grid_pieces_test(
    __global const uint *restrict wishes,
    __global const uint *restrict ring,
    __global ulong *restrict masks,
    __global uint *restrict vertex_counts,
    __global uint *restrict triangle_counts,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    const uint wish = wishes[number], cut = wish & 3, other = wish >> 6 & 1;
    uint edge[4];
    for (uint k = 0; k < 4; ++k) edge[k] = pieces_edge(wishes, ring, 4 * number + k);
    const uint last = pieces_turned(edge[3]); // from c to d
    uint vertices = 0, faces = 0;
    for (uint k = 0; k < 2; ++k) {
        ulong mask;
        if (cut) {
            const bool down = cut == 1;
            mask = pieces_half(
                wish, k, down ? edge[k] : pieces_turned(edge[2 + k]), edge[down ? 2 : 1], edge[down ? 3 : 0]);
        } else {
            const uint a = k ? other ? edge[1] : 0 : edge[2], b = other ? k ? 0 : edge[0] : k ? edge[0] : 0;
            mask = bezier_edge_mask(a, b, k ? last : other ? 0 : edge[1]) | (ulong)(3 * k + 6 * other) << 60;
        }
        masks[2 * number + k] = mask;
        const uint count = (uint)popcount(bezier_nodes(mask));
        vertices += count;
        faces += bezier_faces(count, mask, cut ? HALF_EDGES : TRIANGLE_EDGES);
    }
    vertex_counts[number] = vertices;
    triangle_counts[number] = faces;
}

__kernel void bezier_grid_pieces_emit(
    __global const float *restrict controls,
    __global const uint *restrict sources,
    __global const ulong *restrict masks,
    __global const uint *restrict wishes,
    __global const int *restrict rises,
    __global const uint *restrict ring,
    __global const uint *restrict corner_ring,
    __global const uint *restrict held,
    __global const uint *restrict vertex_offsets,
    __global const uint *restrict triangle_offsets,
    __global const uint *restrict vertex_total,
    __global const uint *restrict triangle_total,
    __global float *restrict positions,
    __global float *restrict normals,
    __global uint *restrict triangles,
    __global uint *restrict counts,
    const float diagonal, // 0: vertices stay on the surface
    const uint side,
    const uint vertex_room,
    const uint triangle_room,
    const uint cell_count)
{
    const uint number = get_global_id(0);
    if (number >= cell_count) return;

    if (!bezier_fits(counts, vertex_total[0], triangle_total[0], vertex_room, triangle_room, number)) return;

    const ulong2 both = vload2(number, masks);
    uint first = vertex_offsets[number];
    uchar samples[CELL_VERTICES];
    const uint vertices = bezier_samples(samples, both);
    bezier_emit_at(positions, normals, controls, sources, number, samples, vertices, first, side);
#if NORMALS
    if (diagonal > 0.0f) {
        float table[RISE_PLACES * RISE_PLACES];
        bezier_rises(table, wishes, rises, ring, corner_ring, held[number], number, diagonal);
        for (uint k = 0; k < vertices; ++k) {
            const float3 normal = vload3(first + k, normals);
            vstore3(vload3(first + k, positions) + normal * table[bezier_rise_place(samples[k])], first + k, positions);
        }
    }
#endif
    __global uint *to = triangles + 3 * (size_t)triangle_offsets[number];
    for (uint t = 0; t < 2; ++t) {
        const ulong mask = t ? both.y : both.x, nodes = bezier_nodes(mask);
        uchar list[3 * STRIP_TRIANGLES];
        const uint count = bezier_way(mask) >= FIRST_HALF ? half_strips(list, mask) : bezier_strips(list, nodes);
        to = bezier_put_triangles(to, list, count, first);
        first += (uint)popcount(nodes);
    }
}
