// The plane of a border edge: through it, and upright on its triangle.
//
// Source    Lindstrom & Turk 1998 (boundary optimisation)
// Work      functions only
// Reads     nothing
// Writes    nothing
// Plain     cluster/quadric_clustering/reference.py

typedef struct {
    float3 m, w; // normal; the same by its weight: w m^T is the quadric's matrix
    float d; // d w is its vector
} border_plane;

// of the edge from a to b, by `heaviness` times the square of its length; none where the triangle has no area
static inline border_plane border_plane_of(const float3 a, const float3 b, const float3 c, const float heaviness)
{
    const float3 along = b - a, side = c - a;
    const float length2 = along.x * along.x + along.y * along.y + along.z * along.z;
    const float dot = side.x * along.x + side.y * along.y + side.z * along.z;
    // of the third corner's way what is square to the edge
    const float3 m = side - along * (dot / max(length2, 1e-30f));
    const float square = m.x * m.x + m.y * m.y + m.z * m.z;
    const bool flat = !(length2 > 1e-30f && square > 1e-12f * length2);
    const border_plane plane = {
        m, flat ? (float3)(0.0f) : m * (heaviness * length2 / square), -(m.x * a.x + m.y * a.y + m.z * a.z)};
    return plane;
}
