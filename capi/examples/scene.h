// What the examples have in common: meshes that are the same to the bit on every machine, lists of pairs, and how
// to fill these.
// examples/reference.rs makes the same in Rust.

#ifndef SCENE_H
#define SCENE_H

#include "pfront.h"

#include <stdio.h>
#include <stdlib.h>

#define FRAMES 8
#define PAGE 64

// Ends the program where a call has failed, and says why.
static inline void check(pfront_status_t status, const pfront_error_t *error)
{
    if (status != PFRONT_OK) {
        fprintf(stderr, "%s: %s (index %zu, needed %zu, given %zu)\n",
                error->what ? error->what : "pfront", pfront_error_text(status), error->index,
                error->needed, error->given);
        exit(2);
    }
}

static inline void *memory(size_t bytes)
{
    void *got = malloc(bytes ? bytes : 1);
    if (!got) {
        fprintf(stderr, "out of memory\n");
        exit(2);
    }
    return got;
}

// The point a share of the way around the unit circle, in four rational arcs.
static inline void on_circle(unsigned step, unsigned of, float at[2])
{
    unsigned quarter = 4 * (step % of) / of;
    float t = (float)(4 * (step % of) % of) / (float)of;
    float x = (1.0f - t * t) / (1.0f + t * t), y = 2.0f * t / (1.0f + t * t);
    at[0] = quarter == 0 ? x : quarter == 1 ? -y : quarter == 2 ? -x : y;
    at[1] = quarter == 0 ? y : quarter == 1 ? x : quarter == 2 ? -y : -x;
}

// A grid of (columns) x (rows) vertices, closed both ways into a torus or open like a sheet.
typedef struct {
    unsigned columns, rows;
    size_t vertices, triangles;
    float *positions;
    uint32_t *indices;
} grid_t;

static inline grid_t new_grid(unsigned columns, unsigned rows, int closed)
{
    unsigned wide = closed ? columns : columns - 1, high = closed ? rows : rows - 1;
    grid_t grid = {columns, rows, (size_t)columns * rows, (size_t)2 * wide * high, NULL, NULL};
    grid.positions = memory(grid.vertices * 3 * sizeof(float));
    grid.indices = memory(grid.triangles * 3 * sizeof(uint32_t));
    uint32_t *out = grid.indices;
    for (unsigned i = 0; i < wide; i++) {
        for (unsigned j = 0; j < high; j++) {
            unsigned p = i * rows + j, q = i * rows + (j + 1) % rows;
            unsigned r = (i + 1) % columns * rows + j, s = (i + 1) % columns * rows + (j + 1) % rows;
            const uint32_t corners[6] = {p, r, s, p, s, q};
            for (int k = 0; k < 6; k++) {
                *out++ = corners[k];
            }
        }
    }
    return grid;
}

static inline void free_grid(grid_t *grid)
{
    free(grid->positions);
    free(grid->indices);
}

// A torus whose tube swells and shrinks five times around.
static inline void ring(grid_t *grid, float bump)
{
    float *out = grid->positions;
    for (unsigned i = 0; i < grid->columns; i++) {
        for (unsigned j = 0; j < grid->rows; j++) {
            float around[2], across[2], beads[2];
            on_circle(i, grid->columns, around);
            on_circle(j, grid->rows, across);
            on_circle(5 * i, grid->columns, beads);
            float tube = 0.4f + bump * beads[0];
            float from_axis = 1.0f + tube * across[0];
            *out++ = around[0] * from_axis;
            *out++ = around[1] * from_axis;
            *out++ = tube * across[1];
        }
    }
}

// A sheet that rolls up, more with each frame, until it goes through itself.
static inline void roll(grid_t *grid, unsigned frame)
{
    float *out = grid->positions;
    for (unsigned i = 0; i < grid->columns; i++) {
        for (unsigned j = 0; j < grid->rows; j++) {
            float around[2], waves[2];
            on_circle(i * (frame + 1), 4 * grid->columns, around);
            on_circle(3 * i + j, grid->columns, waves);
            float radius = 1.0f + 0.02f * waves[0];
            *out++ = around[0] * radius;
            *out++ = around[1] * radius;
            *out++ = (float)j / (float)grid->rows + 0.1f * (float)frame * waves[1];
        }
    }
}

// How the second ring stands in the frame of the first: it sinks into it, turning.
static inline pfront_pose_t pose(unsigned frame)
{
    float turn[2];
    on_circle(frame, 4 * FRAMES, turn);
    pfront_pose_t pose = {{{turn[0], 0, turn[1], 0.5f},
                           {0, 1, 0, 0.25f},
                           {-turn[1], 0, turn[0], 1.0f - 0.125f * (float)frame}}};
    return pose;
}

// A BVH in memory of its own.
typedef struct {
    pfront_bvh_memory_t memory;
    pfront_bvh_t bvh;
} model_t;

static inline model_t new_model(const grid_t *grid)
{
    size_t triangles = grid->triangles;
    model_t model;
    model.memory.node_capacity = pfront_node_bound(triangles);
    model.memory.nodes = memory(model.memory.node_capacity * sizeof(pfront_node_t));
    model.memory.order_capacity = triangles;
    model.memory.order = memory(triangles * sizeof(uint32_t));
    model.memory.scratch_bytes = pfront_sah_scratch_bytes(triangles);
    model.memory.scratch = memory(model.memory.scratch_bytes);
    pfront_mesh_t mesh;
    pfront_error_t error;
    check(pfront_mesh_check(grid->positions, grid->vertices, grid->indices, triangles, &mesh, &error),
          &error);
    check(pfront_bvh_build_sah(&mesh, 0, &model.memory, &model.bvh, &error), &error);
    return model;
}

static inline void free_model(model_t *model)
{
    free(model->memory.nodes);
    free(model->memory.order);
    free(model->memory.scratch);
}

// All pairs of an answer: the one list that grows as it needs.
typedef struct {
    pfront_pair_t *pairs;
    size_t count, capacity;
} list_t;

static inline void append(list_t *list, const pfront_pair_t *page, size_t count)
{
    if (list->capacity - list->count < count) {
        list->capacity = 2 * (list->count + count);
        list->pairs = realloc(list->pairs, list->capacity * sizeof(pfront_pair_t));
        if (!list->pairs) {
            exit(2);
        }
    }
    for (size_t i = 0; i < count; i++) {
        list->pairs[list->count++] = page[i];
    }
}

static inline int by_a_then_b(const void *first, const void *second)
{
    const pfront_pair_t *x = first, *y = second;
    return x->a != y->a ? (x->a < y->a ? -1 : 1) : x->b != y->b ? (x->b < y->b ? -1 : 1) : 0;
}

// All pairs of a query, page by page.
static inline void in_pages(const pfront_query_t *query, list_t *list)
{
    pfront_cursor_t cursor;
    pfront_pair_t page[PAGE];
    pfront_error_t error;
    size_t count;
    list->count = 0;
    check(pfront_cursor_start(query, &cursor, &error), &error);
    while (!cursor.done) {
        check(pfront_query_page(query, &cursor, page, PAGE, &count, &error), &error);
        append(list, page, count);
    }
}

// Answers the part of a front that one worker has.
static inline void work(const pfront_query_t *queries, const pfront_front_t *front, uint32_t part,
                        list_t *list)
{
    pfront_cursor_t cursor;
    pfront_pair_t page[PAGE];
    pfront_error_t error;
    size_t count;
    for (size_t i = 0; i < front->node_count; i++) {
        pfront_front_node_t *node = &front->nodes[i];
        if (node->part != part) {
            continue;
        }
        const pfront_query_t *query = &queries[node->query];
        check(pfront_cursor_at(query, node->pair, &cursor, &error), &error);
        while (!cursor.done) {
            check(pfront_query_page(query, &cursor, page, PAGE, &count, &error), &error);
            append(list, page, count);
        }
        node->cost = 1.0f + (float)cursor.box_tests
                     + (float)PFRONT_TRIANGLE_COST * (float)cursor.triangle_tests;
    }
}

// Sorts a list, and tells it from others.
static inline uint32_t fingerprint(list_t *list)
{
    if (list->count > 0) {
        qsort(list->pairs, list->count, sizeof(pfront_pair_t), by_a_then_b);
    }
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < list->count; i++) {
        hash = (hash ^ list->pairs[i].a) * 16777619u;
        hash = (hash ^ list->pairs[i].b) * 16777619u;
    }
    return hash;
}

#endif
