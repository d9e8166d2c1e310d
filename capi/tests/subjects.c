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
    // Many at once, of which one is too far apart.
    pfront_gap_t gaps[4];
    uint32_t near[4] = {2, 2, 2, 2};
    OK(pfront_batch_distance(executor, asked, 4, INFINITY, gaps, near, &error));
    for (int i = 0; i < 4; i++) {
        THAT(near[i] == 1 && (gaps[i].high == 0) == (i != 1));
    }
    OK(pfront_batch_distance(NULL, asked, 4, (float)(gap.low * 0.9), gaps, near, &error));
    THAT(near[0] == 1 && near[1] == 0 && near[2] == 1 && near[3] == 1);
    THAT(gaps[1].low == gap.low && gaps[1].high == gap.high);
    OK(pfront_batch_distance(NULL, NULL, 0, INFINITY, NULL, NULL, &error));
    EXPECT(PFRONT_DISTANCE, "distance", pfront_batch_distance(executor, asked, 4, -1, gaps, near, &error));
    EXPECT(PFRONT_NULL, "b", pfront_batch_distance(executor, asked, 5, INFINITY, (pfront_gap_t[5]){0}, (uint32_t[5]){0}, &error));
    THAT(error.index == 4);
    EXPECT(PFRONT_NULL, "gaps", pfront_batch_distance(executor, asked, 4, INFINITY, NULL, near, &error));
    // On the way: the second tetrahedron flies through the first, which no frame shows.
    const pfront_pose64_t ahead = {{{1, 0, 0, 9}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const pfront_pose64_t behind = {{{1, 0, 0, -9}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const pfront_motion_t still = {model, NULL, NULL, NULL}, flight = {model, NULL, &ahead, &behind};
    const pfront_impact_t *impacts;
    size_t impact_count = 0;
    OK(pfront_model_query_impacts(query, &still, &flight, 0, &impacts, &impact_count, &error));
    THAT(impact_count > 0);
    for (size_t i = 0; i < impact_count; i++) {
        THAT(0 < impacts[i].from && impacts[i].from <= impacts[i].to && impacts[i].pair.b < TRIANGLES);
    }
    pfront_impact_t impact;
    OK(pfront_model_query_first_impact(query, &still, &flight, 0, &impact, &found, &error));
    THAT(found == 1 && impact.from <= impacts[0].from);
    OK(pfront_model_query_any_impact(query, &still, &flight, 0, &impact, &found, &error));
    THAT(found == 1 && impact.to < INFINITY);
    size_t proven = 0, same = 0;
    for (size_t i = 0; i < impact_count; i++) {
        same += memcmp(&impacts[i], &impact, sizeof impact) == 0;
        proven += impacts[i].to < INFINITY;
    }
    THAT(same == 1);
    uint64_t low = 0, high = 0;
    OK(pfront_model_query_count_impacts(query, &still, &flight, 0, &low, &high, &error));
    THAT(low == proven && high == impact_count);
    const pfront_motion_t away = {model, NULL, &ahead, NULL}, itself = {model, model, NULL, NULL};
    OK(pfront_model_query_first_impact(query, &still, &away, 0, &impact, &found, &error));
    THAT(found == 0);
    OK(pfront_model_query_any_impact(query, &still, &away, 0, &impact, &found, &error));
    THAT(found == 0);
    OK(pfront_model_query_count_impacts(query, &still, &away, 0, &low, &high, &error));
    THAT(low == 0 && high == 0);
    // What does not meet is within a hundred metres.
    OK(pfront_model_query_within(query, 100, &error));
    OK(pfront_model_query_any_impact(query, &still, &away, 0, &impact, &found, &error));
    THAT(found == 1);
    OK(pfront_model_query_count_impacts(query, &still, &away, 0, &low, &high, &error));
    THAT(low == TRIANGLES * TRIANGLES && high == low);
    OK(pfront_model_query_within(query, 0, &error));
    // At rest, a mesh meets itself where it intersects itself.
    OK(pfront_model_query_impacts(query, &itself, NULL, PFRONT_SHARED_INDEX, &impacts, &impact_count, &error));
    THAT(impact_count == within.count);
    OK(pfront_model_query_count_impacts(query, &itself, NULL, PFRONT_SHARED_INDEX, &low, &high, &error));
    THAT(high == within.count);
    OK(pfront_model_query_any_impact(query, &itself, NULL, PFRONT_SHARED_INDEX, &impact, &found, &error));
    THAT(found == 1);
    EXPECT(PFRONT_NULL, "high", pfront_model_query_count_impacts(query, &itself, NULL, 0, &low, NULL, &error));
    EXPECT(PFRONT_NULL, "impact", pfront_model_query_any_impact(query, &itself, NULL, 0, NULL, &found, &error));
    const pfront_motion_t both = {model, model, NULL, &ahead};
    EXPECT(PFRONT_MOTION, "to", pfront_model_query_impacts(query, &both, NULL, 0, &impacts, &impact_count, &error));
    EXPECT(PFRONT_NULL, "a", pfront_model_query_impacts(query, NULL, NULL, 0, &impacts, &impact_count, &error));
    EXPECT(PFRONT_OUT_OF_RANGE, "rule", pfront_model_query_impacts(query, &still, NULL, 2, &impacts, &impact_count, &error));
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

// Two cubes of two triangles a side, the second half as large; a cube without its last triangle, one without any, and two in one mesh
// that cross.
static void solids(void)
{
    static float big[24], small[24], both[48];
    static uint32_t twice[72];
    static const uint32_t sides[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    const pfront_buffers_t buffers[5] = {{big, 8, 12, sides, 12, PFRONT_INDEX_U32},
                                         {small, 8, 12, sides, 12, PFRONT_INDEX_U32},
                                         {big, 8, 12, sides, 11, PFRONT_INDEX_U32},
                                         {big, 8, 12, sides, 0, PFRONT_INDEX_U32},
                                         {both, 16, 12, twice, 24, PFRONT_INDEX_U32}};
    static const struct {
        float x;
        pfront_relation_t same, smaller;
        double volume;
    } places[] = {{0, PFRONT_RELATION_EQUAL, PFRONT_RELATION_B_IN_A, 1},
                  {0.75f, PFRONT_RELATION_CROSSING, PFRONT_RELATION_CROSSING, 0.25},
                  {1, PFRONT_RELATION_TOUCHING, PFRONT_RELATION_TOUCHING, 0},
                  {1.125f, PFRONT_RELATION_NEAR, PFRONT_RELATION_NEAR, 0},
                  {3, PFRONT_RELATION_APART, PFRONT_RELATION_APART, 0}};
    pfront_model_t *models[5];
    pfront_model_query_t *query;
    pfront_between_t between;
    double low = -1, high = -1;
    for (unsigned i = 0; i < 24; i++) {
        big[i] = (float)(i / 3 >> (2 - i % 3) & 1);
        small[i] = big[i] / 2;
        both[i] = big[i];
        both[24 + i] = big[i] + 0.5f / (float)(1 + i % 3);
    }
    for (unsigned i = 0; i < 72; i++) {
        twice[i] = sides[i % 36] + 8 * (i / 36);
    }
    for (unsigned i = 0; i < 5; i++) {
        OK(pfront_model_create(&buffers[i], &models[i], &error));
    }
    OK(pfront_model_query_create(executor, &query, &error));
    OK(pfront_model_query_within(query, 0.25f, &error));
    for (unsigned i = 0; i < sizeof places / sizeof *places; i++) {
        const pfront_pose_t pose = at(places[i].x);
        const pfront_pose64_t pose64 = {{{1, 0, 0, places[i].x}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        const pfront_subject_t same = {models[0], models[0], &pose, NULL, 0}, smaller = {models[0], models[1], &pose, NULL, 0};
        const pfront_subject_t in_f64 = {models[0], models[0], NULL, &pose64, 0}, larger = {models[1], models[0], &still, NULL, 0};
        OK(pfront_model_query_relation(query, &same, &between, &error));
        THAT(between.relation == places[i].same && between.meets == (places[i].x <= 1));
        THAT((between.pair.a < 12 && between.pair.b < 12) || (between.pair.a == UINT32_MAX && between.relation == PFRONT_RELATION_APART));
        OK(pfront_model_query_relation(query, &smaller, &between, &error));
        THAT(between.relation == places[i].smaller);
        OK(pfront_model_query_relation(query, &in_f64, &between, &error));
        THAT(between.relation == places[i].same);
        OK(pfront_model_query_relation(query, &larger, &between, &error));
        THAT(between.relation == PFRONT_RELATION_A_IN_B);
        OK(pfront_model_query_overlap_volume(query, &same, &low, &high, &error));
        THAT(low <= places[i].volume && places[i].volume <= high && high - low < 1e-12);
    }
    // A side on a side: its area and its outline.
    const pfront_pose_t flush = at(1);
    const pfront_subject_t two = {models[0], models[0], &flush, NULL, 0}, alone = {models[0], NULL, NULL, NULL, 0};
    const pfront_patch_t *patches;
    size_t patch_count = 9;
    OK(pfront_model_query_patches(query, &two, &patches, &patch_count, &error));
    THAT(patch_count == 1 && patches[0].dimension == 2 && patches[0].is_closed == 0 && patches[0].pair_count >= 4 && patches[0].pair.a < 12);
    THAT(patches[0].area[0] <= 1 && 1 <= patches[0].area[1] && patches[0].area[1] - patches[0].area[0] < 1e-12);
    THAT(patches[0].length[0] <= 4 && 4 <= patches[0].length[1] && patches[0].length[1] - patches[0].length[0] < 1e-12);
    EXPECT(PFRONT_NULL, "b", pfront_model_query_patches(query, &alone, &patches, &patch_count, &error));
    EXPECT(PFRONT_NULL, "patches", pfront_model_query_patches(query, &two, NULL, &patch_count, &error));
    // Refused as no solids, by their names, and at the triangle.
    const pfront_subject_t first = {models[2], models[0], &still, NULL, 0}, second = {models[0], models[2], &still, NULL, 0};
    const pfront_subject_t none = {models[0], models[3], &still, NULL, 0}, itself = {models[0], NULL, NULL, NULL, 0};
    const pfront_subject_t fine = {models[0], models[1], &still, NULL, 0}, crossing = {models[0], models[4], &still, NULL, 0};
    EXPECT(PFRONT_OPEN_EDGE, "a", pfront_model_query_relation(query, &first, &between, &error));
    EXPECT(PFRONT_OPEN_EDGE, "b", pfront_model_query_overlap_volume(query, &second, &low, &high, &error));
    THAT(error.index < 11 && error.given < 3);
    EXPECT(PFRONT_NO_VOLUME, "b", pfront_model_query_relation(query, &none, &between, &error));
    EXPECT(PFRONT_MEETS_ITSELF, "b", pfront_model_query_overlap_volume(query, &crossing, &low, &high, &error));
    THAT(error.index < 12 && 12 <= error.given && error.given < 24);
    EXPECT(PFRONT_NULL, "b", pfront_model_query_relation(query, &itself, &between, &error));
    EXPECT(PFRONT_NULL, "b", pfront_model_query_overlap_volume(query, &itself, &low, &high, &error));
    EXPECT(PFRONT_NULL, "between", pfront_model_query_relation(query, &fine, NULL, &error));
    EXPECT(PFRONT_NULL, "high", pfront_model_query_overlap_volume(query, &fine, &low, NULL, &error));
    EXPECT(PFRONT_OVERLAP, "high", pfront_model_query_overlap_volume(query, &fine, &low, &low, &error));
    // The query has the models that it was last asked about, and the rest is undetermined.
    OK(pfront_model_query_relation(query, &crossing, &between, &error));
    THAT(between.relation == PFRONT_RELATION_UNDETERMINED && between.meets == 1);

    // From above, through the middles of two sides, and beside.
    const double above[3] = {0.5, 0.5, 3}, below[3] = {0.5, 0.5, -1}, aside[3] = {9, 0.5, 3}, nowhere[3] = {NAN, 0, 0}, far[3] = {0, 1e38, 0};
    const pfront_segment_hit_t *met;
    pfront_segment_hit_t first_met = {99, 99};
    size_t met_count = 9;
    uint32_t is_met = 9;
    OK(pfront_model_query_segment(query, models[0], above, below, &met, &met_count, &error));
    THAT(met_count == 4);
    for (size_t i = 0; i < met_count; i++) {
        THAT(met[i].at == (sides[3 * met[i].triangle] & sides[3 * met[i].triangle + 1] & sides[3 * met[i].triangle + 2] & 1 ? 0.5 : 0.75));
        THAT(i == 0 || met[i - 1].triangle < met[i].triangle);
    }
    OK(pfront_model_segment_first(models[0], above, below, &first_met, &is_met, &error));
    THAT(is_met == 1 && first_met.at == 0.5);
    OK(pfront_model_segment_first(models[0], above, aside, &first_met, &is_met, &error));
    THAT(is_met == 0 && first_met.at == 0.5);
    OK(pfront_model_query_segment(query, models[0], above, aside, &met, &met_count, &error));
    THAT(met_count == 0);
    EXPECT(PFRONT_NOT_FINITE, "from", pfront_model_query_segment(query, models[0], nowhere, far, &met, &met_count, &error));
    EXPECT(PFRONT_POSITION_RANGE, "to", pfront_model_segment_first(models[0], above, far, &first_met, &is_met, &error));
    EXPECT(PFRONT_NULL, "to", pfront_model_segment_first(models[0], above, NULL, &first_met, &is_met, &error));
    EXPECT(PFRONT_NULL, "model", pfront_model_query_segment(query, NULL, above, below, &met, &met_count, &error));
    EXPECT(PFRONT_NULL, "hits", pfront_model_query_segment(query, models[0], above, below, NULL, &met_count, &error));

    const double in_both[3] = {0.75, 0.5, 0.5};
    const double points[4][3] = {{0.5, 0.5, 0.5}, {0.5, 1, 0.25}, {0.5, 1.0000000001, 0.25}, {NAN, 0, 0}};
    uint32_t locations[4] = {9, 9, 9, 9};
    OK(pfront_model_query_inside(query, models[0], &points[0][0], 3, locations, &error));
    THAT(locations[0] == PFRONT_LOCATION_INSIDE && locations[1] == PFRONT_LOCATION_SURFACE);
    THAT(locations[2] == PFRONT_LOCATION_OUTSIDE && locations[3] == 9);
    // Where two bodies of one mesh cross is inside.
    OK(pfront_model_query_inside(query, models[4], in_both, 1, locations, &error));
    THAT(locations[0] == PFRONT_LOCATION_INSIDE);
    OK(pfront_model_query_inside(query, models[0], NULL, 0, NULL, &error));
    EXPECT(PFRONT_NOT_FINITE, "points", pfront_model_query_inside(query, models[0], &points[0][0], 4, locations, &error));
    THAT(error.index == 3);
    EXPECT(PFRONT_OPEN_EDGE, "model", pfront_model_query_inside(query, models[2], &points[0][0], 3, locations, &error));
    EXPECT(PFRONT_NO_VOLUME, "model", pfront_model_query_inside(query, models[3], &points[0][0], 3, locations, &error));
    EXPECT(PFRONT_NULL, "points", pfront_model_query_inside(query, models[0], NULL, 3, locations, &error));
    EXPECT(PFRONT_NULL, "locations", pfront_model_query_inside(query, models[0], &points[0][0], 3, NULL, &error));
    OK(pfront_model_query_free(query, &error));

    pfront_scene_t *scene;
    const pfront_checked_pair_t *pairs;
    const pfront_refused_body_t *refused;
    size_t count = 9, refused_count = 9;
    uint32_t found = 9;
    uint64_t body[5];
    const float beside[5] = {0, 0.75f, 1.75f, 2.875f, 3.5f};
    OK(pfront_scene_create(executor, &scene, &error));
    OK(pfront_scene_within(scene, 0.25f, &error));
    for (unsigned i = 0; i < 5; i++) {
        const pfront_pose_t pose = at(beside[i]);
        OK(pfront_scene_add(scene, models[i < 4 ? 0 : 2], &pose, &body[i], &error));
    }
    OK(pfront_scene_check(scene, NULL, &pairs, &count, &refused, &refused_count, &error));
    THAT(count == 4 && refused_count == 1 && refused[0].body == body[4]);

    // Along all bodies, and the first of two sides that are flush.
    const double left[3] = {-1, 0.5, 0.25}, right[3] = {7, 0.5, 0.25}, between_two[3] = {1.75, 0.5, 0.25}, in_lid[3] = {3.75, 0.5, 0.25};
    const pfront_scene_segment_hit_t *along;
    pfront_scene_segment_hit_t first_along;
    const pfront_containing_body_t *containing;
    OK(pfront_scene_segment(scene, left, right, &along, &count, &error));
    THAT(count >= 9 && along[0].body == body[0] && along[0].hit.at == 0.125 && along[count - 1].body == body[4]);
    OK(pfront_scene_segment_first(scene, left, right, &first_along, &found, &error));
    THAT(found == 1 && first_along.body == body[0] && first_along.hit.at == 0.125);
    OK(pfront_scene_segment_first(scene, between_two, left, &first_along, &found, &error));
    THAT(found == 1 && first_along.body == body[1] && first_along.hit.at == 0);
    OK(pfront_scene_segment_first(scene, left, left, &first_along, &found, &error));
    THAT(found == 0);
    OK(pfront_scene_inside(scene, between_two, &containing, &count, &error));
    THAT(count == 2 && containing[0].body == body[1] && containing[0].location == PFRONT_LOCATION_SURFACE);
    THAT(containing[1].body == body[2] && containing[1].location == PFRONT_LOCATION_SURFACE && containing[1].status == PFRONT_OK);
    OK(pfront_scene_inside(scene, in_lid, &containing, &count, &error));
    THAT(count == 2 && containing[0].body == body[3] && containing[0].location == PFRONT_LOCATION_INSIDE);
    THAT(containing[1].body == body[4] && containing[1].status == PFRONT_OPEN_EDGE && containing[1].triangle < 11 && containing[1].given < 3);
    EXPECT(PFRONT_NOT_FINITE, "point", pfront_scene_inside(scene, nowhere, &containing, &count, &error));
    EXPECT(PFRONT_POSITION_RANGE, "from", pfront_scene_segment(scene, far, left, &along, &count, &error));
    EXPECT(PFRONT_NOT_FINITE, "to", pfront_scene_segment_first(scene, left, nowhere, &first_along, &found, &error));
    EXPECT(PFRONT_NULL, "hit", pfront_scene_segment_first(scene, left, right, NULL, &found, &error));
    EXPECT(PFRONT_NULL, "bodies", pfront_scene_inside(scene, left, NULL, &count, &error));
    OK(pfront_scene_check(scene, NULL, &pairs, &count, &refused, &refused_count, &error));
    THAT(refused[0].status == PFRONT_OPEN_EDGE && refused[0].triangle < 11 && refused[0].given < 3);
    for (unsigned i = 0; i < 4 && count == 4; i++) {
        static const pfront_relation_t words[] = {PFRONT_RELATION_CROSSING, PFRONT_RELATION_TOUCHING, PFRONT_RELATION_NEAR,
                                                  PFRONT_RELATION_UNDETERMINED};
        THAT(pairs[i].bodies[0] == body[i] && pairs[i].bodies[1] == body[i + 1] && pairs[i].relation == words[i]);
        THAT(pairs[i].is_allowed == (i == 1) && (i >= 2 || pairs[i].meets == 1) && pairs[i].pair.a < 12);
        THAT((i == 0) != (pairs[i].overlap_volume[0] != pairs[i].overlap_volume[0]));
        THAT((i == 2) != (pairs[i].gap[0] != pairs[i].gap[0]));
        THAT(i >= 2 || (0.75f <= pairs[i].place[0] && pairs[i].place[0] <= 1.75f));
    }
    THAT(pairs[0].overlap_volume[0] <= 0.25 && 0.25 <= pairs[0].overlap_volume[1] && pairs[0].overlap_volume[1] < 0.2500001);
    THAT(pairs[1].patches == 0 && pairs[1].area[0] != pairs[1].area[0]);
    THAT(pairs[2].gap[0] <= 0.125 && 0.125 <= pairs[2].gap[1] && pairs[2].gap[1] < 0.1250001);
    // All that is meant is allowed, and what is not there is nothing.
    pfront_allowed_t allowed = {1u << PFRONT_RELATION_NEAR | 1u << PFRONT_RELATION_TOUCHING, 0.2500001, 1};
    OK(pfront_scene_ignore(scene, body[3], body[4], 1, &error));
    OK(pfront_scene_check(scene, &allowed, &pairs, &count, &refused, &refused_count, &error));
    THAT(count == 3 && refused_count == 0 && pairs[0].is_allowed && pairs[1].is_allowed && pairs[2].is_allowed);
    THAT(pairs[1].patches == 1 && pairs[1].dimension == 2 && pairs[1].area[0] <= 1 && 1 <= pairs[1].area[1] && pairs[1].area[1] < 1.000001);
    THAT(pairs[1].length[0] <= 4 && 4 <= pairs[1].length[1] && pairs[2].patches == 0);
    allowed.relations = 1u << PFRONT_RELATION_NEAR;
    allowed.overlap_volume = 0.2;
    OK(pfront_scene_check(scene, &allowed, &pairs, &count, &refused, &refused_count, &error));
    THAT(count == 3 && !pairs[0].is_allowed && !pairs[1].is_allowed && pairs[2].is_allowed);
    allowed.overlap_volume = NAN;
    EXPECT(PFRONT_OUT_OF_RANGE, "overlap_volume", pfront_scene_check(scene, &allowed, &pairs, &count, &refused, &refused_count, &error));
    allowed.relations = 1;
    EXPECT(PFRONT_OUT_OF_RANGE, "relations", pfront_scene_check(scene, &allowed, &pairs, &count, &refused, &refused_count, &error));
    EXPECT(PFRONT_NULL, "pairs", pfront_scene_check(scene, NULL, NULL, &count, &refused, &refused_count, &error));
    EXPECT(PFRONT_NULL, "refused_count", pfront_scene_check(scene, NULL, &pairs, &count, &refused, NULL, &error));
    EXPECT(PFRONT_OVERLAP, "refused_count", pfront_scene_check(scene, NULL, &pairs, &count, &refused, &count, &error));
    EXPECT(PFRONT_NULL, "scene", pfront_scene_check(NULL, NULL, &pairs, &count, &refused, &refused_count, &error));
    OK(pfront_scene_free(scene, &error));
    for (unsigned i = 0; i < 5; i++) {
        OK(pfront_model_free(models[i], &error));
    }
}

// A model whose vertices move is another for queries, and not for the bodies that were made of it before.
static void deforming(void)
{
    static float moved[4 * VERTICES];
    static double wide[3 * VERTICES];
    pfront_model_t *cloth = NULL, *exact = NULL;
    pfront_model_query_t *query = NULL;
    pfront_scene_t *scene = NULL;
    const pfront_pose_t here = at(0);
    const pfront_buffers_t buffers = {wide, VERTICES, 24, corners, TRIANGLES, PFRONT_INDEX_U32};
    uint64_t before = 0, after = 0, count = 0, body = 0;
    for (int i = 0; i < VERTICES; i++) {
        for (int k = 0; k < 3; k++) {
            // Far from where it was, and `stride` has a hole.
            moved[4 * i + k] = points[3 * i + k] + 100;
            wide[3 * i + k] = (double)points[3 * i + k];
        }
    }
    OK(pfront_model_create(&tetrahedra, &cloth, &error));
    OK(pfront_model_create_f64(&buffers, &exact, &error));
    OK(pfront_model_query_create(executor, &query, &error));
    OK(pfront_scene_create(executor, &scene, &error));
    OK(pfront_scene_add(scene, cloth, &here, &body, &error));
    OK(pfront_scene_add(scene, cloth, &here, &body, &error));
    OK(pfront_scene_count(scene, &before, &error));
    const pfront_subject_t two = {model, cloth, &here, NULL, 0}, doubled = {exact, model, &here, NULL, 0};
    OK(pfront_model_query_count(query, &two, &count, &error));
    THAT(count > 0 && before > 0);
    OK(pfront_model_set_positions(cloth, executor, moved, VERTICES, 16, &error));
    OK(pfront_model_query_count(query, &two, &count, &error));
    THAT(count == 0);
    OK(pfront_scene_count(scene, &after, &error));
    THAT(before == after);
    OK(pfront_model_set_positions(cloth, NULL, points, VERTICES, 0, &error));
    OK(pfront_model_query_count(query, &two, &count, &error));
    THAT(count > 0);
    OK(pfront_model_query_count(query, &doubled, &count, &error));
    THAT(count > 0);
    for (int i = 0; i < 3 * VERTICES; i++) {
        wide[i] += 100;
    }
    OK(pfront_model_set_positions_f64(exact, executor, wide, VERTICES, 0, &error));
    OK(pfront_model_query_count(query, &doubled, &count, &error));
    THAT(count == 0);
    EXPECT(PFRONT_VERTEX_COUNT, "positions", pfront_model_set_positions(cloth, NULL, points, VERTICES - 1, 0, &error));
    EXPECT(PFRONT_TOO_SMALL, "stride", pfront_model_set_positions(cloth, NULL, points, VERTICES, 11, &error));
    EXPECT(PFRONT_NULL, "positions", pfront_model_set_positions(cloth, NULL, NULL, VERTICES, 0, &error));
    EXPECT(PFRONT_NULL, "model", pfront_model_set_positions(NULL, NULL, points, VERTICES, 0, &error));
    moved[0] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions", pfront_model_set_positions(cloth, executor, moved, VERTICES, 16, &error));
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_query_free(query, &error));
    OK(pfront_model_free(cloth, &error));
    OK(pfront_model_free(exact, &error));
}

int main(void)
{
    executors();
    models();
    subjects();
    deforming();
    bodies();
    solids();
    forked();
    OK(pfront_executor_free(executor, &error));
    OK(pfront_model_free(model, &error));
    OK(pfront_model_free(doubles, &error));
    return verdict();
}
