// What a C program can do wrong with a blob, or what can befall it, and the error code that it gets for it.

#include "expect.h"

// Writes a word of a blob, which is little-endian.
static void put(unsigned char *blob, size_t at, uint32_t word)
{
    for (int i = 0; i < 4; i++) {
        blob[at + i] = (unsigned char)(word >> 8 * i);
    }
}

// Sets the checksum right: that of zlib, over all but itself.
static void seal(unsigned char *blob, size_t bytes)
{
    uint32_t checksum = UINT32_MAX;
    for (size_t i = 0; i < bytes; i++) {
        if (i >= 12 && i < 16) {
            continue;
        }
        checksum ^= blob[i];
        for (int bit = 0; bit < 8; bit++) {
            checksum = checksum >> 1 ^ (checksum & 1 ? 0xedb88320u : 0);
        }
    }
    put(blob, 12, ~checksum);
}

static uint32_t room[512], wrong_room[512];
static unsigned char *const blob = (unsigned char *)room, *const bad = (unsigned char *)wrong_room;
static size_t blob_bytes;

// Borrows a copy of the blob with one word changed, and the checksum set right if so wished.
static pfront_status_t borrow(size_t at, uint32_t word, int sealed)
{
    pfront_bvh_t none;
    memcpy(bad, blob, blob_bytes);
    put(bad, at, word);
    if (sealed) {
        seal(bad, blob_bytes);
    }
    return pfront_bvh_from_blob(bad, blob_bytes, scratch, 7, &none, &error);
}

static void round_trip(void)
{
    pfront_bvh_t borrowed;
    pfront_query_t query;
    uint64_t expected, found;
    size_t bytes, needed;
    EXPECT(PFRONT_NULL, "blob_bytes", pfront_blob_size(&bvh, NULL, &error));
    OK(pfront_blob_size(&bvh, &blob_bytes, &error));
    THAT(blob_bytes == 64 + 32 * bvh.node_count + 12 * VERTICES + 16 * TRIANGLES);
    EXPECT(PFRONT_TOO_SMALL, "blob", pfront_blob_write(&bvh, blob, blob_bytes - 1, &error));
    THAT(error.needed == blob_bytes && error.given == blob_bytes - 1);
    EXPECT(PFRONT_OVERLAP, "nodes", pfront_blob_write(&bvh, nodes, sizeof nodes, &error));
    OK(pfront_blob_write(&bvh, blob, sizeof room, &error));
    OK(pfront_blob_scratch_bytes(blob, sizeof room, &needed, &error));
    THAT(needed == pfront_adopt_scratch_bytes(TRIANGLES));
    EXPECT(PFRONT_TOO_SMALL, "scratch",
           pfront_bvh_from_blob(blob, sizeof room, scratch, needed - 1, &borrowed, &error));
    EXPECT(PFRONT_OVERLAP, "blob",
           pfront_bvh_from_blob(blob, sizeof room, blob + 64, needed, &borrowed, &error));
    OK(pfront_bvh_from_blob(blob, sizeof room, scratch, needed, &borrowed, &error));
    THAT(memcmp(borrowed.nodes, nodes, borrowed.node_count * sizeof *nodes) == 0);
    THAT(borrowed.mesh.positions == (const float *)(room + 16 + 8 * bvh.node_count));
    OK(pfront_blob_size(&borrowed, &bytes, &error));
    THAT(bytes == blob_bytes);
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, &query, &error));
    OK(pfront_query_count(&query, &expected, &error));
    OK(pfront_query_self(&borrowed, NULL, PFRONT_SHARED_INDEX, &query, &error));
    OK(pfront_query_count(&query, &found, &error));
    THAT(found == expected && found > 0);
    EXPECT(PFRONT_READ_ONLY, "bvh", pfront_bvh_refit(&borrowed, points, VERTICES, NULL, &error));

    // What it says that the caller can do: nodes of one's own.
    pfront_node_t own[2 * TRIANGLES];
    const pfront_bvh_memory_t copy = {own, borrowed.node_count, (uint32_t *)borrowed.order, TRIANGLES,
                                      scratch, needed};
    memcpy(own, borrowed.nodes, borrowed.node_count * sizeof *own);
    OK(pfront_bvh_adopt(&borrowed.mesh, &copy, &borrowed, &error));
    OK(pfront_bvh_refit(&borrowed, points, VERTICES, NULL, &error));
}

static void empty(void)
{
    const pfront_bvh_memory_t memory = {NULL, 0, NULL, 0, scratch, sizeof scratch};
    pfront_mesh_t none;
    pfront_bvh_t built, borrowed;
    pfront_query_t query;
    uint64_t count;
    OK(pfront_mesh_check(NULL, 0, NULL, 0, &none, &error));
    OK(pfront_bvh_build_sah(&none, 0, &memory, &built, &error));
    OK(pfront_blob_write(&built, bad, 64, &error));
    OK(pfront_bvh_from_blob(bad, 64, scratch, 7, &borrowed, &error));
    OK(pfront_query_self(&borrowed, NULL, PFRONT_SHARED_INDEX, &query, &error));
    OK(pfront_query_count(&query, &count, &error));
    THAT(borrowed.node_count == 0 && count == 0);
}

static void mistakes(void)
{
    pfront_bvh_t none;
    size_t needed;
    EXPECT(PFRONT_BLOB_LENGTH, "blob",
           pfront_bvh_from_blob(blob, blob_bytes - 1, scratch, 7, &none, &error));
    THAT(error.needed == blob_bytes && error.given == blob_bytes - 1);
    EXPECT(PFRONT_BLOB_LENGTH, "blob", pfront_bvh_from_blob(blob, 63, scratch, 7, &none, &error));
    EXPECT(PFRONT_BLOB_LENGTH, "blob", pfront_bvh_from_blob(NULL, 0, scratch, 7, &none, &error));
    EXPECT(PFRONT_BLOB_LENGTH, "blob", pfront_blob_scratch_bytes(blob, 63, &needed, &error));
    EXPECT(PFRONT_NULL, "blob", pfront_bvh_from_blob(NULL, 64, scratch, 7, &none, &error));
    memcpy(bad + 1, blob, blob_bytes);
    EXPECT(PFRONT_MISALIGNED, "blob",
           pfront_bvh_from_blob(bad + 1, blob_bytes, scratch, 7, &none, &error));
    THAT(error.needed == 4);
    EXPECT(PFRONT_BLOB_MAGIC, "blob", borrow(0, 0, 0));
    EXPECT(PFRONT_BLOB_MAGIC, "blob", pfront_blob_scratch_bytes(bad, blob_bytes, &needed, &error));
    EXPECT(PFRONT_BLOB_VERSION, "blob", borrow(8, 2, 0));
    THAT(error.needed == 1 && error.given == 2);
    EXPECT(PFRONT_BLOB_BYTE, "blob", borrow(24, 0x70001, 0));
    THAT(error.index == 26);
    EXPECT(PFRONT_BLOB_LENGTH, "blob", borrow(32, 1, 1));
    EXPECT(PFRONT_BLOB_LENGTH, "blob", borrow(36, UINT32_MAX, 1));
    EXPECT(PFRONT_BLOB_BYTE, "blob", borrow(44, 1, 0));
    THAT(error.index == 44);
    // One bit anywhere.
    for (size_t at = 64; at < blob_bytes; at += 13) {
        memcpy(bad, blob, blob_bytes);
        bad[at] ^= 1;
        EXPECT(PFRONT_BLOB_CHECKSUM, "blob",
               pfront_bvh_from_blob(bad, blob_bytes, scratch, 7, &none, &error));
    }
    // What a right checksum does not tell.
    size_t positions = 64 + 32 * bvh.node_count, triangles = positions + 12 * VERTICES;
    EXPECT(PFRONT_BVH_NODE, "nodes", borrow(64 + 12, 99, 1));
    EXPECT(PFRONT_BVH_BOX, "nodes", borrow(64, 0x7f800000, 1));
    EXPECT(PFRONT_NOT_FINITE, "positions", borrow(positions, 0x7fc00000, 1));
    EXPECT(PFRONT_NO_SUCH_VERTEX, "triangles", borrow(triangles, VERTICES, 1));
    EXPECT(PFRONT_BVH_ORDER, "order", borrow(triangles + 12 * TRIANGLES, TRIANGLES, 1));
}

int main(void)
{
    make();
    round_trip();
    empty();
    mistakes();
    return verdict();
}
