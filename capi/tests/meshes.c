// Two meshes in one call: right uses, mistakes, and allocators that run out of memory.

#include "expect.h"

#include <stdlib.h>

// An allocator that counts, and has none left after so many blocks.
typedef struct {
    int blocks_left;
    long blocks, bytes, odd;
} counts_t;

static void *counted(void *context, size_t bytes)
{
    counts_t *counts = context;
    if (counts->blocks_left-- <= 0) {
        return NULL;
    }
    counts->blocks++;
    counts->bytes += (long)bytes;
    char *memory = malloc(bytes + 8);
    return memory ? memory + counts->odd : NULL;
}

static void returned(void *context, void *memory, size_t bytes)
{
    counts_t *counts = context;
    counts->blocks--;
    counts->bytes -= (long)bytes;
    free((char *)memory - counts->odd);
}

#define SIDE 40
static float plane[3 * (SIDE + 1) * (SIDE + 1)];
static uint16_t faces[6 * SIDE * SIDE];

// A square of 2 * SIDE * SIDE triangles in the plane z = 0, with indices of 16 bits.
static pfront_buffers_t square(void)
{
    const pfront_buffers_t buffers = {plane, (SIDE + 1) * (SIDE + 1), 12, faces, 2 * SIDE * SIDE,
                                      PFRONT_INDEX_U16};
    uint16_t *face = faces;
    for (int i = 0; i <= SIDE; i++) {
        for (int j = 0; j <= SIDE; j++) {
            float *at = plane + 3 * (i * (SIDE + 1) + j);
            at[0] = (float)i;
            at[1] = (float)j;
            at[2] = 0;
            if (i < SIDE && j < SIDE) {
                uint16_t p = (uint16_t)(i * (SIDE + 1) + j), q = (uint16_t)(p + SIDE + 1);
                const uint16_t two[6] = {p, q, (uint16_t)(q + 1), p, (uint16_t)(q + 1), (uint16_t)(p + 1)};
                memcpy(face, two, sizeof two);
                face += 6;
            }
        }
    }
    return buffers;
}

static const pfront_buffers_t tetrahedra = {points, VERTICES, 12, corners, TRIANGLES, PFRONT_INDEX_U32};

// What pages of a query find, of the tetrahedra with themselves.
static void same_as_pages(void)
{
    pfront_query_t query;
    pfront_cursor_t cursor;
    pfront_pair_t page[TRIANGLES * TRIANGLES];
    pfront_pair_list_t list;
    size_t count, found = 0;
    make();
    OK(pfront_query_pair(&bvh, &bvh, &still, &query, &error));
    OK(pfront_cursor_start(&query, &cursor, &error));
    OK(pfront_query_page(&query, &cursor, page, TRIANGLES * TRIANGLES, &count, &error));
    OK(pfront_all(&tetrahedra, &tetrahedra, &still, NULL, &list, &error));
    THAT(cursor.done && count > 0 && list.count == count);
    for (size_t i = 0; i < list.count; i++) {
        const pfront_pair_t *pair = &list.pairs[i];
        THAT(i == 0 || pair[-1].a < pair->a || (pair[-1].a == pair->a && pair[-1].b < pair->b));
        for (size_t k = 0; k < count; k++) {
            found += page[k].a == pair->a && page[k].b == pair->b;
        }
    }
    THAT(found == count);
    OK(pfront_pair_list_free(&list, &error));
    EXPECT(PFRONT_NOT_MADE, "list", pfront_pair_list_free(&list, &error));
    EXPECT(PFRONT_NULL, "list", pfront_pair_list_free(NULL, &error));
}

static void apart(void)
{
    const pfront_pose_t far = {{{1, 0, 0, 9}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const pfront_buffers_t none = {NULL, 0, 0, NULL, 0, PFRONT_INDEX_U32};
    pfront_pair_list_t list;
    pfront_pair_t pair = {77, 77};
    uint32_t found = 2;
    OK(pfront_all(&tetrahedra, &tetrahedra, &far, NULL, &list, &error));
    THAT(list.count == 0);
    OK(pfront_pair_list_free(&list, &error));
    OK(pfront_any(&tetrahedra, &tetrahedra, &far, NULL, &pair, &found, &error));
    THAT(found == 0 && pair.a == 77);
    OK(pfront_any(&tetrahedra, &tetrahedra, &still, NULL, &pair, &found, &error));
    THAT(found == 1 && pair.a < TRIANGLES && pair.b < TRIANGLES);
    OK(pfront_all(&none, &tetrahedra, &still, NULL, &list, &error));
    THAT(list.count == 0);
    OK(pfront_pair_list_free(&list, &error));
}

// A list that grows several times; and the same where memory runs out, with nothing lost whenever that is.
static void memory_runs_out(void)
{
    const pfront_buffers_t buffers = square();
    counts_t counts = {1000, 0, 0, 0};
    const pfront_allocator_t allocator = {counted, returned, &counts};
    pfront_pair_list_t list;
    pfront_pair_t pair;
    uint32_t found;
    OK(pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
    // Each triangle touches those at its corners, and itself: 13 in all where it is not at the edge.
    THAT(list.count > 20 * SIDE * SIDE && list.count < 26 * SIDE * SIDE);
    THAT(counts.blocks == 1 && counts.bytes == (long)(list.capacity * sizeof(pfront_pair_t)));
    size_t count = list.count;
    OK(pfront_pair_list_free(&list, &error));
    THAT(counts.blocks == 0 && counts.bytes == 0);
    int asked = 1000 - counts.blocks_left;
    THAT(asked > 4);
    for (int left = 0; left < asked; left++) {
        counts.blocks_left = left;
        EXPECT(PFRONT_OUT_OF_MEMORY, "allocator",
               pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
        THAT(error.needed > 0 && counts.blocks == 0 && counts.bytes == 0);
    }
    counts.blocks_left = asked;
    OK(pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
    THAT(list.count == count);
    OK(pfront_pair_list_free(&list, &error));
    counts.blocks_left = 0;
    EXPECT(PFRONT_OUT_OF_MEMORY, "allocator",
           pfront_any(&buffers, &buffers, &still, &allocator, &pair, &found, &error));
    counts.blocks_left = 1000;
    OK(pfront_any(&buffers, &buffers, &still, &allocator, &pair, &found, &error));
    THAT(found == 1 && counts.blocks == 0);
    counts.odd = 4;
    EXPECT(PFRONT_MISALIGNED, "allocate",
           pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
    THAT(counts.blocks == 0 && counts.bytes == 0);
}

static void mistakes(void)
{
    pfront_buffers_t buffers = tetrahedra;
    pfront_allocator_t allocator = {NULL, returned, NULL};
    pfront_pose_t pose = still;
    pfront_pair_list_t list;
    pfront_pair_t pair;
    uint32_t found;
    memset(&list, 0, sizeof list);
    EXPECT(PFRONT_NOT_MADE, "list", pfront_pair_list_free(&list, &error));
    EXPECT(PFRONT_NULL, "a", pfront_all(NULL, &buffers, &still, NULL, &list, &error));
    EXPECT(PFRONT_NULL, "b", pfront_all(&buffers, NULL, &still, NULL, &list, &error));
    EXPECT(PFRONT_NULL, "a_from_b", pfront_all(&buffers, &buffers, NULL, NULL, &list, &error));
    EXPECT(PFRONT_NULL, "list", pfront_all(&buffers, &buffers, &still, NULL, NULL, &error));
    EXPECT(PFRONT_NULL, "found", pfront_any(&buffers, &buffers, &still, NULL, &pair, NULL, &error));
    EXPECT(PFRONT_NULL, "allocate", pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
    allocator.allocate = counted;
    allocator.release = NULL;
    EXPECT(PFRONT_NULL, "release", pfront_all(&buffers, &buffers, &still, &allocator, &list, &error));
    pose.rows[2][0] = INFINITY;
    EXPECT(PFRONT_POSE_NOT_FINITE, "a_from_b",
           pfront_all(&buffers, &buffers, &pose, NULL, &list, &error));
    THAT(error.index == 8);
    buffers.stride = 8;
    EXPECT(PFRONT_TOO_SMALL, "a.stride", pfront_all(&buffers, &tetrahedra, &still, NULL, &list, &error));
    buffers = tetrahedra;
    buffers.index_type = 9;
    EXPECT(PFRONT_OUT_OF_RANGE, "b.index_type",
           pfront_all(&tetrahedra, &buffers, &still, NULL, &list, &error));
    buffers = tetrahedra;
    buffers.positions = NULL;
    EXPECT(PFRONT_NULL, "a.positions", pfront_all(&buffers, &tetrahedra, &still, NULL, &list, &error));
    buffers = tetrahedra;
    buffers.triangles = NULL;
    EXPECT(PFRONT_NULL, "b.triangles", pfront_all(&tetrahedra, &buffers, &still, NULL, &list, &error));
    buffers = tetrahedra;
    buffers.vertex_count = 7;
    EXPECT(PFRONT_NO_SUCH_VERTEX, "b.triangles",
           pfront_any(&tetrahedra, &buffers, &still, NULL, &pair, &found, &error));
    THAT(error.index == 5 && error.given == 7 && error.needed == 7);
    buffers = tetrahedra;
    buffers.triangle_count = SIZE_MAX / 64;
    EXPECT(PFRONT_TOO_MANY_TRIANGLES, "a.triangles",
           pfront_all(&buffers, &tetrahedra, &still, NULL, &list, &error));
    points[4] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "a.positions",
           pfront_all(&tetrahedra, &tetrahedra, &still, NULL, &list, &error));
    THAT(error.index == 1);
    points[4] = 0;
}

int main(void)
{
    same_as_pages();
    apart();
    memory_runs_out();
    mistakes();
    return verdict();
}
