// Every question in seven floating-point environments, which flush, round otherwise or trap: the answers are those of the default
// one, and each call restores what it found.

#include "expect.h"

#if defined(__SSE__)
#include <xmmintrin.h>

// The bytes of all answers of one pass.
static unsigned char told[1 << 16];
static size_t told_bytes;

static void tell(const void *from, size_t bytes)
{
    if (told_bytes + bytes <= sizeof told) {
        memcpy(told + told_bytes, from, bytes);
    }
    told_bytes += bytes;
}

// Subnormal, and far from it: where flushing or rounding decides.
#define LEAST 1.4e-45f
static float blades[27] = {0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, LEAST, 1, 1, 0, 1, 1, -LEAST,
                           1, 2, 3, 2, 1, 3, 1, 2, -3};
static uint32_t sides[12] = {0, 1, 2, 3, 6, 7, 4, 6, 7, 5, 6, 7};

static unsigned setting;
static int failed;

// A call in the environment that is tested. Nothing else computes in it.
#define IN(call) \
    do { \
        _mm_setcsr(setting); \
        pfront_status_t status_ = (call); \
        unsigned after_ = _mm_getcsr(); \
        _mm_setcsr(0x1f80); \
        failed |= status_ != PFRONT_OK || (after_ & 0xffc0) != (setting & 0xffc0); \
    } while (0)

static void ask_query(const pfront_query_t *query)
{
    pfront_cursor_t cursor;
    pfront_pair_t page[64], pair = {0, 0};
    pfront_contact_t contacts[64];
    size_t count = 0;
    uint64_t many = 0;
    uint32_t found = 0;
    IN(pfront_cursor_start(query, &cursor, NULL));
    IN(pfront_query_page(query, &cursor, page, 64, &count, NULL));
    tell(page, count * sizeof *page);
    IN(pfront_query_contacts(query, page, count, contacts, NULL));
    tell(contacts, count * sizeof *contacts);
    IN(pfront_cursor_start(query, &cursor, NULL));
    IN(pfront_query_step(query, &cursor, 3, page, 64, &count, NULL));
    tell(page, count * sizeof *page);
    IN(pfront_query_count(query, &many, NULL));
    tell(&many, sizeof many);
    IN(pfront_query_any(query, &pair, &found, NULL));
    tell(&found, sizeof found);
}

static void ask_everything(void)
{
    static pfront_node_t tree[2][8];
    static uint32_t orders[2][4], history[PFRONT_HISTORY_BOUND(9, 4)], blob[512];
    static double wide[27];
    const pfront_bvh_memory_t memory[2] = {{tree[0], 8, orders[0], 4, scratch, sizeof scratch},
                                           {tree[1], 8, orders[1], 4, scratch, sizeof scratch}};
    const float turn[4] = {0, 0, 0.6f, 0.8f}, move[3] = {LEAST, 0.1f, 0};
    const pfront_buffers_t soup = {blades, 9, 12, sides, 4, PFRONT_INDEX_U32};
    const pfront_buffers_t in_doubles = {wide, 9, 24, sides, 4, PFRONT_INDEX_U32};
    const pfront_pose64_t near = {{{1, 0, 0, 1e-300}, {0, 1, 0, 0}, {0, 0, 1, 1e-40}}};
    pfront_mesh_t surface;
    pfront_bvh_t one, other, borrowed;
    pfront_query_t query;
    pfront_pose_t pose, inverse;
    pfront_aabb_t bounds;
    pfront_pair_list_t list;
    pfront_pair_t pair = {0, 0};
    pfront_model_t *model, *doubles, *baked;
    pfront_executor_t *executor;
    pfront_model_query_t *models;
    const pfront_pair_t *pairs;
    const pfront_model_contact_t *of_models;
    pfront_scene_t *scene;
    const pfront_scene_hit_t *hits;
    const pfront_scene_contact_t *contacts;
    const pfront_scene_contact64_t *contacts64;
    pfront_scene_hit_t hit;
    uint64_t bodies[3], many = 0;
    uint32_t found = 0;
    size_t count = 0, bytes = 0;
    float quality = 0;
    told_bytes = 0;
    for (int i = 0; i < 27; i++) {
        wide[i] = (double)blades[i];
    }
    wide[11] = 5e-324;
    IN(pfront_mesh_check(blades, 9, sides, 4, &surface, NULL));
    IN(pfront_bvh_build_morton(&surface, 1, &memory[0], &one, NULL));
    IN(pfront_bvh_build_sah(&surface, 1, &memory[1], &other, NULL));
    IN(pfront_bvh_refit(&other, blades, 9, &quality, NULL));
    IN(pfront_bvh_quality(&one, &quality, NULL));
    tell(&quality, sizeof quality);
    tell(tree[0], one.node_count * sizeof *tree[0]);
    tell(tree[1], other.node_count * sizeof *tree[1]);
    IN(pfront_pose_from_rotation_translation(turn, move, &pose, NULL));
    IN(pfront_pose_inverse(&pose, &inverse, NULL));
    IN(pfront_pose_multiply(&inverse, &pose, &inverse, NULL));
    tell(&pose, sizeof pose);
    tell(&inverse, sizeof inverse);
    IN(pfront_bvh_bounds(&one, &pose, &bounds, NULL));
    tell(&bounds, sizeof bounds);
    IN(pfront_one_rings_link(&surface, history, PFRONT_HISTORY_BOUND(9, 4), scratch, sizeof scratch, NULL));
    IN(pfront_query_self(&one, history, PFRONT_SHARED_INDEX, &query, NULL));
    ask_query(&query);
    IN(pfront_query_pair(&one, &other, &pose, &query, NULL));
    ask_query(&query);
    IN(pfront_query_world(&one, &pose, &other, &still, &query, NULL));
    ask_query(&query);
    IN(pfront_blob_size(&one, &bytes, NULL));
    IN(pfront_blob_write(&one, blob, sizeof blob, NULL));
    IN(pfront_bvh_from_blob(blob, bytes, scratch, sizeof scratch, &borrowed, NULL));
    tell(blob, bytes);
    IN(pfront_all(&soup, &soup, &pose, NULL, &list, NULL));
    tell(list.pairs, list.count * sizeof *list.pairs);
    IN(pfront_pair_list_free(&list, NULL));
    IN(pfront_any(&soup, &soup, &pose, NULL, &pair, &found, NULL));
    tell(&found, sizeof found);
    IN(pfront_model_create(&soup, &model, NULL));
    IN(pfront_model_create_f64(&in_doubles, &doubles, NULL));
    IN(pfront_model_from_blob(blob, bytes, &baked, NULL));
    IN(pfront_executor_create(PFRONT_CPU, 1, &executor, NULL));
    IN(pfront_scene_create(executor, &scene, NULL));
    IN(pfront_model_query_create(executor, &models, NULL));
    {
        const pfront_subject_t subjects[2] = {{model, doubles, &pose, NULL, 0},
                                              {baked, NULL, NULL, NULL, PFRONT_SHARED_INDEX}};
        uint64_t counts[2];
        for (int i = 0; i < 2; i++) {
            IN(pfront_model_query_all(models, &subjects[i], &pairs, &count, NULL));
            tell(pairs, count * sizeof *pairs);
            IN(pfront_model_query_contacts(models, &subjects[i], &of_models, &count, NULL));
            for (size_t j = 0; j < count; j++) {
                tell(&of_models[j].contact, sizeof of_models[j].contact);
            }
        }
        IN(pfront_batch_count(executor, subjects, 2, counts, NULL));
        tell(counts, sizeof counts);
    }
    IN(pfront_model_query_free(models, NULL));
    IN(pfront_executor_free(executor, NULL));
    IN(pfront_scene_add(scene, model, &pose, &bodies[0], NULL));
    IN(pfront_scene_add(scene, doubles, &still, &bodies[1], NULL));
    IN(pfront_scene_add(scene, baked, &still, &bodies[2], NULL));
    IN(pfront_scene_set_pose_f64(scene, bodies[2], &near, NULL));
    IN(pfront_scene_set_pose(scene, bodies[0], &still, NULL));
    IN(pfront_scene_set_positions(scene, bodies[0], blades, 9, 0, NULL));
    IN(pfront_scene_set_positions_f64(scene, bodies[1], wide, 9, 0, NULL));
    IN(pfront_scene_update(scene, &hits, &count, NULL));
    tell(hits, count * sizeof *hits);
    IN(pfront_scene_contacts(scene, &contacts, &count, NULL));
    for (size_t i = 0; i < count; i++) {
        tell(&contacts[i].contact, sizeof contacts[i].contact);
    }
    IN(pfront_scene_contacts_f64(scene, &contacts64, &count, NULL));
    for (size_t i = 0; i < count; i++) {
        tell(contacts64[i].segment, sizeof contacts64[i].segment);
    }
    IN(pfront_scene_any(scene, &hit, &found, NULL));
    IN(pfront_scene_count(scene, &many, NULL));
    tell(&many, sizeof many);
    IN(pfront_scene_free(scene, NULL));
    IN(pfront_model_free(model, NULL));
    IN(pfront_model_free(doubles, NULL));
    IN(pfront_model_free(baked, NULL));
}

int main(void)
{
    // Flush to zero, denormals are zero, both; down, up, towards zero; every exception traps. Exceptions that passed before are
    // flagged in some.
    static const unsigned settings[7] = {0x9f80, 0x1fc0, 0x9fe0, 0x3f80, 0x5f80, 0x7f80, 0x0000};
    static unsigned char expected[sizeof told];
    setting = 0x1f80;
    ask_everything();
    size_t bytes = told_bytes;
    THAT(!failed && bytes > 1000 && bytes <= sizeof told);
    memcpy(expected, told, sizeof told);
    for (int i = 0; i < 7; i++) {
        memset(told, 0, sizeof told);
        setting = settings[i];
        ask_everything();
        THAT(!failed && told_bytes == bytes && memcmp(told, expected, bytes) == 0);
        if (wrong) {
            fprintf(stderr, "in the environment %x\n", setting);
            break;
        }
    }
    return verdict();
}
#else
int main(void)
{
    return verdict();
}
#endif
