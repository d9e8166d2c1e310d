// What a C program can do wrong with meshes, BVHs and one-rings, and the error code that it gets for it.

#include "expect.h"

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
    EXPECT(PFRONT_OVERLAP, "positions",
           pfront_mesh_check((const float *)(const void *)&none, 8, corners, 8, &none, &error));
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
    EXPECT(PFRONT_TOO_SMALL, "nodes", pfront_bvh_build_sah(&mesh, 1, &memory, &bvh, &error));
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
    THAT(pfront_link_scratch_bytes(SIZE_MAX, 1) == SIZE_MAX);
    THAT(pfront_history_bound(SIZE_MAX, 1) == SIZE_MAX);
    memory = good;
    // The BVH would lie where its nodes do.
    EXPECT(PFRONT_OVERLAP, "nodes",
           pfront_bvh_build_sah(&mesh, 0, &memory, (pfront_bvh_t *)(void *)nodes, &error));
    // Scratch may have any alignment.
    memory.scratch = scratch + 1;
    memory.scratch_bytes = pfront_sah_scratch_bytes(TRIANGLES);
    OK(pfront_bvh_build_sah(&mesh, 1, &memory, &bvh, &error));
}

// Constants for static arrays are what the functions return.
static void sizes(void)
{
    for (size_t n = 0; n < 200; n++) {
        THAT(PFRONT_NODE_BOUND(n) == pfront_node_bound(n));
        THAT(PFRONT_MORTON_SCRATCH_BYTES(n) == pfront_morton_scratch_bytes(n));
        THAT(PFRONT_SAH_SCRATCH_BYTES(n) == pfront_sah_scratch_bytes(n));
        THAT(PFRONT_ADOPT_SCRATCH_BYTES(n) == pfront_adopt_scratch_bytes(n));
        THAT(PFRONT_LINK_SCRATCH_BYTES(3 * n, n) == pfront_link_scratch_bytes(3 * n, n));
        THAT(PFRONT_HISTORY_BOUND(3 * n, n) == pfront_history_bound(3 * n, n));
    }
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

static void one_rings(void)
{
    uint32_t history[PFRONT_HISTORY_BOUND(VERTICES, TRIANGLES)];
    size_t words = sizeof history / sizeof *history;
    size_t bytes = pfront_link_scratch_bytes(VERTICES, TRIANGLES);
    pfront_query_t query;
    EXPECT(PFRONT_TOO_SMALL, "history",
           pfront_one_rings_link(&mesh, history, words - 1, scratch, bytes, &error));
    EXPECT(PFRONT_TOO_SMALL, "scratch",
           pfront_one_rings_link(&mesh, history, words, scratch, bytes - 1, &error));
    OK(pfront_one_rings_link(&mesh, history, words, scratch, bytes, &error));
    EXPECT(PFRONT_OVERLAP, "history",
           pfront_query_self(&bvh, (uint32_t *)(void *)&query, 0, &query, &error));
    OK(pfront_query_self(&bvh, history, 0, &query, &error));
}

int main(void)
{
    meshes();
    builds();
    sizes();
    adoptions();
    refits();
    one_rings();
    return verdict();
}
