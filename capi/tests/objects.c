// What models, scenes and lists do when they are freed, freed twice, copied, and used by two threads: the table of
// README.md. With an argument only everything is asked, PFRONT_ROUNDS times, and the process ends in that way: return, exit,
// error, thread, open.

#define _POSIX_C_SOURCE 200809L
#include "expect.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#ifndef WORKERS
#define WORKERS 1
#endif

static const pfront_buffers_t tetrahedra = {points, VERTICES, 12, corners, TRIANGLES, PFRONT_INDEX_U32};

static pfront_pose_t at(float x)
{
    const pfront_pose_t pose = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return pose;
}

// A scene of two bodies in touch.
static pfront_scene_t *two(pfront_model_t **model, uint64_t bodies[2], uint32_t workers)
{
    pfront_scene_t *scene = scene_of(workers);
    OK(pfront_model_create(&tetrahedra, model, &error));
    for (int i = 0; i < 2; i++) {
        const pfront_pose_t pose = at((float)i * 1.5f);
        OK(pfront_scene_add(scene, *model, &pose, &bodies[i], &error));
    }
    return scene;
}

static size_t hits_of(pfront_scene_t *scene)
{
    const pfront_scene_hit_t *hits;
    size_t count = 0;
    OK(pfront_scene_update(scene, &hits, &count, &error));
    return count;
}

// Everything there is, once; in one order or the other it is given back.
static void everything(int reversed)
{
    static uint32_t blob[1024];
    pfront_model_t *model, *baked;
    uint64_t bodies[2], many;
    pfront_pair_list_t list;
    pfront_query_t query;
    pfront_cursor_t cursor;
    pfront_pair_t page[256];
    const pfront_scene_contact_t *contacts;
    const pfront_scene_contact64_t *contacts_f64;
    size_t bytes, count;
    pfront_scene_t *scene = two(&model, bodies, WORKERS);
    make();
    OK(pfront_query_self(&bvh, NULL, PFRONT_SHARED_INDEX, &query, &error));
    OK(pfront_cursor_start(&query, &cursor, &error));
    OK(pfront_query_page(&query, &cursor, page, 256, &count, &error));
    OK(pfront_blob_size(&bvh, &bytes, &error));
    OK(pfront_blob_write(&bvh, blob, sizeof blob, &error));
    OK(pfront_model_from_blob(blob, bytes, &baked, &error));
    OK(pfront_scene_add(scene, baked, &still, &bodies[1], &error));
    OK(pfront_all(&tetrahedra, &tetrahedra, &still, NULL, &list, &error));
    THAT(list.count > 0 && hits_of(scene) > 0);
    OK(pfront_scene_contacts(scene, &contacts, &count, &error));
    OK(pfront_scene_contacts_f64(scene, &contacts_f64, &count, &error));
    OK(pfront_scene_count(scene, &many, &error));
    THAT(many == count);
    if (reversed) {
        OK(pfront_model_free(model, &error));
        OK(pfront_model_free(baked, &error));
        THAT(hits_of(scene) > 0); // its bodies have their models still
        OK(pfront_pair_list_free(&list, &error));
        OK(pfront_scene_free(scene, &error));
    } else {
        OK(pfront_scene_free(scene, &error));
        OK(pfront_pair_list_free(&list, &error));
        OK(pfront_model_free(baked, &error));
        OK(pfront_model_free(model, &error));
    }
    EXPECT(PFRONT_NOT_MADE, "list", pfront_pair_list_free(&list, &error)); // it was emptied
}

// What a function of a scene hands out is good until the same is called again.
static void lists_of_a_scene(void)
{
    pfront_model_t *model;
    uint64_t bodies[2], many;
    uint32_t found;
    pfront_scene_hit_t hit, *kept;
    const pfront_scene_hit_t *hits;
    const pfront_scene_contact_t *contacts;
    const pfront_scene_contact64_t *contacts_f64;
    size_t count, others;
    const pfront_pose_t away = at(100);
    const pfront_pose64_t near = {{{1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    pfront_scene_t *scene = two(&model, bodies, WORKERS);
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(count > 0);
    kept = malloc(count * sizeof *hits);
    memcpy(kept, hits, count * sizeof *hits);
    OK(pfront_scene_contacts(scene, &contacts, &others, &error));
    THAT(others == count && memcmp(&contacts[0].hit, kept, sizeof hit) == 0);
    OK(pfront_scene_set_pose_f64(scene, bodies[1], &near, &error));
    OK(pfront_scene_contacts_f64(scene, &contacts_f64, &others, &error));
    OK(pfront_scene_contacts(scene, &contacts, &others, &error));
    OK(pfront_scene_set_pose(scene, bodies[1], &away, &error));
    OK(pfront_scene_count(scene, &many, &error));
    OK(pfront_scene_any(scene, &hit, &found, &error));
    OK(pfront_scene_contacts_f64(scene, &contacts_f64, &others, &error));
    THAT(many == 0 && found == 0 && others == 0);
    OK(pfront_scene_remove(scene, bodies[0], &error));
    OK(pfront_model_free(model, &error));
    THAT(memcmp(kept, hits, count * sizeof *hits) == 0);
    free(kept);
    OK(pfront_scene_free(scene, &error));
}

// Bytes of a scene or of a model are none.
static void copies(void)
{
    pfront_model_t *model;
    uint64_t bodies[2], many, copy[8];
    pfront_scene_t *scene = two(&model, bodies, 1);
    memcpy(copy, scene, sizeof copy);
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_count((pfront_scene_t *)(void *)copy, &many, &error));
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_free((pfront_scene_t *)(void *)copy, &error));
    EXPECT(PFRONT_NOT_MADE, "model", pfront_model_free((pfront_model_t *)(void *)scene, &error));
    memcpy(copy, model, 16);
    EXPECT(PFRONT_NOT_MADE, "model", pfront_model_free((pfront_model_t *)(void *)copy, &error));
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_free(model, &error));
}

// Structures whose members C knows may be copied, and a cursor goes on from where it was copied.
static void copies_of_plain_data(void)
{
    pfront_query_t query, moved;
    pfront_cursor_t cursor, other;
    pfront_pair_t first[256], second[256];
    size_t count, again;
    make();
    OK(pfront_query_self(&bvh, NULL, PFRONT_BOXES_ONLY, &query, &error));
    OK(pfront_cursor_start(&query, &cursor, &error));
    memcpy(&moved, &query, sizeof query);
    memset(&query, 0, sizeof query);
    memcpy(&other, &cursor, sizeof cursor);
    OK(pfront_query_page(&moved, &cursor, first, 256, &count, &error));
    OK(pfront_query_page(&moved, &other, second, 256, &again, &error));
    THAT(count > 0 && count == again && memcmp(first, second, count * sizeof *first) == 0);
    EXPECT(PFRONT_NOT_MADE, "query", pfront_query_page(&query, &cursor, first, 256, &count, &error));
}

struct shared {
    pfront_scene_t *scene;
    uint64_t body;
    volatile int stop;
};

static void *asks(void *given)
{
    struct shared *shared = given;
    for (int frame = 0; !shared->stop; frame++) {
        const pfront_pose_t pose = at(1.5f + 0.001f * (float)(frame % 7));
        const pfront_scene_contact_t *contacts;
        size_t count;
        pfront_scene_set_pose(shared->scene, shared->body, &pose, NULL);
        pfront_scene_contacts(shared->scene, &contacts, &count, NULL);
    }
    return NULL;
}

// A scene that a thread is inside of is refused to others, and not freed under it.
static void two_threads(void)
{
    pfront_model_t *model;
    uint64_t bodies[2], many;
    pthread_t thread;
    struct shared shared = {two(&model, bodies, 1), 0, 0};
    int busy = 0;
    for (int i = 0; i < 10; i++) {
        const pfront_pose_t pose = at(0.1f * (float)i);
        OK(pfront_scene_add(shared.scene, model, &pose, &bodies[0], &error));
    }
    shared.body = bodies[1];
    THAT(pthread_create(&thread, NULL, asks, &shared) == 0);
    for (int tries = 0; busy < 3 && tries < 1000; tries++) {
        const struct timespec moment = {0, 1000000};
        pfront_status_t status = pfront_scene_count(shared.scene, &many, NULL);
        busy += status == PFRONT_BUSY;
        THAT(status == PFRONT_BUSY || status == PFRONT_OK);
        nanosleep(&moment, NULL);
    }
    THAT(busy > 0);
    shared.stop = 1;
    pthread_join(thread, NULL);
    OK(pfront_scene_free(shared.scene, &error));
    OK(pfront_model_free(model, &error));
}

#ifdef TWICE
// The second time finds no seal: memory checkers see before that freed memory is read.
static void freed_twice(void)
{
    pfront_model_t *model;
    uint64_t bodies[2], many;
    pfront_scene_t *scene = two(&model, bodies, 1);
    OK(pfront_scene_free(scene, &error));
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_free(scene, &error));
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_count(scene, &many, &error));
    OK(pfront_model_free(model, &error));
    EXPECT(PFRONT_NOT_MADE, "model", pfront_model_free(model, &error));
}
#endif

static void *leaves(void *way)
{
    (void)way;
    everything(0);
    exit(wrong);
}

int main(int count, char **arguments)
{
    const char *way = count > 1 ? arguments[1] : "", *asked = getenv("PFRONT_ROUNDS");
    const int rounds = asked ? atoi(asked) : 3;
    for (int round = 0; round < rounds; round++) {
        everything(round % 2);
    }
    if (strcmp(way, "exit") == 0) {
        exit(wrong);
    } else if (strcmp(way, "error") == 0) {
        EXPECT(PFRONT_NULL, "scene", pfront_scene_create(NULL, NULL, &error));
        return wrong;
    } else if (strcmp(way, "thread") == 0) {
        pthread_t thread;
        pthread_create(&thread, NULL, leaves, NULL);
        pthread_join(thread, NULL);
        return 1;
    } else if (strcmp(way, "open") == 0) {
        // What is still there, and asked, when the process ends. Compilers leave out what is only written.
        static void *volatile kept[2];
        pfront_model_t *model;
        uint64_t bodies[2];
        pfront_scene_t *scene = two(&model, bodies, WORKERS);
        kept[0] = model;
        kept[1] = scene;
        THAT(kept[0] != NULL && hits_of(kept[1]) > 0);
        return wrong;
    } else if (strcmp(way, "return") == 0) {
        return wrong;
    }
    lists_of_a_scene();
    copies();
    copies_of_plain_data();
    two_threads();
#ifdef TWICE
    freed_twice();
#endif
    return verdict();
}
