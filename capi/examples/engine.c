// A game engine's loop, in C99: two rings that sink into each other, and a sheet that rolls up; first mesh by mesh in
// memory of its own, then as bodies of a scene. What it prints is what pfront finds from Rust (examples/reference.rs).

#include "scene.h"

#include <string.h>

#define BUDGET 500
#define WORKERS 2
#define FRONT 400
#ifndef WORKERS_OF_SCENE
#define WORKERS_OF_SCENE 1
#endif

// All pairs of a query in steps of bounded work, as an engine spreads it over frames.
static void in_steps(const pfront_query_t *query, list_t *list)
{
    pfront_cursor_t cursor;
    pfront_pair_t page[PAGE];
    pfront_error_t error;
    size_t count;
    list->count = 0;
    check(pfront_cursor_start(query, &cursor, &error), &error);
    while (!cursor.done) {
        uint64_t before = cursor.box_tests + cursor.triangle_tests;
        check(pfront_query_step(query, &cursor, BUDGET, page, PAGE, &count, &error), &error);
        append(list, page, count);
        if (cursor.box_tests + cursor.triangle_tests - before > BUDGET + 16) {
            fprintf(stderr, "a step took more than its budget\n");
            exit(1);
        }
    }
}

// Tells from others where the pairs of a list meet.
static uint32_t segments(const pfront_query_t *query, const list_t *list)
{
    pfront_error_t error;
    pfront_contact_t *contacts = memory(list->count * sizeof *contacts);
    check(pfront_query_contacts(query, list->pairs, list->count, contacts, &error), &error);
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < list->count; i++) {
        uint32_t bits[6];
        memcpy(bits, contacts[i].segment, sizeof bits);
        for (int k = 0; k < 6; k++) {
            hash = (hash ^ bits[k]) * 16777619u;
        }
    }
    free(contacts);
    return hash;
}

// Bakes a model into bytes, as a tool does before a game is shipped.
static void *baked(const pfront_bvh_t *bvh, size_t *bytes)
{
    pfront_error_t error;
    check(pfront_blob_size(bvh, bytes, &error), &error);
    void *blob = memory(*bytes);
    check(pfront_blob_write(bvh, blob, *bytes, &error), &error);
    return blob;
}

// Borrows a model from bytes, as the game does: nothing is built or copied.
static pfront_bvh_t borrowed(const void *blob, size_t blob_bytes)
{
    pfront_bvh_t bvh;
    pfront_error_t error;
    size_t bytes;
    check(pfront_blob_scratch_bytes(blob, blob_bytes, &bytes, &error), &error);
    void *scratch = memory(bytes);
    check(pfront_bvh_from_blob(blob, blob_bytes, scratch, bytes, &bvh, &error), &error);
    free(scratch);
    return bvh;
}

// A vertex as renderers have it, and a mesh of these with indices of 16 bits.
typedef struct {
    float position[3], normal[3];
} vertex_t;

static pfront_buffers_t interleaved(const grid_t *grid)
{
    vertex_t *vertices = memory(grid->vertices * sizeof *vertices);
    uint16_t *indices = memory(3 * grid->triangles * sizeof *indices);
    for (size_t i = 0; i < grid->vertices; i++) {
        const vertex_t vertex = {{0, 0, 0}, {0, 0, 1}};
        vertices[i] = vertex;
        memcpy(vertices[i].position, grid->positions + 3 * i, sizeof vertices[i].position);
    }
    for (size_t i = 0; i < 3 * grid->triangles; i++) {
        indices[i] = (uint16_t)grid->indices[i];
    }
    const pfront_buffers_t buffers = {vertices, grid->vertices, sizeof *vertices, indices,
                                      grid->triangles, PFRONT_INDEX_U16};
    return buffers;
}

static pfront_buffers_t packed(const grid_t *grid)
{
    const pfront_buffers_t buffers = {grid->positions, grid->vertices, 0, grid->indices,
                                      grid->triangles, PFRONT_INDEX_U32};
    return buffers;
}

// The bodies of a scene: a ring that stands still, one that sinks into it, the same elsewhere, and a sheet.
enum { STILL, SINKING, TWIN, SHEET, BODIES };

static pfront_scene_t *new_scene(const pfront_buffers_t *a, const void *blob, size_t blob_bytes,
                                 const pfront_buffers_t *sheet, const pfront_pose_t *world_from_a,
                                 uint64_t bodies[BODIES])
{
    const pfront_pose_t still = PFRONT_POSE_IDENTITY;
    pfront_executor_t *executor;
    pfront_scene_t *scene;
    pfront_model_t *models[3];
    pfront_error_t error;
    check(pfront_executor_create(PFRONT_CPU, WORKERS_OF_SCENE, &executor, &error), &error);
    check(pfront_scene_create(executor, &scene, &error), &error);
    check(pfront_executor_free(executor, &error), &error); // the scene keeps its threads
    check(pfront_model_create(a, &models[0], &error), &error);
    check(pfront_model_from_blob(blob, blob_bytes, &models[1], &error), &error);
    check(pfront_model_create(sheet, &models[2], &error), &error);
    check(pfront_scene_add(scene, models[0], world_from_a, &bodies[STILL], &error), &error);
    check(pfront_scene_add(scene, models[1], &still, &bodies[SINKING], &error), &error);
    check(pfront_scene_add(scene, models[1], &still, &bodies[TWIN], &error), &error);
    check(pfront_scene_add(scene, models[2], &still, &bodies[SHEET], &error), &error);
    for (uint64_t entity = 0; entity < BODIES; entity++) {
        check(pfront_scene_set_user_data(scene, bodies[entity], entity, &error), &error);
    }
    check(pfront_scene_ignore(scene, bodies[SINKING], bodies[TWIN], 1, &error), &error);
    for (int i = 0; i < 3; i++) {
        check(pfront_model_free(models[i], &error), &error); // the bodies keep them
    }
    return scene;
}

// One frame of the scene; tells how many pairs of triangles meet, and what tells their list from others.
static size_t in_scene(pfront_scene_t *scene, const uint64_t bodies[BODIES], unsigned frame,
                       const pfront_pose_t *world_from_a, const grid_t *sheet, uint32_t *hash)
{
    pfront_error_t error;
    const pfront_scene_hit_t *hits;
    size_t count;
    const pfront_pose_t a_from_b = pose(frame);
    pfront_pose_t world_from_b, twin;
    check(pfront_pose_multiply(world_from_a, &a_from_b, &world_from_b, &error), &error);
    check(pfront_scene_set_pose(scene, bodies[SINKING], &world_from_b, &error), &error);
    float columns[16] = {0};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 4; k++) {
            columns[4 * k + i] = a_from_b.rows[i][k];
        }
    }
    check(pfront_pose_from_cols_array(columns, &twin, &error), &error);
    check(pfront_scene_set_pose(scene, bodies[TWIN], &twin, &error), &error);
    check(pfront_scene_set_positions(scene, bodies[SHEET], sheet->positions, sheet->vertices, 0,
                                     &error),
          &error);
    check(pfront_scene_update(scene, &hits, &count, &error), &error);
    *hash = 2166136261u;
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 2; k++) {
            uint64_t entity;
            check(pfront_scene_user_data(scene, hits[i].bodies[k], &entity, &error), &error);
            *hash = (*hash ^ (uint32_t)entity) * 16777619u;
        }
        *hash = (*hash ^ hits[i].pair.a) * 16777619u;
        *hash = (*hash ^ hits[i].pair.b) * 16777619u;
    }
    return count;
}

static void same(uint32_t one, uint32_t other, const char *how)
{
    if (one != other) {
        fprintf(stderr, "%s: another list of pairs\n", how);
        exit(1);
    }
}

int main(void)
{
    grid_t a = new_grid(40, 24, 1), b = new_grid(40, 24, 1), cloth = new_grid(48, 24, 0);
    ring(&a, 0.0f);
    ring(&b, 0.3f);
    ring(&cloth, 0.3f); // as it was modelled: in another shape altogether
    model_t model_a = new_model(&a), model_b = new_model(&b), sheet = new_model(&cloth);
    size_t baked_bytes;
    void *blob = baked(&model_b.bvh, &baked_bytes);
    pfront_bvh_t from_blob = borrowed(blob, baked_bytes);

    pfront_error_t error;
    size_t words = pfront_history_bound(cloth.vertices, cloth.triangles);
    uint32_t *history = memory(words * sizeof(uint32_t));
    size_t bytes = pfront_link_scratch_bytes(cloth.vertices, cloth.triangles);
    void *scratch = memory(bytes);
    check(pfront_one_rings_link(&sheet.bvh.mesh, history, words, scratch, bytes, &error), &error);
    free(scratch);
    float as_built, now;
    check(pfront_bvh_quality(&sheet.bvh, &as_built, &error), &error);

    pfront_front_t front;
    pfront_front_node_t *nodes = memory(FRONT * sizeof *nodes);
    pfront_front_node_t *last_nodes = memory(FRONT * sizeof *last_nodes);
    check(pfront_front_init(&front, nodes, FRONT, last_nodes, FRONT, &error), &error);

    const float rotation[4] = {0, 0, 0.6f, 0.8f}, translation[3] = {1, 2, 3};
    pfront_pose_t world_from_a;
    check(pfront_pose_from_rotation_translation(rotation, translation, &world_from_a, &error), &error);
    pfront_buffers_t buffers_a = packed(&a), buffers_b = interleaved(&b), buffers_c = packed(&cloth);
    uint64_t bodies[BODIES];
    pfront_scene_t *scene =
        new_scene(&buffers_a, blob, baked_bytes, &buffers_c, &world_from_a, bodies);

    list_t list = {NULL, 0, 0};
    unsigned rebuilt = 0, coherent = 0;
    for (unsigned frame = 0; frame < FRAMES; frame++) {
        // Two meshes, one of them posed.
        pfront_query_t query;
        pfront_pose_t a_from_b = pose(frame);
        check(pfront_query_pair(&model_a.bvh, &model_b.bvh, &a_from_b, &query, &error),
              &error);
        in_pages(&query, &list);
        uint32_t hash = fingerprint(&list);
        size_t meeting = list.count;
        uint32_t where = segments(&query, &list);
        in_steps(&query, &list);
        same(hash, fingerprint(&list), "steps");
        check(pfront_query_pair(&model_a.bvh, &from_blob, &a_from_b, &query, &error),
              &error);
        in_pages(&query, &list);
        same(hash, fingerprint(&list), "a blob");

        // The same in one call, of the buffers that a renderer has.
        pfront_pair_list_t pairs;
        check(pfront_all(&buffers_a, &buffers_b, &a_from_b, NULL, &pairs, &error), &error);
        list.count = 0;
        append(&list, pairs.pairs, pairs.count);
        check(pfront_pair_list_free(&pairs, &error), &error);
        same(hash, fingerprint(&list), "one call");

        // The same dealt out to workers.
        pfront_part_t parts[WORKERS];
        check(pfront_front_divide(&front, &query, 1, parts, WORKERS, &error), &error);
        list.count = 0;
        for (uint32_t part = 0; part < WORKERS; part++) {
            work(&query, &front, part, &list);
        }
        same(hash, fingerprint(&list), "workers");
        check(pfront_front_remember(&front, &error), &error);
        coherent += front.coherent;

        // One mesh that deforms.
        roll(&cloth, frame);
        check(pfront_bvh_refit(&sheet.bvh, cloth.positions, cloth.vertices, &now, &error), &error);
        if (now > (float)PFRONT_REBUILD_RATIO * as_built) {
            pfront_mesh_t mesh = sheet.bvh.mesh;
            check(pfront_bvh_build_sah(&mesh, 0, &sheet.memory, &sheet.bvh, &error), &error);
            check(pfront_bvh_quality(&sheet.bvh, &as_built, &error), &error);
            rebuilt++;
        }
        check(pfront_query_self(&sheet.bvh, history, PFRONT_SHARED_INDEX, &query,
                                &error),
              &error);
        in_pages(&query, &list);
        printf("frame %u: %zu pairs, list %08x, segments %08x; ", frame, meeting, (unsigned)hash,
               (unsigned)where);
        printf("sheet: %zu pairs, ", list.count);
        printf("list %08x; ", (unsigned)fingerprint(&list));

        // All of them, and one more, as bodies in the world.
        uint32_t hits_hash;
        size_t hits = in_scene(scene, bodies, frame, &world_from_a, &cloth, &hits_hash);
        printf("scene: %zu hits, list %08x\n", hits, (unsigned)hits_hash);
    }
    fprintf(stderr, "pfront %s: fronts of the last frame used %u times, sheet rebuilt %u times\n",
            pfront_version(), coherent, rebuilt);

    check(pfront_scene_free(scene, &error), &error);
    free((void *)buffers_b.positions);
    free((void *)buffers_b.triangles);
    free(list.pairs);
    free(blob);
    free(nodes);
    free(last_nodes);
    free(history);
    free_model(&model_a);
    free_model(&model_b);
    free_model(&sheet);
    free_grid(&a);
    free_grid(&b);
    free_grid(&cloth);
    return 0;
}
