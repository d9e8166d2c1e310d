// What a C program can do wrong, and the error code that it gets for it.

#include "pfront.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int wrong = 0;

// Whether a call returns a code, and names the parameter at fault.
static void expect(int line, pfront_status_t status, pfront_status_t expected, const char *what,
                   const pfront_error_t *error)
{
    const char *named = error->what ? error->what : "";
    if (status != expected || error->status != expected || strcmp(named, what) != 0) {
        fprintf(stderr, "line %d: %s: %s; and not %s: %s\n", line, named, pfront_error_text(status),
                what, pfront_error_text(expected));
        wrong = 1;
    }
}

static void expect_that(int line, int holds)
{
    if (!holds) {
        fprintf(stderr, "line %d: not so\n", line);
        wrong = 1;
    }
}

#define THAT(condition) expect_that(__LINE__, condition)
#define EXPECT(code, named, ...) expect(__LINE__, __VA_ARGS__, code, named, &error)
#define OK(...) expect(__LINE__, __VA_ARGS__, PFRONT_OK, "", &error)

// Two tetrahedra, one with a corner inside the other.
#define VERTICES 8
#define TRIANGLES 8
static float points[3 * VERTICES] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,
                                     .1f, .1f, .1f, 2, 0, 0.5f, 0, 2, 0.5f, .5f, .5f, 2};
static uint32_t corners[3 * TRIANGLES] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3,
                                          4, 6, 5, 4, 5, 7, 4, 7, 6, 5, 6, 7};

static pfront_error_t error;
static pfront_mesh_t mesh;
static pfront_node_t nodes[2 * TRIANGLES];
static uint32_t order[TRIANGLES];
static unsigned char scratch[1024];
static pfront_bvh_t bvh;
static const pfront_pose_t still = PFRONT_POSE_IDENTITY;

static void meshes(void)
{
    pfront_mesh_t none;
    const float *odd = (const float *)(const void *)((const char *)points + 1);
    EXPECT(PFRONT_NULL, "positions", pfront_mesh_check(NULL, 8, corners, 8, &none, &error));
    EXPECT(PFRONT_NULL, "triangles", pfront_mesh_check(points, 8, NULL, 8, &none, &error));
    EXPECT(PFRONT_NULL, "mesh", pfront_mesh_check(points, 8, corners, 8, NULL, &error));
    EXPECT(PFRONT_MISALIGNED, "positions", pfront_mesh_check(odd, 7, corners, 8, &none, &error));
    THAT(error.needed == 4);
    EXPECT(PFRONT_TOO_LONG, "positions",
           pfront_mesh_check(points, SIZE_MAX / 2, corners, 8, &none, &error));
    EXPECT(PFRONT_TOO_LONG, "triangles",
           pfront_mesh_check(points, 8, corners, SIZE_MAX, &none, &error));
    EXPECT(PFRONT_NO_SUCH_VERTEX, "triangles", pfront_mesh_check(points, 7, corners, 8, &none, &error));
    THAT(error.index == 5 && error.given == 7 && error.needed == 7);
    points[10] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions", pfront_mesh_check(points, 8, corners, 8, &none, &error));
    THAT(error.index == 3);
    points[10] = INFINITY;
    THAT(pfront_mesh_check(points, 8, corners, 8, &none, NULL) == PFRONT_NOT_FINITE);
    points[10] = 0;
    THAT(pfront_mesh_check(points, 8, corners, 8, &none,
                           (pfront_error_t *)(void *)((char *)&error + 1)) == PFRONT_MISALIGNED);
    OK(pfront_mesh_check(NULL, 0, NULL, 0, &none, &error));
    OK(pfront_mesh_check(points, 8, corners, 8, &mesh, &error));
}

static void builds(void)
{
    const pfront_bvh_memory_t good = {nodes, 2 * TRIANGLES, order, TRIANGLES, scratch, sizeof scratch};
    pfront_bvh_memory_t memory = good;
    pfront_mesh_t zero;
    memset(&zero, 0, sizeof zero);
    EXPECT(PFRONT_NOT_MADE, "mesh", pfront_bvh_build_sah(&zero, 0, &memory, &bvh, &error));
    EXPECT(PFRONT_NULL, "mesh", pfront_bvh_build_sah(NULL, 0, &memory, &bvh, &error));
    EXPECT(PFRONT_NULL, "memory", pfront_bvh_build_sah(&mesh, 0, NULL, &bvh, &error));
    EXPECT(PFRONT_NULL, "bvh", pfront_bvh_build_morton(&mesh, 0, &memory, NULL, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "leaf_size", pfront_bvh_build_morton(&mesh, 9, &memory, &bvh, &error));
    THAT(error.needed == 9 && error.given == 9);
    memory.nodes = NULL;
    EXPECT(PFRONT_NULL, "nodes", pfront_bvh_build_sah(&mesh, 0, &memory, &bvh, &error));
    memory = good;
    memory.node_capacity = pfront_node_bound(TRIANGLES) - 1;
    EXPECT(PFRONT_TOO_SMALL, "nodes", pfront_bvh_build_sah(&mesh, 0, &memory, &bvh, &error));
    THAT(error.needed == 2 * TRIANGLES && error.given == 2 * TRIANGLES - 1);
    memory.node_capacity = 1;
    EXPECT(PFRONT_TOO_SMALL, "nodes", pfront_bvh_build_morton(&mesh, 1, &memory, &bvh, &error));
    THAT(error.needed == 2 * TRIANGLES);
    memory = good;
    memory.order_capacity = TRIANGLES - 1;
    EXPECT(PFRONT_TOO_SMALL, "order", pfront_bvh_build_sah(&mesh, 0, &memory, &bvh, &error));
    memory = good;
    memory.scratch_bytes = pfront_sah_scratch_bytes(TRIANGLES) - 1;
    EXPECT(PFRONT_TOO_SMALL, "scratch", pfront_bvh_build_sah(&mesh, 0, &memory, &bvh, &error));
    memory.scratch_bytes = pfront_morton_scratch_bytes(TRIANGLES) - 1;
    EXPECT(PFRONT_TOO_SMALL, "scratch", pfront_bvh_build_morton(&mesh, 0, &memory, &bvh, &error));
    memory = good;
    memory.scratch = nodes;
    memory.scratch_bytes = sizeof nodes;
    EXPECT(PFRONT_OVERLAP, "scratch", pfront_bvh_build_sah(&mesh, 0, &memory, &bvh, &error));
    memory.scratch = points;
    memory.scratch_bytes = pfront_morton_scratch_bytes(1);
    memory.node_capacity = 2;
    mesh.triangle_count = 1;
    EXPECT(PFRONT_OVERLAP, "positions", pfront_bvh_build_morton(&mesh, 0, &memory, &bvh, &error));
    mesh.triangle_count = TRIANGLES;
    THAT(pfront_node_bound(SIZE_MAX) == SIZE_MAX && pfront_sah_scratch_bytes(SIZE_MAX) == SIZE_MAX);
    THAT(pfront_fans_scratch_bytes(SIZE_MAX, 1) == SIZE_MAX);
    memory = good;
    // Of any alignment.
    memory.scratch = scratch + 1;
    memory.scratch_bytes = pfront_sah_scratch_bytes(TRIANGLES);
    OK(pfront_bvh_build_sah(&mesh, 1, &memory, &bvh, &error));
}

static void adoptions(void)
{
    pfront_node_t copy[2 * TRIANGLES];
    uint32_t own[TRIANGLES];
    pfront_bvh_t adopted;
    pfront_bvh_memory_t memory = {copy, bvh.node_count, own, TRIANGLES, scratch, sizeof scratch};
    memcpy(copy, nodes, sizeof nodes);
    memcpy(own, order, sizeof order);
    OK(pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    memory.scratch_bytes = 7;
    OK(pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    memory.scratch_bytes = 6;
    EXPECT(PFRONT_TOO_SMALL, "scratch", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    memory.scratch_bytes = sizeof scratch;
    memory.order_capacity--;
    EXPECT(PFRONT_BVH_ORDER, "order", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    memory.order_capacity++;
    own[3] = own[4];
    EXPECT(PFRONT_BVH_ORDER, "order", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    THAT(error.index == 4);
    own[3] = order[3];
    memory.node_capacity--;
    EXPECT(PFRONT_BVH_NODE, "nodes", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    memory.node_capacity++;
    copy[0].first = 0;
    EXPECT(PFRONT_BVH_NODE, "nodes", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    copy[0].first = 2;
    copy[0].max[0] = 0;
    EXPECT(PFRONT_BVH_BOX, "nodes", pfront_bvh_adopt(&mesh, &memory, &adopted, &error));
    THAT(error.index == 0);
}

static void refits(void)
{
    float moved[3 * VERTICES], quality;
    pfront_bvh_t zero;
    pfront_aabb_t bounds;
    memset(&zero, 0, sizeof zero);
    memcpy(moved, points, sizeof points);
    EXPECT(PFRONT_NOT_MADE, "bvh", pfront_bvh_refit(&zero, moved, VERTICES, NULL, &error));
    EXPECT(PFRONT_VERTEX_COUNT, "positions", pfront_bvh_refit(&bvh, moved, 7, &quality, &error));
    THAT(error.needed == VERTICES && error.given == 7);
    EXPECT(PFRONT_NULL, "positions", pfront_bvh_refit(&bvh, NULL, VERTICES, NULL, &error));
    moved[0] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions", pfront_bvh_refit(&bvh, moved, VERTICES, NULL, &error));
    THAT(bvh.mesh.positions == points);
    OK(pfront_bvh_refit(&bvh, points, VERTICES, &quality, &error));
    THAT(quality > 0);
    EXPECT(PFRONT_NULL, "quality", pfront_bvh_quality(&bvh, NULL, &error));
    EXPECT(PFRONT_NULL, "world_from_bvh", pfront_bvh_bounds(&bvh, NULL, &bounds, &error));
    OK(pfront_bvh_bounds(&bvh, &still, &bounds, &error));
    THAT(bounds.max[2] == 2);
}

static void fans(void)
{
    pfront_fan_t known[VERTICES];
    size_t bytes = pfront_fans_scratch_bytes(VERTICES, TRIANGLES);
    EXPECT(PFRONT_TOO_SMALL, "fans", pfront_fans_link(&mesh, known, 7, scratch, bytes, &error));
    EXPECT(PFRONT_TOO_SMALL, "scratch", pfront_fans_link(&mesh, known, 8, scratch, bytes - 1, &error));
    OK(pfront_fans_link(&mesh, known, VERTICES, scratch, bytes, &error));
    EXPECT(PFRONT_TOO_SMALL, "fans", pfront_fans_certify(&mesh, known, 7, &error));
    OK(pfront_fans_certify(&mesh, known, VERTICES, &error));
}

static void queries(void)
{
    pfront_query_t query, zero;
    pfront_pose_t pose = still;
    uint64_t many;
    memset(&zero, 0, sizeof zero);
    EXPECT(PFRONT_NULL, "b", pfront_query_pair(&bvh, NULL, &still, PFRONT_EXACT, &query, &error));
    EXPECT(PFRONT_NULL, "frame_from_b", pfront_query_pair(&bvh, &bvh, NULL, 0, &query, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "accuracy", pfront_query_pair(&bvh, &bvh, &still, 3, &query, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_query_self(&bvh, NULL, 3, 0, &query, &error));
    pose.rows[1][2] = NAN;
    EXPECT(PFRONT_POSE_NOT_FINITE, "frame_from_b",
           pfront_query_pair(&bvh, &bvh, &pose, PFRONT_EXACT, &query, &error));
    THAT(error.index == 6);
    pose.rows[1][2] = 1e38f;
    EXPECT(PFRONT_POSE_RANGE, "frame_from_a",
           pfront_query_world(&bvh, &pose, &bvh, &still, PFRONT_EXACT, &query, &error));
    THAT(error.index == 1);
    EXPECT(PFRONT_NOT_MADE, "query", pfront_query_count(&zero, &many, &error));
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, PFRONT_EXACT, &query, &error));
    query.accuracy = 77;
    EXPECT(PFRONT_OUT_OF_RANGE, "accuracy", pfront_query_count(&query, &many, &error));
    query.accuracy = PFRONT_EXACT;
    EXPECT(PFRONT_NULL, "count", pfront_query_count(&query, NULL, &error));
    OK(pfront_query_count(&query, &many, &error));
    THAT(many > 0);
}

static void walks(void)
{
    pfront_query_t query, other;
    pfront_cursor_t cursor;
    pfront_pair_t page[4], pair = {0, TRIANGLES};
    pfront_contact_t contact;
    pfront_mesh_t half;
    pfront_bvh_t small;
    pfront_node_t few[2 * TRIANGLES];
    uint32_t own[TRIANGLES], found;
    size_t count;
    const pfront_bvh_memory_t memory = {few, 2 * TRIANGLES, own, TRIANGLES, scratch, sizeof scratch};
    const pfront_node_pair_t none = {99, 0};
    memset(&cursor, 0, sizeof cursor);
    OK(pfront_mesh_check(points, 4, corners, 4, &half, &error));
    OK(pfront_bvh_build_morton(&half, 1, &memory, &small, &error));
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, PFRONT_EXACT, &query, &error));
    OK(pfront_query_pair(&small, &bvh, &still, PFRONT_EXACT, &other, &error));
    EXPECT(PFRONT_NOT_MADE, "cursor", pfront_query_page(&query, &cursor, page, 4, &count, &error));
    EXPECT(PFRONT_NULL, "cursor", pfront_cursor_start(&query, NULL, &error));
    OK(pfront_cursor_start(&query, &cursor, &error));
    EXPECT(PFRONT_FOREIGN_CURSOR, "cursor", pfront_query_page(&other, &cursor, page, 4, &count, &error));
    EXPECT(PFRONT_TOO_SMALL, "page", pfront_query_page(&query, &cursor, page, 0, &count, &error));
    EXPECT(PFRONT_NULL, "page", pfront_query_page(&query, &cursor, NULL, 4, &count, &error));
    EXPECT(PFRONT_NULL, "count", pfront_query_page(&query, &cursor, page, 4, NULL, &error));
    EXPECT(PFRONT_OVERLAP, "cursor",
           pfront_query_page(&query, &cursor, (pfront_pair_t *)(void *)&cursor, 4, &count, &error));
    EXPECT(PFRONT_OVERLAP, "nodes",
           pfront_query_page(&query, &cursor, (pfront_pair_t *)(void *)nodes, 4, &count, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "node.a", pfront_cursor_at(&query, none, &cursor, &error));
    THAT(error.given == 99 && error.needed == query.a.node_count);
    OK(pfront_query_step(&query, &cursor, 0, page, 4, &count, &error));
    THAT(count == 0 && !cursor.done && cursor.triangle_tests == 0);
    EXPECT(PFRONT_OUT_OF_RANGE, "pairs.b", pfront_query_contacts(&query, &pair, 1, &contact, &error));
    pair.b = 0;
    OK(pfront_query_contacts(&query, &pair, 1, &contact, &error));
    EXPECT(PFRONT_NULL, "found", pfront_query_any(&query, &pair, NULL, &error));
    OK(pfront_query_any(&query, &pair, &found, &error));
    THAT(found == 1 && pair.a < pair.b);
}

static void fronts(void)
{
    pfront_query_t query;
    pfront_front_t front;
    pfront_front_node_t part[16];
    pfront_past_t past[16];
    pfront_load_t loads[2];
    const uint32_t gone = UINT32_MAX;
    memset(&front, 0, sizeof front);
    OK(pfront_query_pair(&bvh, &bvh, &still, PFRONT_EXACT, &query, &error));
    EXPECT(PFRONT_NOT_MADE, "front", pfront_front_divide(&front, &query, 1, loads, 2, &error));
    EXPECT(PFRONT_NULL, "nodes", pfront_front_init(&front, NULL, 16, past, 16, &error));
    EXPECT(PFRONT_OVERLAP, "past",
           pfront_front_init(&front, part, 16, (pfront_past_t *)(void *)part, 16, &error));
    OK(pfront_front_init(&front, part, 16, past, 16, &error));
    EXPECT(PFRONT_TOO_SMALL, "loads", pfront_front_divide(&front, &query, 1, loads, 0, &error));
    EXPECT(PFRONT_TOO_SMALL, "nodes", pfront_front_divide(&front, &query, 17, loads, 2, &error));
    EXPECT(PFRONT_NULL, "queries", pfront_front_divide(&front, NULL, 1, loads, 2, &error));
    OK(pfront_front_divide(&front, &query, 1, loads, 2, &error));
    THAT(front.node_count >= 1 && front.node_count <= 16);
    part[0].cost = -1;
    EXPECT(PFRONT_OUT_OF_RANGE, "nodes.cost", pfront_front_remember(&front, &error));
    part[0].cost = NAN;
    EXPECT(PFRONT_OUT_OF_RANGE, "nodes.cost", pfront_front_remember(&front, &error));
    part[0].cost = 1;
    front.past_capacity = 0;
    EXPECT(PFRONT_TOO_SMALL, "past", pfront_front_remember(&front, &error));
    front.past_capacity = 16;
    OK(pfront_front_remember(&front, &error));
    THAT(front.past_count == front.node_count);
    OK(pfront_front_divide(&front, &query, 1, loads, 2, &error));
    THAT(front.coherent == 1);
    OK(pfront_front_remember(&front, &error));
    OK(pfront_front_renumber(&front, &gone, 1, &error));
    THAT(front.past_count == 0);
}

// Last, since nothing is of use afterwards.
static void damage(void)
{
    pfront_query_t query;
    uint64_t count;
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, PFRONT_EXACT, &query, &error));
    nodes[0].first = 0x7ffffff0;
    EXPECT(PFRONT_DAMAGED, "", pfront_query_count(&query, &count, &error));
}

int main(void)
{
    meshes();
    builds();
    adoptions();
    refits();
    fans();
    queries();
    walks();
    fronts();
    damage();
    THAT(strcmp(pfront_error_text(0), "done") == 0);
    THAT(strcmp(pfront_error_text(UINT32_MAX), "no error code of pfront") == 0);
    THAT(strcmp(pfront_version(), "0.1.0") == 0);
    if (!wrong) {
        puts("each mistake got its code");
    }
    return wrong;
}
