// Scenes of many bodies: right uses, and mistakes with their error codes. With WORKERS defined, a scene on threads.

#include "expect.h"

#ifndef WORKERS
#define WORKERS 1
#endif

#define BODIES 3

static const pfront_buffers_t tetrahedra = {points, VERTICES, 12, corners, TRIANGLES, PFRONT_INDEX_U32};

static pfront_pose_t at(float x)
{
    const pfront_pose_t pose = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return pose;
}

// A row of bodies of one model, each in touch with its neighbours.
static pfront_scene_t *row(uint64_t bodies[BODIES])
{
    pfront_scene_t *scene = scene_of(WORKERS);
    pfront_model_t *model;
    OK(pfront_model_create(&tetrahedra, &model, &error));
    for (int i = 0; i < BODIES; i++) {
        const pfront_pose_t pose = at((float)i * 1.5f);
        OK(pfront_scene_add(scene, model, &pose, &bodies[i], &error));
        THAT(i == 0 || bodies[i] > bodies[i - 1]);
    }
    // Its bodies have it still.
    OK(pfront_model_free(model, &error));
    return scene;
}

// Pairs of triangles of two bodies in a list of hits, which is sorted.
static size_t pairs_of(const pfront_scene_hit_t *hits, size_t count, uint64_t a, uint64_t b)
{
    size_t pairs = 0;
    for (size_t i = 0; i < count; i++) {
        THAT(hits[i].bodies[0] <= hits[i].bodies[1]);
        THAT(hits[i].pair.a < TRIANGLES && hits[i].pair.b < TRIANGLES);
        if (i > 0) {
            const pfront_scene_hit_t *x = &hits[i - 1], *y = &hits[i];
            const uint64_t first[4] = {x->bodies[0], x->bodies[1], x->pair.a, x->pair.b};
            const uint64_t second[4] = {y->bodies[0], y->bodies[1], y->pair.a, y->pair.b};
            int k = 0;
            while (k < 3 && first[k] == second[k]) {
                k++;
            }
            THAT(first[k] < second[k]);
        }
        pairs += hits[i].bodies[0] == a && hits[i].bodies[1] == b;
    }
    return pairs;
}

// How many hits the scene has of two bodies.
static size_t meeting(pfront_scene_t *scene, uint64_t a, uint64_t b)
{
    const pfront_scene_hit_t *hits;
    size_t count;
    OK(pfront_scene_update(scene, &hits, &count, &error));
    return pairs_of(hits, count, a, b);
}

static void frames(void)
{
    uint64_t bodies[BODIES], many;
    pfront_scene_t *scene = row(bodies);
    const pfront_scene_hit_t *hits;
    const pfront_scene_contact_t *contacts;
    pfront_scene_hit_t hit;
    uint32_t found;
    size_t count, contact_count;
    OK(pfront_scene_update(scene, &hits, &count, &error));
    size_t first = pairs_of(hits, count, bodies[0], bodies[1]);
    size_t second = pairs_of(hits, count, bodies[1], bodies[2]);
    THAT(first > 0 && second > 0 && count == first + second);
    // Each pair of bodies by a query in the world finds as many.
    const pfront_pose_t here = at(0), there = at(1.5f);
    pfront_query_t query;
    make();
    OK(pfront_query_world(&bvh, &here, &bvh, &there, &query, &error));
    OK(pfront_query_count(&query, &many, &error));
    THAT(many == first);
    OK(pfront_scene_count(scene, &many, &error));
    THAT(many == count);
    OK(pfront_scene_any(scene, &hit, &found, &error));
    THAT(found == 1 && hit.bodies[0] < hit.bodies[1]);
    OK(pfront_scene_contacts(scene, &contacts, &contact_count, &error));
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(contact_count == count);
    for (size_t i = 0; i < count; i++) {
        THAT(memcmp(&contacts[i].hit, &hits[i], sizeof *hits) == 0);
        THAT(contacts[i].contact.kind != PFRONT_APART);
        THAT(contacts[i].contact.segment[0][0] > 1);
    }
    // A body that moves away, and back.
    pfront_pose_t pose = at(100);
    OK(pfront_scene_set_pose(scene, bodies[1], &pose, &error));
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(count == 0);
    OK(pfront_scene_any(scene, &hit, &found, &error));
    THAT(found == 0);
    pose = at(1.5f);
    OK(pfront_scene_set_pose(scene, bodies[1], &pose, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == first);
    // A body that has been removed.
    OK(pfront_scene_remove(scene, bodies[0], &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 0 && meeting(scene, bodies[1], bodies[2]) == second);
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_set_pose(scene, bodies[0], &pose, &error));
    THAT(error.index == bodies[0]);
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_remove(scene, bodies[0], &error));
    OK(pfront_scene_free(scene, &error));
}

static void groups_and_numbers(void)
{
    uint64_t bodies[BODIES], number = 1, many;
    pfront_scene_t *scene = row(bodies);
    size_t first = meeting(scene, bodies[0], bodies[1]);
    OK(pfront_scene_ignore(scene, bodies[1], bodies[0], 1, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 0 && meeting(scene, bodies[1], bodies[2]) > 0);
    OK(pfront_scene_ignore(scene, bodies[0], bodies[1], 0, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == first);
    OK(pfront_scene_set_groups(scene, bodies[0], 1, 2, &error));
    OK(pfront_scene_set_groups(scene, bodies[1], 1, ~0u, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 0 && meeting(scene, bodies[1], bodies[2]) > 0);
    OK(pfront_scene_set_groups(scene, bodies[1], 2, ~0u, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == first);
    OK(pfront_scene_user_data(scene, bodies[2], &number, &error));
    THAT(number == 0);
    OK(pfront_scene_set_user_data(scene, bodies[2], UINT64_MAX - 1, &error));
    OK(pfront_scene_user_data(scene, bodies[2], &number, &error));
    THAT(number == UINT64_MAX - 1);
    OK(pfront_scene_user_data(scene, bodies[1], &number, &error));
    THAT(number == 0);

    pfront_query_t query;
    make();
    OK(pfront_query_self(&bvh, NULL, 0, &query, &error));
    OK(pfront_query_count(&query, &many, &error));
    OK(pfront_scene_ask_itself(scene, bodies[1], 1, &error));
    THAT(meeting(scene, bodies[1], bodies[1]) == many && meeting(scene, bodies[0], bodies[1]) == first);
    THAT(meeting(scene, bodies[0], bodies[0]) == 0);
    OK(pfront_scene_ask_itself(scene, bodies[1], 0, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_ask_itself(scene, 99, 1, &error));

    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_ignore(scene, bodies[0], 99, 1, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_set_groups(scene, 99, 1, 1, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_set_user_data(scene, 99, 1, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_user_data(scene, 99, &number, &error));
    EXPECT(PFRONT_NULL, "user_data", pfront_scene_user_data(scene, bodies[0], NULL, &error));
    OK(pfront_scene_free(scene, &error));
}

static void deformation(void)
{
    uint64_t bodies[BODIES];
    float moved[4 * VERTICES];
    pfront_scene_t *scene = row(bodies);
    size_t first = meeting(scene, bodies[0], bodies[1]), second = meeting(scene, bodies[1], bodies[2]);
    for (int i = 0; i < VERTICES; i++) {
        memcpy(moved + 4 * i, points + 3 * i, 3 * sizeof(float));
        moved[4 * i + 2] += 50;
        moved[4 * i + 3] = NAN;
    }
    // Strided; the others keep the model that they shared.
    OK(pfront_scene_set_positions(scene, bodies[0], moved, VERTICES, 16, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 0 && meeting(scene, bodies[1], bodies[2]) == second);
    OK(pfront_scene_set_positions(scene, bodies[0], points, VERTICES, 0, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == first);

    EXPECT(PFRONT_NOT_FINITE, "positions",
           pfront_scene_set_positions(scene, bodies[0], moved, VERTICES, 12, &error));
    THAT(error.index == 1);
    EXPECT(PFRONT_VERTEX_COUNT, "positions",
           pfront_scene_set_positions(scene, bodies[0], points, VERTICES - 1, 0, &error));
    THAT(error.needed == VERTICES && error.given == VERTICES - 1);
    EXPECT(PFRONT_TOO_SMALL, "stride",
           pfront_scene_set_positions(scene, bodies[0], points, VERTICES, 11, &error));
    EXPECT(PFRONT_NULL, "positions",
           pfront_scene_set_positions(scene, bodies[0], NULL, VERTICES, 0, &error));
    EXPECT(PFRONT_STALE_BODY, "body",
           pfront_scene_set_positions(scene, 99, points, VERTICES, 0, &error));
    // Nothing has changed.
    THAT(meeting(scene, bodies[0], bodies[1]) == first);
    OK(pfront_scene_free(scene, &error));
}

static void blobs(void)
{
    static uint32_t blob[1024];
    uint64_t bodies[2];
    size_t bytes;
    pfront_model_t *model;
    pfront_scene_t *scene;
    make();
    OK(pfront_blob_size(&bvh, &bytes, &error));
    THAT(bytes <= sizeof blob);
    OK(pfront_blob_write(&bvh, blob, sizeof blob, &error));
    OK(pfront_model_from_blob(blob, bytes, &model, &error));
    scene = scene_of(WORKERS);
    OK(pfront_scene_add(scene, model, &still, &bodies[0], &error));
    OK(pfront_scene_add(scene, model, &still, &bodies[1], &error));
    THAT(meeting(scene, bodies[0], bodies[1]) > TRIANGLES);
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_free(model, &error));
    EXPECT(PFRONT_NULL, "blob", pfront_model_from_blob(NULL, bytes, &model, &error));
    EXPECT(PFRONT_NULL, "model", pfront_model_from_blob(blob, bytes, NULL, &error));
    EXPECT(PFRONT_BLOB_LENGTH, "blob", pfront_model_from_blob(blob, bytes - 1, &model, &error));
    blob[20] ^= 1;
    EXPECT(PFRONT_BLOB_CHECKSUM, "blob", pfront_model_from_blob(blob, bytes, &model, &error));
}

// Bodies a nanometre apart or in touch, where floats know half a metre.
static void in_f64(void)
{
    static const double far[3] = {500000.1, 5000000.2, 300.3};
    double exact[3 * VERTICES], strided[4 * VERTICES];
    pfront_pose64_t pose = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const uint16_t square[6] = {0, 1, 2, 0, 2, 3};
    const double floor[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    pfront_buffers_t buffers = {strided, 4, 32, square, 2, PFRONT_INDEX_U16};
    uint64_t bodies[2];
    pfront_model_t *model = NULL;
    pfront_scene_t *scene;
    const pfront_scene_contact64_t *contacts;
    size_t count;
    for (int i = 0; i < 12; i++) {
        exact[i] = far[i % 3] + floor[i];
        strided[i / 3 * 4 + i % 3] = exact[i];
        strided[i / 3 * 4 + 3] = NAN;
    }
    OK(pfront_model_create_f64(&buffers, &model, &error));
    scene = scene_of(WORKERS);
    for (int i = 0; i < 2; i++) {
        OK(pfront_scene_add(scene, model, &still, &bodies[i], &error));
    }
    THAT(meeting(scene, bodies[0], bodies[1]) == 4);
    // A nanometre apart, which doubles of 300 metres tell.
    pose.rows[2][3] = 1e-9;
    OK(pfront_scene_set_pose_f64(scene, bodies[1], &pose, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 0);
    for (int i = 0; i < 4; i++) {
        exact[3 * i + 2] += 1e-9;
    }
    OK(pfront_scene_set_positions_f64(scene, bodies[0], exact, 4, 0, &error));
    THAT(meeting(scene, bodies[0], bodies[1]) == 4);
    OK(pfront_scene_contacts_f64(scene, &contacts, &count, &error));
    THAT(count == 4);
    for (size_t i = 0; i < count; i++) {
        THAT(contacts[i].hit.bodies[0] == bodies[0] && contacts[i].is_flat == 1);
        THAT(contacts[i].segment[0][2] == exact[2] && contacts[i].segment[1][0] >= far[0]);
        THAT(contacts[i].normals[0][2] == 1);
    }
    EXPECT(PFRONT_OTHER_PRECISION, "positions",
           pfront_scene_set_positions(scene, bodies[0], points, 4, 0, &error));
    EXPECT(PFRONT_VERTEX_COUNT, "positions",
           pfront_scene_set_positions_f64(scene, bodies[0], exact, 3, 0, &error));
    EXPECT(PFRONT_TOO_SMALL, "stride",
           pfront_scene_set_positions_f64(scene, bodies[0], exact, 4, 12, &error));
    THAT(error.needed == 24);
    EXPECT(PFRONT_NULL, "positions",
           pfront_scene_set_positions_f64(scene, bodies[0], NULL, 4, 0, &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_set_pose_f64(scene, 99, &pose, &error));
    EXPECT(PFRONT_NULL, "world_from_body",
           pfront_scene_set_pose_f64(scene, bodies[0], NULL, &error));
    EXPECT(PFRONT_NULL, "contacts", pfront_scene_contacts_f64(scene, NULL, &count, &error));
    pose.rows[1][3] = 1e38;
    EXPECT(PFRONT_POSE_RANGE, "world_from_body",
           pfront_scene_set_pose_f64(scene, bodies[0], &pose, &error));
    pose.rows[1][3] = NAN;
    EXPECT(PFRONT_POSE_NOT_FINITE, "world_from_body",
           pfront_scene_set_pose_f64(scene, bodies[0], &pose, &error));
    exact[5] = 1e38;
    EXPECT(PFRONT_POSITION_RANGE, "positions",
           pfront_scene_set_positions_f64(scene, bodies[0], exact, 4, 0, &error));
    THAT(error.index == 1);
    THAT(meeting(scene, bodies[0], bodies[1]) == 4);
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_free(model, &error));
    model = NULL;
    buffers.stride = 12;
    EXPECT(PFRONT_TOO_SMALL, "stride", pfront_model_create_f64(&buffers, &model, &error));
    buffers.stride = 8 * 3;
    buffers.positions = exact;
    EXPECT(PFRONT_POSITION_RANGE, "positions", pfront_model_create_f64(&buffers, &model, &error));
    exact[5] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions", pfront_model_create_f64(&buffers, &model, &error));
    THAT(error.index == 1 && model == NULL);
}

static void mistakes(void)
{
    static uint64_t zeros[1024];
    pfront_scene_t *scene = NULL, *no_scene = (pfront_scene_t *)(void *)zeros;
    pfront_model_t *model = NULL, *no_model = (pfront_model_t *)(void *)zeros;
    pfront_buffers_t buffers = tetrahedra;
    pfront_pose_t pose = still;
    uint64_t body, many;
    const pfront_scene_hit_t *hits;
    const pfront_scene_contact_t *contacts;
    size_t count;
    EXPECT(PFRONT_NULL, "buffers", pfront_model_create(NULL, &model, &error));
    EXPECT(PFRONT_NULL, "model", pfront_model_create(&buffers, NULL, &error));
    buffers.stride = 4;
    EXPECT(PFRONT_TOO_SMALL, "stride", pfront_model_create(&buffers, &model, &error));
    buffers = tetrahedra;
    buffers.index_type = 2;
    EXPECT(PFRONT_OUT_OF_RANGE, "index_type", pfront_model_create(&buffers, &model, &error));
    buffers = tetrahedra;
    buffers.triangles = NULL;
    EXPECT(PFRONT_NULL, "triangles", pfront_model_create(&buffers, &model, &error));
    buffers = tetrahedra;
    buffers.vertex_count = 5;
    EXPECT(PFRONT_NO_SUCH_VERTEX, "triangles", pfront_model_create(&buffers, &model, &error));
    THAT(error.index == 4 && error.needed == 5 && error.given == 6);
    buffers = tetrahedra;
    buffers.vertex_count = SIZE_MAX;
    EXPECT(PFRONT_OUT_OF_MEMORY, "malloc", pfront_model_create(&buffers, &model, &error));
    points[3 * 7 + 1] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions", pfront_model_create(&tetrahedra, &model, &error));
    THAT(error.index == 7);
    points[3 * 7 + 1] = 0.5f;
    THAT(model == NULL);
    OK(pfront_model_create(&tetrahedra, &model, &error));

    EXPECT(PFRONT_NULL, "scene", pfront_scene_create(NULL, NULL, &error));
    THAT(scene == NULL);
    OK(pfront_scene_create(NULL, &scene, &error));
    EXPECT(PFRONT_DISTANCE, "distance", pfront_scene_within(scene, -1, &error));
    OK(pfront_scene_within(scene, 0.5f, &error));
    OK(pfront_scene_within(scene, 0, &error));
    EXPECT(PFRONT_NULL, "scene", pfront_scene_add(NULL, model, &still, &body, &error));
    EXPECT(PFRONT_NULL, "model", pfront_scene_add(scene, NULL, &still, &body, &error));
    EXPECT(PFRONT_NULL, "world_from_body", pfront_scene_add(scene, model, NULL, &body, &error));
    EXPECT(PFRONT_NULL, "body", pfront_scene_add(scene, model, &still, NULL, &error));
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_add(no_scene, model, &still, &body, &error));
    EXPECT(PFRONT_NOT_MADE, "model", pfront_scene_add(scene, no_model, &still, &body, &error));
    pose.rows[0][0] = NAN;
    EXPECT(PFRONT_POSE_NOT_FINITE, "world_from_body",
           pfront_scene_add(scene, model, &pose, &body, &error));
    pose.rows[0][0] = 1e38f;
    EXPECT(PFRONT_POSE_RANGE, "world_from_body",
           pfront_scene_add(scene, model, &pose, &body, &error));
    OK(pfront_scene_add(scene, model, &still, &body, &error));
    EXPECT(PFRONT_POSE_RANGE, "world_from_body", pfront_scene_set_pose(scene, body, &pose, &error));
    EXPECT(PFRONT_NULL, "world_from_body", pfront_scene_set_pose(scene, body, NULL, &error));
    EXPECT(PFRONT_NULL, "hits", pfront_scene_update(scene, NULL, &count, &error));
    EXPECT(PFRONT_NULL, "count", pfront_scene_update(scene, &hits, NULL, &error));
    EXPECT(PFRONT_NULL, "contacts", pfront_scene_contacts(scene, NULL, &count, &error));
    EXPECT(PFRONT_NULL, "scene", pfront_scene_contacts(NULL, &contacts, &count, &error));
    EXPECT(PFRONT_NULL, "count", pfront_scene_count(scene, NULL, &error));
    EXPECT(PFRONT_OVERLAP, "scene", pfront_scene_count(scene, (uint64_t *)(void *)scene, &error));
    OK(pfront_scene_count(scene, &many, &error));
    THAT(many == 0);
    EXPECT(PFRONT_NOT_MADE, "scene", pfront_scene_free(no_scene, &error));
    EXPECT(PFRONT_NOT_MADE, "model", pfront_model_free(no_model, &error));
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_free(model, &error));
    OK(pfront_scene_free(NULL, &error));
    OK(pfront_model_free(NULL, &error));
}

// The first body flies through the others, which no pose at either end shows.
static void impacts(void)
{
    uint64_t bodies[BODIES];
    pfront_scene_t *scene = row(bodies);
    const pfront_body_end_t far_away = {bodies[0], {{{1, 0, 0, 100}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
    const pfront_scene_impact_t *found;
    size_t count;
    OK(pfront_scene_impacts(scene, &far_away, 1, &found, &count, &error));
    const size_t all = count;
    size_t proven = 0, with_last = 0;
    for (size_t i = 0; i < count; i++) {
        THAT(0 <= found[i].from && found[i].from <= found[i].to);
        THAT(found[i].hit.pair.a < TRIANGLES && found[i].hit.pair.b < TRIANGLES);
        proven += found[i].to < INFINITY;
        with_last += found[i].hit.bodies[0] == bodies[0] && found[i].hit.bodies[1] == bodies[2];
    }
    THAT(with_last > 0);
    uint64_t low, high;
    OK(pfront_scene_count_impacts(scene, &far_away, 1, &low, &high, &error));
    THAT(low == proven && high == all);
    pfront_scene_impact_t one;
    uint32_t is_found;
    OK(pfront_scene_first_impact(scene, &far_away, 1, &one, &is_found, &error));
    // It touches the second from the start on.
    THAT(is_found == 1 && one.from == 0 && one.hit.bodies[0] == bodies[0] && one.hit.bodies[1] == bodies[1]);
    OK(pfront_scene_any_impact(scene, &far_away, 1, &one, &is_found, &error));
    THAT(is_found == 1 && one.to < INFINITY);
    // The scene is the same, and nobody has to move.
    const pfront_scene_hit_t *hits;
    OK(pfront_scene_update(scene, &hits, &count, &error));
    const size_t meeting_now = count;
    OK(pfront_scene_impacts(scene, NULL, 0, &found, &count, &error));
    THAT(count == meeting_now && count < all && (count == 0 || found[0].to == 0));
    const pfront_body_end_t twice[2] = {far_away, far_away};
    EXPECT(PFRONT_MOTION, "ends", pfront_scene_impacts(scene, twice, 2, &found, &count, &error));
    THAT(error.index == bodies[0]);
    pfront_body_end_t wrong = far_away;
    wrong.world_from_body.rows[1][3] = NAN;
    EXPECT(PFRONT_POSE_NOT_FINITE, "ends", pfront_scene_impacts(scene, &wrong, 1, &found, &count, &error));
    EXPECT(PFRONT_NULL, "ends", pfront_scene_any_impact(scene, NULL, 1, &one, &is_found, &error));
    EXPECT(PFRONT_NULL, "high", pfront_scene_count_impacts(scene, &far_away, 1, &low, NULL, &error));
    OK(pfront_scene_remove(scene, bodies[0], &error));
    EXPECT(PFRONT_STALE_BODY, "body", pfront_scene_first_impact(scene, &far_away, 1, &one, &is_found, &error));
    OK(pfront_scene_free(scene, &error));
}

int main(void)
{
    impacts();
    frames();
    groups_and_numbers();
    deformation();
    blobs();
    in_f64();
    mistakes();
    return verdict();
}
