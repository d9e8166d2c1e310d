// Two threads that ask about shared models, each with its own cursor and pages: first both the same, then each its part
// of a front. .ci/capi runs it under the thread sanitizer; with RACE defined it does what the header forbids, for the
// sanitizer to show that it would see it.

#include "scene.h"

#include <pthread.h>

#define THREADS 2
#define FRONT 400

typedef struct {
    const pfront_query_t *query;
    const pfront_front_t *front;
    model_t *model;
    uint32_t number;
    list_t list;
} task_t;

// Closed until all threads are there, so that none is done before another begins.
static pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;

static void pass_gate(void)
{
    pthread_mutex_lock(&gate);
    pthread_mutex_unlock(&gate);
}

// Asks the whole question.
static void *ask(void *argument)
{
    task_t *task = argument;
    pass_gate();
#ifdef RACE
    const pfront_mesh_t mesh = task->query->b.mesh;
    pfront_bvh_refit(&task->model->bvh, mesh.positions, mesh.vertex_count, NULL, NULL);
#endif
    in_pages(task->query, &task->list);
    return NULL;
}

// Does one worker's part.
static void *do_part(void *argument)
{
    task_t *task = argument;
    pass_gate();
    task->list.count = 0;
    work(task->query, task->front, task->number, &task->list);
    return NULL;
}

static void on_threads(void *(*run)(void *), task_t tasks[THREADS])
{
    pthread_t threads[THREADS];
    pthread_mutex_lock(&gate);
    for (int i = 0; i < THREADS; i++) {
        if (pthread_create(&threads[i], NULL, run, &tasks[i]) != 0) {
            fprintf(stderr, "no more threads\n");
            exit(2);
        }
    }
    pthread_mutex_unlock(&gate);
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
    }
}

int main(void)
{
    grid_t a = new_grid(40, 24, 1), b = new_grid(40, 24, 1);
    ring(&a, 0.0f);
    ring(&b, 0.3f);
    model_t model_a = new_model(&a), model_b = new_model(&b);

    pfront_error_t error;
    pfront_front_t front;
    pfront_front_node_t *nodes = memory(FRONT * sizeof *nodes);
    pfront_front_node_t *history = memory(FRONT * sizeof *history);
    check(pfront_front_init(&front, nodes, FRONT, history, FRONT, &error), &error);

    pfront_query_t query;
    task_t tasks[THREADS];
    for (uint32_t i = 0; i < THREADS; i++) {
        task_t task = {&query, &front, &model_b, i, {NULL, 0, 0}};
        tasks[i] = task;
    }
    list_t all = {NULL, 0, 0};
    int wrong = 0;
    for (unsigned frame = 0; frame < FRAMES; frame++) {
        pfront_pose_t a_from_b = pose(frame);
        check(pfront_query_pair(&model_a.bvh, &model_b.bvh, &a_from_b, &query, &error),
              &error);
        on_threads(ask, tasks);
        uint32_t hash = fingerprint(&tasks[0].list);
        size_t meeting = tasks[0].list.count;
        for (int i = 1; i < THREADS; i++) {
            wrong |= fingerprint(&tasks[i].list) != hash;
        }

        pfront_part_t parts[THREADS];
        check(pfront_front_divide(&front, &query, 1, parts, THREADS, &error), &error);
        on_threads(do_part, tasks);
        check(pfront_front_remember(&front, &error), &error);
        all.count = 0;
        printf("frame %u: %zu pairs, list %08x; workers:", frame, meeting, (unsigned)hash);
        for (int i = 0; i < THREADS; i++) {
            append(&all, tasks[i].list.pairs, tasks[i].list.count);
            printf(" %zu", tasks[i].list.count);
        }
        printf("\n");
        wrong |= fingerprint(&all) != hash;
    }
    if (wrong) {
        fprintf(stderr, "threads found different pairs\n");
    }

    for (int i = 0; i < THREADS; i++) {
        free(tasks[i].list.pairs);
    }
    free(all.pairs);
    free(nodes);
    free(history);
    free_model(&model_a);
    free_model(&model_b);
    free_grid(&a);
    free_grid(&b);
    return wrong;
}
