// Meshes in vertex and index buffers, and poses from what engines keep: right uses, and mistakes with their error codes.

#include "expect.h"

// A vertex as engines interleave them, larger than a position.
typedef struct {
    float normal[3];
    float position[3];
    unsigned char colour[4];
} vertex_t;

static vertex_t vertices[VERTICES];
static uint16_t shorts[3 * TRIANGLES];
static float memory[3 * VERTICES + 3 * TRIANGLES + 1];

// The buffers of the two tetrahedra, strided and with indices of 16 bits.
static pfront_buffers_t strided(void)
{
    pfront_buffers_t buffers = {vertices[0].position, VERTICES, sizeof(vertex_t), shorts, TRIANGLES,
                                PFRONT_INDEX_U16};
    for (size_t i = 0; i < VERTICES; i++) {
        memset(&vertices[i], 255, sizeof(vertex_t));
        memcpy(vertices[i].position, points + 3 * i, sizeof vertices[i].position);
    }
    for (size_t i = 0; i < 3 * TRIANGLES; i++) {
        shorts[i] = (uint16_t)corners[i];
    }
    return buffers;
}

// The same, packed and with indices of 32 bits.
static pfront_buffers_t packed(void)
{
    pfront_buffers_t buffers = {points, VERTICES, 0, corners, TRIANGLES, PFRONT_INDEX_U32};
    return buffers;
}

// Whether a mesh is made of some buffers, takes so much memory, and is that of expect.h.
static void makes(pfront_buffers_t buffers, size_t expected)
{
    pfront_mesh_t made;
    size_t bytes = 1;
    OK(pfront_mesh_bytes(&buffers, &bytes, &error));
    THAT(bytes == expected);
    OK(pfront_mesh_from_buffers(&buffers, bytes ? memory : NULL, bytes, &made, &error));
    THAT(made.vertex_count == VERTICES && made.triangle_count == TRIANGLES);
    THAT(memcmp(made.positions, points, sizeof points) == 0);
    THAT(memcmp(made.triangles, corners, sizeof corners) == 0);
    if (bytes > 0) {
        // One byte less does not do.
        EXPECT(PFRONT_TOO_SMALL, "memory",
               pfront_mesh_from_buffers(&buffers, memory, bytes - 1, &made, &error));
        THAT(error.needed == bytes && error.given == bytes - 1);
        EXPECT(PFRONT_NULL, "memory", pfront_mesh_from_buffers(&buffers, NULL, bytes, &made, &error));
    }
}

static void layouts(void)
{
    pfront_buffers_t buffers = packed();
    pfront_mesh_t made;
    makes(buffers, 0);
    OK(pfront_mesh_from_buffers(&buffers, NULL, 0, &made, &error));
    THAT(made.positions == points && made.triangles == corners);
    buffers.stride = 12;
    makes(buffers, 0);
    buffers.triangles = strided().triangles;
    buffers.index_type = PFRONT_INDEX_U16;
    makes(buffers, 12 * TRIANGLES + 3);
    makes(strided(), 12 * (VERTICES + TRIANGLES) + 3);
    buffers = strided();
    buffers.triangles = corners;
    buffers.index_type = PFRONT_INDEX_U32;
    makes(buffers, 12 * VERTICES + 3);
    // At odd addresses, of a stride that is no multiple of 4, into odd memory; nothing behind the last one is read.
    unsigned char odd[13 * VERTICES + 6 * TRIANGLES];
    buffers = strided();
    for (size_t i = 0; i < VERTICES; i++) {
        memcpy(odd + 1 + 13 * i, points + 3 * i, 12);
    }
    memcpy(odd + 13 * VERTICES, shorts, sizeof shorts);
    buffers.positions = odd + 1;
    buffers.stride = 13;
    buffers.triangles = odd + 13 * VERTICES;
    makes(buffers, 12 * (VERTICES + TRIANGLES) + 3);
    OK(pfront_mesh_from_buffers(&buffers, (char *)memory + 1, sizeof memory - 1, &made, &error));
    THAT(memcmp(made.positions, points, sizeof points) == 0);
    // Packed ones are borrowed, so they must be aligned.
    buffers.stride = 12;
    EXPECT(PFRONT_MISALIGNED, "positions",
           pfront_mesh_from_buffers(&buffers, memory, sizeof memory, &made, &error));
    // No vertex and no triangle.
    memset(&buffers, 0, sizeof buffers);
    buffers.stride = 16;
    buffers.index_type = PFRONT_INDEX_U16;
    OK(pfront_mesh_from_buffers(&buffers, NULL, 0, &made, &error));
    THAT(made.vertex_count == 0 && made.triangle_count == 0);
}

static void mistakes(void)
{
    pfront_buffers_t buffers = strided();
    pfront_mesh_t made;
    size_t bytes, size = sizeof memory;
    EXPECT(PFRONT_NULL, "buffers", pfront_mesh_bytes(NULL, &bytes, &error));
    EXPECT(PFRONT_NULL, "mesh_bytes", pfront_mesh_bytes(&buffers, NULL, &error));
    EXPECT(PFRONT_NULL, "buffers", pfront_mesh_from_buffers(NULL, memory, size, &made, &error));
    EXPECT(PFRONT_NULL, "mesh", pfront_mesh_from_buffers(&buffers, memory, size, NULL, &error));
    buffers.stride = 11;
    EXPECT(PFRONT_TOO_SMALL, "stride", pfront_mesh_bytes(&buffers, &bytes, &error));
    THAT(error.needed == 12 && error.given == 11);
    EXPECT(PFRONT_TOO_SMALL, "stride", pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    buffers.index_type = 2;
    EXPECT(PFRONT_OUT_OF_RANGE, "index_type",
           pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    buffers.vertex_count = SIZE_MAX / 2;
    EXPECT(PFRONT_TOO_LONG, "positions", pfront_mesh_bytes(&buffers, &bytes, &error));
    buffers = strided();
    buffers.triangle_count = SIZE_MAX / 2;
    EXPECT(PFRONT_TOO_LONG, "triangles", pfront_mesh_bytes(&buffers, &bytes, &error));
    buffers = strided();
    buffers.stride = SIZE_MAX / 2;
    EXPECT(PFRONT_TOO_LONG, "positions",
           pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    buffers.positions = NULL;
    EXPECT(PFRONT_NULL, "positions", pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    buffers.triangles = NULL;
    EXPECT(PFRONT_NULL, "triangles", pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    buffers.positions = memory + 1;
    EXPECT(PFRONT_OVERLAP, "positions",
           pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    buffers = strided();
    vertices[6].position[2] = NAN;
    EXPECT(PFRONT_NOT_FINITE, "positions",
           pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    THAT(error.index == 6);
    buffers = strided();
    shorts[3 * 5 + 1] = 65535;
    EXPECT(PFRONT_NO_SUCH_VERTEX, "triangles",
           pfront_mesh_from_buffers(&buffers, memory, size, &made, &error));
    THAT(error.index == 5 && error.given == 65535 && error.needed == VERTICES);
}

static int same(const pfront_pose_t *one, const pfront_pose_t *other)
{
    return memcmp(one, other, sizeof *one) == 0;
}

static void poses(void)
{
    const float columns[16] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, NAN};
    // A quarter turn about z.
    const float rotation[4] = {0, 0, 0.70710678f, 0.70710678f}, translation[3] = {5, 6, 7};
    const pfront_pose_t rows = {{{0, -1, 0, 5}, {1, 0, 0, 6}, {0, 0, 1, 7}}};
    const pfront_pose_t flat = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}}};
    pfront_pose_t pose, inverse, product;
    OK(pfront_pose_from_cols_array(columns, &pose, &error));
    THAT(same(&pose, &rows));
    OK(pfront_pose_from_rotation_translation(rotation, translation, &pose, &error));
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 4; k++) {
            THAT(fabsf(pose.rows[i][k] - rows.rows[i][k]) < 1e-6f);
        }
    }
    OK(pfront_pose_inverse(&rows, &inverse, &error));
    OK(pfront_pose_multiply(&inverse, &rows, &product, &error));
    THAT(same(&product, &still));
    THAT(inverse.rows[0][3] == -6 && inverse.rows[1][3] == 5 && inverse.rows[2][3] == -7);
    // In place; the pose on the right comes first.
    pose = rows;
    OK(pfront_pose_inverse(&pose, &pose, &error));
    THAT(same(&pose, &inverse));
    pose = rows;
    OK(pfront_pose_multiply(&pose, &pose, &pose, &error));
    THAT(pose.rows[0][3] == -1 && pose.rows[1][3] == 11 && pose.rows[2][3] == 14);

    EXPECT(PFRONT_NULL, "matrix", pfront_pose_from_cols_array(NULL, &pose, &error));
    EXPECT(PFRONT_NULL, "pose", pfront_pose_from_cols_array(columns, NULL, &error));
    EXPECT(PFRONT_NULL, "rotation",
           pfront_pose_from_rotation_translation(NULL, translation, &pose, &error));
    EXPECT(PFRONT_NULL, "translation",
           pfront_pose_from_rotation_translation(rotation, NULL, &pose, &error));
    EXPECT(PFRONT_NULL, "pose",
           pfront_pose_from_rotation_translation(rotation, translation, NULL, &error));
    EXPECT(PFRONT_NULL, "pose", pfront_pose_inverse(NULL, &pose, &error));
    EXPECT(PFRONT_NULL, "inverse", pfront_pose_inverse(&rows, NULL, &error));
    EXPECT(PFRONT_NULL, "a_from_b", pfront_pose_multiply(NULL, &rows, &pose, &error));
    EXPECT(PFRONT_NULL, "b_from_c", pfront_pose_multiply(&rows, NULL, &pose, &error));
    EXPECT(PFRONT_NULL, "a_from_c", pfront_pose_multiply(&rows, &rows, NULL, &error));
    pose = rows;
    EXPECT(PFRONT_NO_INVERSE, "pose", pfront_pose_inverse(&flat, &pose, &error));
    THAT(same(&pose, &rows));
}

// A quaternion is a rotation if it is of length 1, but for what rounding and drift do to it.
static void quaternions(void)
{
    static const float none[][4] = {{0, 0, 0, 0},      {0, 0, 0, 2},       {0, 0, 0, NAN},       {NAN, 0, 0, 1},
                                    {INFINITY, 0, 0, 1}, {1e-40f, 0, 0, 0}, {0, 0, 0, 1.001f},    {0, 0, 0, 0.999f},
                                    {1e30f, 0, 0, 1},  {0.5f, 0.5f, 0, 0}, {0, 0, -INFINITY, 0}};
    static const float some[][4] = {{0, 0, 0, 1}, {0, 0, 0, -1}, {0.6f, 0, 0, 0.8f}, {0, 0, 1e-40f, 1},
                                    {0, 0, 0, 1.0004f}, {0.5f, -0.5f, 0.5f, 0.4999f}};
    static const float translation[3] = {1, 2, 3};
    pfront_pose_t pose = still;
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        EXPECT(PFRONT_NOT_UNIT, "rotation",
               pfront_pose_from_rotation_translation(none[i], translation, &pose, &error));
        THAT(memcmp(&pose, &still, sizeof pose) == 0);
    }
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        OK(pfront_pose_from_rotation_translation(some[i], translation, &pose, &error));
        THAT(pose.rows[0][3] == 1);
    }
}

int main(void)
{
    quaternions();
    layouts();
    mistakes();
    poses();
    return verdict();
}
