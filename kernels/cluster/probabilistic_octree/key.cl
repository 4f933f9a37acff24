// A node's key, its slot in the table, and which corners write to which levels.
//
// Source    DeCoro & Tatarchuk 2007, slides 30-33; the hash is that of MurmurHash3's end, the probabilities are a reconstruction
// Work      functions only
// Reads     nothing
// Writes    nothing
// Needs     cluster/octree/cell.cl
// Plain     cluster/probabilistic_octree/reference.py

#define WORDS 14 // of a slot: xx xy xz yy yz zz, b, c, corner sum, corners; in units of the node's own edge
#define NO_KEY ((int)0x80000000)

static inline uint key_hash(uint x)
{
    x = (x ^ (x >> 16)) * 0x85EBCA6Bu;
    x = (x ^ (x >> 13)) * 0xC2B2AE35u;
    return x ^ (x >> 16);
}

// at least 1; `code` is that of the finest cell
static inline int key_of(const uint code, const uint level, const uint finest)
{
    return (int)(1u + (level << 27 | code >> (3 * (finest - level))));
}

// the root has a slot of its own, which nothing else is hashed to
static inline uint key_slot(const int key, const uint slot_count, const uint seed)
{
    return key == 1 ? 0 : 1 + key_hash((uint)key ^ seed) % (slot_count - 1);
}

// does this corner of all triangles' write to the level so many above the finest? One of 2^up does, whoever asks
static inline bool key_written(const uint corner, const uint up, const uint seed)
{
    return (key_hash(key_hash(corner + seed) + up) & ((1u << up) - 1)) == 0;
}
