// The number of a combination of edges, and the edges of a number.
//
// Source    reconstruction: an edge whose every vertex has those between which it lies is one of 26
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     bezier/semi_adaptive/reference.py

#define EDGE_KINDS 26
#define PATTERN_COUNT (EDGE_KINDS * EDGE_KINDS * EDGE_KINDS)
#define LIST_WORDS 48 // four corners each

// of the half of an edge about place k, 2 or 6: 0 to 4
static inline uint semi_half(const uint edge, const uint k)
{
    return edge >> k & 1 ? 1 + 2 * (edge >> (k - 1) & 1) + (edge >> (k + 1) & 1) : 0;
}

static inline uint semi_edge_number(const uint edge)
{
    return edge >> 4 & 1 ? 1 + 5 * semi_half(edge, 2) + semi_half(edge, 6) : 0;
}

static inline uint semi_half_edge(const uint number, const uint k)
{
    return number ? 1u << k | (number - 1) / 2 << (k - 1) | ((number - 1) & 1) << (k + 1) : 0;
}

static inline uint semi_edge(const uint number)
{
    return number ? 0x10 | semi_half_edge((number - 1) / 5, 2) | semi_half_edge((number - 1) % 5, 6) : 0;
}
