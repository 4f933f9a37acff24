// The number of a combination of edges, and the edges of a number.
//
// Source    reconstruction: an edge whose every vertex has those between which it lies is one of 1 + HALVES^2
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     bezier/semi_adaptive/reference.py
// Defines   HALVES  kinds of the half of an edge: 0, 1, 2 or 5, for coarse triangles of level 0 to 3

#define EDGE_KINDS (1 + HALVES * HALVES)
#define PATTERN_COUNT (EDGE_KINDS * EDGE_KINDS * EDGE_KINDS)
#define LIST_WORDS 48 // four corners each

// of the half of an edge about place k, 2 or 6: 0 to 4
static inline uint semi_half(const uint edge, const uint k)
{
    return edge >> k & 1 ? 1 + 2 * (edge >> (k - 1) & 1) + (edge >> (k + 1) & 1) : 0;
}

static inline uint semi_edge_number(const uint edge)
{
    return edge >> 4 & 1 ? 1 + HALVES * semi_half(edge, 2) + semi_half(edge, 6) : 0;
}

static inline uint semi_half_edge(const uint number, const uint k)
{
    return number ? 1u << k | (number - 1) / 2 << (k - 1) | ((number - 1) & 1) << (k + 1) : 0;
}

static inline uint semi_edge(const uint number)
{
    const uint halves = max((uint)HALVES, 1u);
    return number ? 0x10 | semi_half_edge((number - 1) / halves, 2) | semi_half_edge((number - 1) % halves, 6) : 0;
}
