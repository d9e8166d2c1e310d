// What the programs of mistakes have in common: two tetrahedra, and how to expect an error code.

#ifndef EXPECT_H
#define EXPECT_H

#include "pfront.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int wrong = 0;

// Whether a call returns a code, and names the parameter at fault.
static void expect(int line, pfront_status_t status, pfront_status_t expected, const char *what,
                   const pfront_error_t *error)
{
    const char *named = error->what ? error->what : "";
    if (status != expected || error->status != expected || strcmp(named, what) != 0) {
        fprintf(stderr, "line %d: %s: %s; and not %s: %s\n", line, named, pfront_error_text(status),
                what, pfront_error_text(expected));
        wrong = 1;
    }
}

static void expect_that(int line, int holds)
{
    if (!holds) {
        fprintf(stderr, "line %d: not so\n", line);
        wrong = 1;
    }
}

#define THAT(condition) expect_that(__LINE__, condition)
#define EXPECT(code, named, ...) expect(__LINE__, __VA_ARGS__, code, named, &error)
#define OK(...) expect(__LINE__, __VA_ARGS__, PFRONT_OK, "", &error)

// Two tetrahedra, one with a corner inside the other.
#define VERTICES 8
#define TRIANGLES 8
static float points[3 * VERTICES] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,
                                     .1f, .1f, .1f, 2, 0, 0.5f, 0, 2, 0.5f, .5f, .5f, 2};
static uint32_t corners[3 * TRIANGLES] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3,
                                          4, 6, 5, 4, 5, 7, 4, 7, 6, 5, 6, 7};

static pfront_error_t error;
static pfront_mesh_t mesh;
static pfront_node_t nodes[2 * TRIANGLES];
static uint32_t order[TRIANGLES];
static unsigned char scratch[1024];
static pfront_bvh_t bvh;
static const pfront_pose_t still = PFRONT_POSE_IDENTITY;

// Makes the mesh and its BVH.
static inline void make(void)
{
    const pfront_bvh_memory_t memory = {nodes, 2 * TRIANGLES, order, TRIANGLES, scratch, sizeof scratch};
    OK(pfront_mesh_check(points, 8, corners, 8, &mesh, &error));
    OK(pfront_bvh_build_sah(&mesh, 1, &memory, &bvh, &error));
}

// A scene on so many workers. It keeps what it needs of its executor.
static inline pfront_scene_t *scene_of(uint32_t workers)
{
    pfront_executor_t *executor = NULL;
    pfront_scene_t *scene = NULL;
    OK(pfront_executor_create(PFRONT_CPU, workers, &executor, &error));
    OK(pfront_scene_create(executor, &scene, &error));
    OK(pfront_executor_free(executor, &error));
    return scene;
}

// How a program ends.
static inline int verdict(void)
{
    if (!wrong) {
        puts("each mistake got its code");
    }
    return wrong;
}

#endif
