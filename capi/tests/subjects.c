// Executors, questions about models and many of them at once, and bodies of scenes as such: right uses, and mistakes with their
// error codes. With WORKERS defined on threads, with DEVICE defined on that device.

#define _POSIX_C_SOURCE 200809L
#include "expect.h"

#include <sys/wait.h>
#include <unistd.h>

#ifndef WORKERS
#define WORKERS 1
#endif
#ifndef DEVICE
#define DEVICE PFRONT_CPU
#endif

static const pfront_buffers_t tetrahedra = {points, VERTICES, 12, corners, TRIANGLES, PFRONT_INDEX_U32};
static pfront_executor_t *executor;
static pfront_model_t *model, *doubles;

static pfront_pose_t at(float x)
{
    const pfront_pose_t pose = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return pose;
}

static void executors(void)
{
    pfront_executor_t *none = NULL;
    EXPECT(PFRONT_NULL, "executor", pfront_executor_create(PFRONT_CPU, 1, NULL, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "device", pfront_executor_create(3, 1, &none, &error));
    THAT(error.needed == 3 && error.given == 3);
#if WORKERS == 1
    EXPECT(PFRONT_OUT_OF_RANGE, "workers", pfront_executor_create(PFRONT_CPU, 2, &none, &error));
#endif
#ifndef WITH_GPU
    EXPECT(PFRONT_NO_DEVICE, "device", pfront_executor_create(PFRONT_GPU, 1, &none, &error));
    EXPECT(PFRONT_NO_DEVICE, "device", pfront_executor_create(PFRONT_AUTO, 1, &none, &error));
#endif
    THAT(none == NULL);
    OK(pfront_executor_free(NULL, &error));
    EXPECT(PFRONT_NOT_MADE, "executor",
           pfront_executor_free((pfront_executor_t *)(void *)scratch, &error));
    OK(pfront_executor_create(DEVICE, WORKERS, &executor, &error));
}

static void models(void)
{
    static double wide[3 * VERTICES];
    const pfront_buffers_t buffers = {wide, VERTICES, 24, corners, TRIANGLES, PFRONT_INDEX_U32};
    for (int i = 0; i < 3 * VERTICES; i++) {
        wide[i] = (double)points[i];
    }
    OK(pfront_model_create(&tetrahedra, &model, &error));
    OK(pfront_model_create_f64(&buffers, &doubles, &error));
}

// Every verb about a subject; `pairs` is what `pfront_model_query_count` is to say.
static void ask(pfront_model_query_t *query, const pfront_subject_t *subject, const pfront_pair_t *truth, size_t pairs)
{
    const pfront_pair_t *found;
    const pfront_model_contact_t *contacts;
    size_t count = 0;
    uint64_t many = 0, batched = 0;
    uint32_t is_found = 2, each = 2;
    pfront_pair_t pair = {99, 99}, some = {99, 99};
    OK(pfront_model_query_all(query, subject, &found, &count, &error));
    THAT(count == pairs && memcmp(found, truth, pairs * sizeof *truth) == 0);
    OK(pfront_model_query_count(query, subject, &many, &error));
    THAT(many == pairs);
    OK(pfront_model_query_any(query, subject, &pair, &is_found, &error));
    THAT(is_found == (pairs > 0) && (pair.a < 99) == (pairs > 0));
    OK(pfront_model_query_contacts(query, subject, &contacts, &count, &error));
    THAT(count == pairs);
    for (size_t i = 0; i < count; i++) {
        THAT(contacts[i].pair.a == truth[i].a && contacts[i].pair.b == truth[i].b);
        THAT(contacts[i].contact.kind != PFRONT_APART);
    }
    OK(pfront_batch_count(executor, subject, 1, &batched, &error));
    THAT(batched == pairs);
    OK(pfront_batch_any(executor, subject, 1, &some, &each, &error));
    THAT(each == is_found && (some.a < 99) == (pairs > 0));
}

static void subjects(void)
{
    const pfront_pose_t poses[2] = {at(0.25f), at(9)};
    const pfront_pose64_t exact = {{{1, 0, 0, 0.25}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    pfront_pair_list_t list, within;
    pfront_model_query_t *query = NULL;
    OK(pfront_model_query_create(executor, &query, &error));
    OK(pfront_all(&tetrahedra, &tetrahedra, &poses[0], NULL, &list, &error));
    OK(pfront_self(&tetrahedra, PFRONT_SHARED_INDEX, NULL, &within, &error));
    THAT(list.count > 0 && within.count > 0);
    const pfront_subject_t asked[5] = {
        {model, model, &poses[0], NULL, 0},         {model, model, &poses[1], NULL, 0},
        {model, doubles, &poses[0], NULL, 0},       {model, model, NULL, &exact, 0},
        {model, NULL, NULL, NULL, PFRONT_SHARED_INDEX},
    };
    const size_t counts[5] = {list.count, 0, list.count, list.count, within.count};
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < 5; i++) {
            ask(query, &asked[i], i < 4 ? list.pairs : within.pairs, counts[i]);
        }
    }
    uint64_t many[5] = {0};
    OK(pfront_batch_count(executor, asked, 5, many, &error));
    for (int i = 0; i < 5; i++) {
        THAT(many[i] == counts[i]);
    }
    OK(pfront_batch_count(NULL, NULL, 0, NULL, &error));

    pfront_subject_t wrong_one[2] = {asked[0], asked[4]};
    uint64_t count = 0;
    wrong_one[1].rule = PFRONT_BOXES_ONLY;
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_batch_count(executor, wrong_one, 2, many, &error));
    THAT(error.index == 1);
    EXPECT(PFRONT_NULL, "subject", pfront_model_query_count(query, NULL, &count, &error));
    wrong_one[1] = asked[0];
    wrong_one[1].b = NULL;
    EXPECT(PFRONT_NULL, "b", pfront_batch_count(executor, wrong_one, 2, many, &error));
    wrong_one[0].a_from_b = NULL;
    EXPECT(PFRONT_NULL, "a_from_b", pfront_model_query_count(query, &wrong_one[0], &count, &error));
    wrong_one[0].a = NULL;
    EXPECT(PFRONT_NULL, "a", pfront_model_query_count(query, &wrong_one[0], &count, &error));
    const pfront_pose_t far_away = at(1e38f);
    wrong_one[0] = asked[0];
    wrong_one[0].a_from_b = &far_away;
    EXPECT(PFRONT_POSE_RANGE, "a_from_b", pfront_model_query_count(query, &wrong_one[0], &count, &error));
    EXPECT(PFRONT_POSE_RANGE, "a_from_b", pfront_batch_count(executor, wrong_one, 1, many, &error));
    EXPECT(PFRONT_NULL, "query", pfront_model_query_count(NULL, &asked[0], &count, &error));
    EXPECT(PFRONT_NULL, "count", pfront_model_query_count(query, &asked[0], NULL, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_self(&tetrahedra, 3, NULL, &list, &error));
    // How far apart: not at all, and some way, which is told exactly at a limit.
    pfront_gap_t gap;
    uint32_t found = 2;
    OK(pfront_model_query_distance(query, &asked[0], INFINITY, &gap, &found, &error));
    THAT(found == 1 && gap.low == 0 && gap.high == 0 && gap.points[0][0] == gap.points[1][0]);
    OK(pfront_model_query_distance(query, &asked[1], INFINITY, &gap, &found, &error));
    THAT(found == 1 && 0 < gap.low && gap.low < gap.high && gap.high < gap.low * 1.000001);
    THAT(gap.pair.a < TRIANGLES && gap.pair.b < TRIANGLES && gap.points[0][0] < gap.points[1][0]);
    OK(pfront_model_query_distance(query, &asked[1], (float)(gap.low * 0.9), &gap, &found, &error));
    THAT(found == 0);
    OK(pfront_model_query_distance(query, &asked[1], (float)(gap.high * 1.1), &gap, &found, &error));
    THAT(found == 1);
    EXPECT(PFRONT_DISTANCE, "distance", pfront_model_query_distance(query, &asked[1], -1, &gap, &found, &error));
    EXPECT(PFRONT_NULL, "b", pfront_model_query_distance(query, &asked[4], 1, &gap, &found, &error));
    EXPECT(PFRONT_NULL, "gap", pfront_model_query_distance(query, &asked[1], 1, NULL, &found, &error));
    EXPECT(PFRONT_NULL, "found", pfront_model_query_distance(query, &asked[1], 1, &gap, NULL, &error));
    // Everything is within a kilometre, and 0 asks for what intersects again.
    OK(pfront_model_query_within(query, 1e3f, &error));
    OK(pfront_model_query_count(query, &asked[1], &count, &error));
    THAT(count == TRIANGLES * TRIANGLES);
    EXPECT(PFRONT_DISTANCE, "distance", pfront_model_query_within(query, -1, &error));
    OK(pfront_model_query_count(query, &asked[1], &count, &error));
    THAT(count == TRIANGLES * TRIANGLES);
    OK(pfront_model_query_within(query, 0, &error));
    // A list is good until another one of the kind is asked for.
    const pfront_pair_t *kept;
    const pfront_model_contact_t *contacts;
    size_t kept_count = 0, contact_count = 0;
    OK(pfront_model_query_all(query, &asked[0], &kept, &kept_count, &error));
    OK(pfront_model_query_contacts(query, &asked[4], &contacts, &contact_count, &error));
    OK(pfront_model_query_count(query, &asked[1], &count, &error));
    THAT(kept_count == list.count && memcmp(kept, list.pairs, kept_count * sizeof *kept) == 0);
    OK(pfront_model_query_free(query, &error));
    OK(pfront_model_query_free(NULL, &error));
    OK(pfront_pair_list_free(&list, &error));
    OK(pfront_pair_list_free(&within, &error));
}

static int32_t first_two(void *context, const pfront_scene_hit_t *hit)
{
    size_t *seen = context;
    THAT(hit->bodies[0] < hit->bodies[1]);
    return ++*seen == 2;
}

static int32_t all_of_them(void *context, const pfront_scene_hit_t *hit)
{
    (void)hit;
    ++*(size_t *)context;
    return 0;
}

static void bodies(void)
{
    pfront_scene_t *scene = NULL;
    uint64_t body[3];
    const uint64_t(*pairs)[2];
    const uint64_t *inside;
    const pfront_piece_t *pieces;
    const pfront_scene_hit_t *hits;
    size_t count = 0, seen = 0;
    uint32_t stopped = 2;
    OK(pfront_scene_create(executor, &scene, &error));
    for (int i = 0; i < 3; i++) {
        const pfront_pose_t pose = at((float)i * 1.5f);
        OK(pfront_scene_add(scene, model, &pose, &body[i], &error));
    }
    OK(pfront_scene_intersecting_bodies(scene, &pairs, &count, &error));
    THAT(count == 2 && pairs[0][0] == body[0] && pairs[0][1] == body[1] && pairs[1][1] == body[2]);
    const float low[3] = {-1, -1, -1}, high[3] = {-0.5f, 3, 3}, across[3] = {0.5f, 3, 3};
    OK(pfront_scene_bodies_in(scene, low, high, &inside, &count, &error));
    THAT(count == 0);
    OK(pfront_scene_bodies_in(scene, low, across, &inside, &count, &error));
    THAT(count == 1 && inside[0] == body[0]);
    EXPECT(PFRONT_NULL, "max", pfront_scene_bodies_in(scene, low, NULL, &inside, &count, &error));
    pfront_gap_t gap;
    uint64_t nearest = 0;
    uint32_t found = 2;
    OK(pfront_scene_distance(scene, body[2], INFINITY, &nearest, &gap, &found, &error));
    THAT(found == 1 && nearest == body[1] && gap.high == 0);
    OK(pfront_scene_ignore(scene, body[2], body[1], 1, &error));
    OK(pfront_scene_distance(scene, body[2], INFINITY, &nearest, &gap, &found, &error));
    THAT(found == 1 && nearest == body[0] && gap.low > 0 && gap.points[0][0] > gap.points[1][0]);
    OK(pfront_scene_distance(scene, body[2], (float)(gap.low * 0.9), &nearest, &gap, &found, &error));
    THAT(found == 0);
    EXPECT(PFRONT_DISTANCE, "distance", pfront_scene_distance(scene, body[2], NAN, &nearest, &gap, &found, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_distance(scene, 99, 1, &nearest, &gap, &found, &error));
    EXPECT(PFRONT_NULL, "nearest", pfront_scene_distance(scene, body[2], 1, NULL, &gap, &found, &error));
    OK(pfront_scene_ignore(scene, body[2], body[1], 0, &error));
    OK(pfront_scene_visit(scene, first_two, &seen, &stopped, &error));
    THAT(seen == 2 && stopped == 1);
    seen = 0;
    OK(pfront_scene_visit(scene, all_of_them, &seen, &stopped, &error));
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(seen == count && stopped == 0);
    EXPECT(PFRONT_NULL, "visit", pfront_scene_visit(scene, NULL, &seen, &stopped, &error));
    OK(pfront_scene_set_model(scene, body[2], doubles, &error));
    OK(pfront_scene_update(scene, &hits, &seen, &error));
    THAT(seen == count);
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_set_model(scene, body[2] + 1, model, &error));
    // The two tetrahedra of a body, each a body of its own: what the whole meets its pieces meet, and each other.
    uint32_t parts[TRIANGLES] = {7, 7, 7, 7, 3, 3, 3, 3};
    EXPECT(PFRONT_TOO_SMALL, "parts",
           pfront_scene_split(scene, body[0], parts, TRIANGLES - 1, &pieces, &count, &error));
    OK(pfront_scene_split(scene, body[0], parts, TRIANGLES, &pieces, &count, &error));
    THAT(count == 2 && pieces[0].part == 3 && pieces[1].part == 7);
    THAT(pieces[0].triangle_count == 4 && pieces[1].triangle_count == 4);
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(count > seen);
    EXPECT(PFRONT_STALE_BODY, "body",
           pfront_scene_split(scene, body[0], parts, TRIANGLES, &pieces, &count, &error));
    OK(pfront_scene_free(scene, &error));
}

// A child has neither the threads nor the GPU of its parent.
static void forked(void)
{
    int status = 1;
    uint64_t many = 0;
    pfront_scene_t *scene = NULL, *alone = scene_of(1), *third = NULL;
    pfront_model_query_t *query = NULL;
    pfront_executor_t *own = NULL;
    uint64_t body[2];
    const pfront_subject_t subject = {model, NULL, NULL, NULL, PFRONT_SHARED_INDEX};
    OK(pfront_scene_create(executor, &scene, &error));
    OK(pfront_model_query_create(executor, &query, &error));
    for (int i = 0; i < 2; i++) {
        OK(pfront_scene_add(alone, model, &still, &body[i], &error));
    }
    pid_t child = fork();
    if (child == 0) {
        alarm(20);
        OK(pfront_executor_create(PFRONT_CPU, 1, &own, &error));
        OK(pfront_batch_count(own, &subject, 1, &many, &error));
        THAT(many > 0);
        OK(pfront_executor_free(own, &error));
        // What has neither is moved, asked and freed there.
        const pfront_pose_t pose = at(0.25f);
        OK(pfront_scene_set_pose(alone, body[1], &pose, &error));
        OK(pfront_scene_count(alone, &many, &error));
        THAT(many > 0);
#ifdef WITH_GPU
        EXPECT(PFRONT_FORKED, "device", pfront_executor_create(PFRONT_GPU, 1, &own, &error));
#endif
        if (WORKERS > 1 || DEVICE != PFRONT_CPU) {
            EXPECT(PFRONT_FORKED, "executor", pfront_scene_create(executor, &third, &error));
            EXPECT(PFRONT_FORKED, "query", pfront_model_query_count(query, &subject, &many, &error));
            EXPECT(PFRONT_FORKED, "scene", pfront_scene_count(scene, &many, &error));
            EXPECT(PFRONT_FORKED, "executor", pfront_batch_count(executor, &subject, 1, &many, &error));
        } else {
            OK(pfront_model_query_count(query, &subject, &many, &error));
            OK(pfront_scene_count(scene, &many, &error));
            OK(pfront_scene_create(executor, &third, &error));
            OK(pfront_scene_free(third, &error));
        }
#if WORKERS > 1
        EXPECT(PFRONT_FORKED, "workers", pfront_executor_create(PFRONT_CPU, WORKERS, &own, &error));
#endif
        OK(pfront_scene_free(alone, &error));
        OK(pfront_model_query_free(query, &error));
        OK(pfront_scene_free(scene, &error));
        OK(pfront_executor_free(executor, &error));
        OK(pfront_model_free(model, &error));
        OK(pfront_model_free(doubles, &error));
        _exit(wrong);
    }
    THAT(waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0);
    OK(pfront_model_query_count(query, &subject, &many, &error));
    THAT(many > 0);
    OK(pfront_model_query_free(query, &error));
    OK(pfront_scene_count(alone, &many, &error));
    THAT(many > 0);
    OK(pfront_scene_free(alone, &error));
    OK(pfront_scene_free(scene, &error));
}

int main(void)
{
    executors();
    models();
    subjects();
    bodies();
    forked();
    OK(pfront_executor_free(executor, &error));
    OK(pfront_model_free(model, &error));
    OK(pfront_model_free(doubles, &error));
    return verdict();
}
