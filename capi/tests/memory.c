// An answer that does not fit into memory is an error, and the scene goes on from there. Run by itself, since it takes all memory
// that it lets itself have.

#define _POSIX_C_SOURCE 200809L
#include "expect.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

// So many triangles in one place: each crosses each of the other body, a quarter of a million, in lists of 2 MB and more.
#define MANY 500
// Bytes that there are besides.
#define ROOM (3u << 20)

// The most address space from now on.
static void limit(void)
{
    unsigned long pages = 0;
    struct rlimit limit;
    FILE *statm = fopen("/proc/self/statm", "r");
    THAT(statm && fscanf(statm, "%lu", &pages) == 1);
    fclose(statm);
    limit.rlim_cur = limit.rlim_max = pages * (unsigned long)sysconf(_SC_PAGESIZE) + ROOM;
    THAT(setrlimit(RLIMIT_AS, &limit) == 0);
}

int main(void)
{
    static float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static uint32_t indices[3 * MANY];
    static float through[9] = {.2f, .2f, -1, .2f, .3f, -1, .2f, .2f, 3};
    const pfront_buffers_t buffers = {positions, 3, 12, indices, MANY, PFRONT_INDEX_U32};
    const pfront_buffers_t blades = {through, 3, 12, indices, MANY, PFRONT_INDEX_U32};
    const pfront_pose_t away = {{{1, 0, 0, 100}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    pfront_model_t *model, *blade;
    pfront_scene_t *scene;
    uint64_t bodies[2], many;
    const pfront_scene_hit_t *hits;
    const pfront_scene_contact_t *contacts;
    const pfront_scene_contact64_t *contacts_f64;
    size_t count;
    pfront_pair_list_t list;
    for (int i = 0; i < 3 * MANY; i++) {
        indices[i] = (uint32_t)(i % 3);
    }
    OK(pfront_model_create(&buffers, &model, &error));
    OK(pfront_model_create(&blades, &blade, &error));
    OK(pfront_scene_create(NULL, &scene, &error));
    for (int i = 0; i < 2; i++) {
        OK(pfront_scene_add(scene, i ? blade : model, &still, &bodies[i], &error));
    }
    limit();
    EXPECT(PFRONT_OUT_OF_MEMORY, "malloc", pfront_scene_update(scene, &hits, &count, &error));
    THAT(error.needed > 0);
    EXPECT(PFRONT_OUT_OF_MEMORY, "malloc", pfront_scene_contacts(scene, &contacts, &count, &error));
    EXPECT(PFRONT_OUT_OF_MEMORY, "malloc", pfront_scene_contacts_f64(scene, &contacts_f64, &count, &error));
    EXPECT(PFRONT_OUT_OF_MEMORY, "allocator", pfront_all(&buffers, &blades, &still, NULL, &list, &error));
    OK(pfront_scene_count(scene, &many, &error));
    THAT(many == (uint64_t)MANY * MANY);
    OK(pfront_scene_set_pose(scene, bodies[1], &away, &error));
    OK(pfront_scene_update(scene, &hits, &count, &error));
    THAT(count == 0);
    OK(pfront_scene_free(scene, &error));
    OK(pfront_model_free(model, &error));
    OK(pfront_model_free(blade, &error));
    return verdict();
}
