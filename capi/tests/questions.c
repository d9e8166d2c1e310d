// What a C program can ask wrong, and the error code that it gets for it.

#include "expect.h"

static void queries(void)
{
    pfront_query_t query, zero;
    pfront_pose_t pose = still;
    uint64_t many;
    memset(&zero, 0, sizeof zero);
    EXPECT(PFRONT_NULL, "b", pfront_query_pair(&bvh, NULL, &still, &query, &error));
    EXPECT(PFRONT_NULL, "a_from_b", pfront_query_pair(&bvh, &bvh, NULL, &query, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_query_self(&bvh, NULL, 3, &query, &error));
    pose.rows[1][2] = NAN;
    EXPECT(PFRONT_POSE_NOT_FINITE, "a_from_b",
           pfront_query_pair(&bvh, &bvh, &pose, &query, &error));
    THAT(error.index == 6);
    pose.rows[1][2] = 1e38f;
    EXPECT(PFRONT_POSE_RANGE, "world_from_a",
           pfront_query_world(&bvh, &pose, &bvh, &still, &query, &error));
    THAT(error.index == 1);
    EXPECT(PFRONT_NOT_MADE, "query", pfront_query_count(&zero, &many, &error));
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, &query, &error));
    query.rule = 77;
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_query_count(&query, &many, &error));
    query.rule = PFRONT_SHARED_INDEX;
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
    const pfront_node_pair_t none = {99, 0}, unused = {0, 1};
    memset(&cursor, 0, sizeof cursor);
    OK(pfront_mesh_check(points, 4, corners, 4, &half, &error));
    OK(pfront_bvh_build_morton(&half, 1, &memory, &small, &error));
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, &query, &error));
    OK(pfront_query_pair(&small, &bvh, &still, &other, &error));
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
    EXPECT(PFRONT_OUT_OF_RANGE, "node.b", pfront_cursor_at(&query, unused, &cursor, &error));
    THAT(error.given == 1);
    OK(pfront_cursor_start(&query, &cursor, &error));
    OK(pfront_query_step(&query, &cursor, 0, page, 4, &count, &error));
    THAT(count == 0 && !cursor.done && cursor.triangle_tests == 0);
    EXPECT(PFRONT_OUT_OF_RANGE, "pairs.b", pfront_query_contacts(&query, &pair, 1, &contact, &error));
    pair.b = 0;
    OK(pfront_query_contacts(&query, &pair, 1, &contact, &error));
    EXPECT(PFRONT_NULL, "found", pfront_query_any(&query, &pair, NULL, &error));
    EXPECT(PFRONT_OVERLAP, "found", pfront_query_any(&query, &pair, &pair.b, &error));
    EXPECT(PFRONT_OVERLAP, "query",
           pfront_cursor_start(&query, (pfront_cursor_t *)(void *)&query, &error));
    OK(pfront_query_any(&query, &pair, &found, &error));
    THAT(found == 1 && pair.a < pair.b);
}

static void fronts(void)
{
    pfront_query_t query;
    pfront_front_t front;
    pfront_front_node_t part[16];
    pfront_front_node_t history[16];
    pfront_part_t parts[2];
    const uint32_t gone = UINT32_MAX;
    memset(&front, 0, sizeof front);
    OK(pfront_query_pair(&bvh, &bvh, &still, &query, &error));
    EXPECT(PFRONT_NOT_MADE, "front", pfront_front_divide(&front, &query, 1, parts, 2, &error));
    EXPECT(PFRONT_NULL, "nodes", pfront_front_init(&front, NULL, 16, history, 16, &error));
    EXPECT(PFRONT_OVERLAP, "history",
           pfront_front_init(&front, part, 16, (pfront_front_node_t *)(void *)part, 16, &error));
    OK(pfront_front_init(&front, part, 16, history, 16, &error));
    EXPECT(PFRONT_TOO_SMALL, "parts", pfront_front_divide(&front, &query, 1, parts, 0, &error));
    EXPECT(PFRONT_TOO_SMALL, "nodes", pfront_front_divide(&front, &query, 17, parts, 2, &error));
    EXPECT(PFRONT_NULL, "queries", pfront_front_divide(&front, NULL, 1, parts, 2, &error));
    OK(pfront_front_divide(&front, NULL, 0, parts, 2, &error));
    THAT(front.node_count == 0);
    // What may be changed may be anything.
    front.g = NAN;
    front.g_estimated = INFINITY;
    OK(pfront_front_divide(&front, &query, 1, parts, 2, &error));
    THAT(front.node_count >= 1 && front.node_count <= 16);
    part[0].cost = -1;
    EXPECT(PFRONT_OUT_OF_RANGE, "nodes.cost", pfront_front_remember(&front, &error));
    part[0].cost = NAN;
    EXPECT(PFRONT_OUT_OF_RANGE, "nodes.cost", pfront_front_remember(&front, &error));
    part[0].cost = 1;
    front.history_capacity = 0;
    EXPECT(PFRONT_TOO_SMALL, "history", pfront_front_remember(&front, &error));
    front.history_capacity = 16;
    OK(pfront_front_remember(&front, &error));
    THAT(front.history_count == front.node_count);
    OK(pfront_front_divide(&front, &query, 1, parts, 2, &error));
    THAT(front.coherent == 1);
    OK(pfront_front_remember(&front, &error));
    OK(pfront_front_renumber(&front, &gone, 1, &error));
    THAT(front.history_count == 0);
}

// Last, since nothing is of use afterwards.
static void damage(void)
{
    pfront_query_t query;
    uint64_t count;
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, &query, &error));
    nodes[0].first = 0x7ffffff0;
    EXPECT(PFRONT_DAMAGED, "", pfront_query_count(&query, &count, &error));
}

int main(void)
{
    make();
    queries();
    walks();
    fronts();
    damage();
    THAT(strcmp(pfront_error_text(0), "done") == 0);
    THAT(strcmp(pfront_error_text(PFRONT_NO_INVERSE), "a pose is flat or not finite and has no inverse") == 0);
    THAT(strcmp(pfront_error_text(PFRONT_BIG_ENDIAN), "a big-endian machine cannot borrow a blob") == 0);
    THAT(strcmp(pfront_error_text(UINT32_MAX), "no error code of pfront") == 0);
    THAT(strcmp(pfront_version(), "0.1.0") == 0);
    return verdict();
}
