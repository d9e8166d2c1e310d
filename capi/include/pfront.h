// pfront: every intersecting triangle pair of two meshes, or within one, exactly.
//
// Written by cbindgen from capi/src: do not edit, see capi/tests/header.rs.
//
// Two meshes, once: `pfront_all`; one: `pfront_self`. Many bodies, frame by frame: `pfront_scene_create`. Models, frame by frame
// or many at once, on threads or a GPU: `pfront_model_query_create`, `pfront_batch_count`. Two meshes or one with itself, in
// memory and time that the caller bounds: `pfront_mesh_from_buffers` or `pfront_mesh_check`, `pfront_bvh_build_sah`,
// `pfront_query_pair` or `pfront_query_self`, `pfront_cursor_start`, `pfront_query_page` until the cursor is done.
// capi/README.md and capi/examples/engine.c show how.
//
// All memory is the caller's, but for what `pfront_all`, `pfront_self`, `pfront_any`, models, executors, queries about models, batches and scenes take from an allocator: a function
// frees each. Everywhere else nothing is allocated, kept or locked, and there is nothing to free. There are no globals,
// but for the pool of threads and the driver of a GPU in a library that was built with them.
//
// Structures whose members are told here are plain data with pointers into the caller's arrays: they can be copied, and
// are good as long as these arrays are where they were and nobody else writes them.
//
// Functions that can fail return PFRONT_OK or an error code, and tell more through `error` unless it is null. A null
// pointer, one that is not aligned, arrays that overlap, one that is too small, a structure that was not made, a number
// out of range: each has its code. The contract is what no function can find out: that a pointer which is neither null
// nor misaligned leads to as many elements as is said, or to one structure, that a model, an executor, a query about models, a scene or a list is not used
// after it was freed, that `error` overlaps nothing else, and that during a call no other thread writes what the call
// uses, nor reads what it writes.
//
// Models, executors, queries about models, batches and scenes need the library with Rust's standard library, which it has unless it is built without.
//
// Models, executors, queries about models and scenes: freed by a function each, and PFRONT_NOT_MADE if they are freed again, as far as their memory tells, or are
// copied byte by byte; PFRONT_BUSY if a thread calls a function that takes one not const, or frees one, while another is inside
// a call with it; PFRONT_FORKED for what has threads or a GPU in a child of fork, which may use all else. Arrays that a scene or a query hands
// out are good until the same function is called again. capi/README.md has a table of it.
//
// An answer is about surfaces, not solids: a body wholly inside another has no hit; relations, volumes, checks and points inside alone are about
// solids. It is for one instant, but for impacts.
//
// Any number of threads may use at once whatever a function takes by a pointer to const; but the arrays that a
// pfront_bvh_memory_t names are for one call at a time.
//
// A thread may flush subnormal numbers (-ffast-math) or round in any direction: each function works in the default
// floating-point environment and restores the caller's.

#ifndef PFRONT_H
#define PFRONT_H


#include <stddef.h>
#include <stdint.h>

// The version of this header; `pfront_version` tells that of the library.
#define PFRONT_VERSION_MAJOR 0
#define PFRONT_VERSION_MINOR 1
#define PFRONT_VERSION_PATCH 0
#define PFRONT_VERSION "0.1.0"

// Rebuild a BVH once the quality that a refit returns is above so many times what it was when built.
#define PFRONT_REBUILD_RATIO 1.2

// Words of 8 bytes for all that a walk remembers.
#define PFRONT_CURSOR_WORDS 487

// The cost of a triangle test, in box tests, as measured on x86-64.
#define PFRONT_TRIANGLE_COST 6.5

// The result of a call. All but PFRONT_OK are errors: then no structure was made or changed, and what arrays hold that were
// to be written is anyone's guess.
enum pfront_status_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done.
  PFRONT_OK = 0,
  // `what` is null and must not be.
  PFRONT_NULL = 1,
  // `what` is not at a multiple of `needed` bytes.
  PFRONT_MISALIGNED = 2,
  // `what` has more elements, `given`, than memory can hold; or more than `needed`, the most of a blob.
  PFRONT_TOO_LONG = 3,
  // `what` overlaps something else that is to be written.
  PFRONT_OVERLAP = 4,
  // `what` holds `given` elements, or bytes where it is scratch; `needed` are needed.
  PFRONT_TOO_SMALL = 5,
  // `what` was not filled in by the function that makes it.
  PFRONT_NOT_MADE = 6,
  // `what` is `given`, at `index` if it is an array, and must be below `needed`; or it is 1, which is no node.
  PFRONT_OUT_OF_RANGE = 7,
  // Vertex `index` has a coordinate that is NaN or infinite.
  PFRONT_NOT_FINITE = 8,
  // Triangle `index` names vertex `given`; there are `needed` vertices.
  PFRONT_NO_SUCH_VERTEX = 9,
  // A mesh has `given` triangles, more than the `needed` that are supported.
  PFRONT_TOO_MANY_TRIANGLES = 10,
  // `given` positions, for a mesh of `needed` vertices.
  PFRONT_VERTEX_COUNT = 11,
  // Entry `index` (four to a row) of the pose `what` is NaN or infinite.
  PFRONT_POSE_NOT_FINITE = 12,
  // Row `index` of the pose `what` takes the mesh too far from the origin, beyond 2^125.
  PFRONT_POSE_RANGE = 13,
  // Entry `index` of an order names no triangle, one that was named before, or is in no leaf; or there are `given`
  // entries for `needed` triangles.
  PFRONT_BVH_ORDER = 14,
  // Node `index` names children or triangles that it cannot have, or lies too deep; or there are `given` nodes
  // instead of `needed`.
  PFRONT_BVH_NODE = 15,
  // The box of node `index` is not finite or does not contain what lies below.
  PFRONT_BVH_BOX = 16,
  // The cursor was made for a query of BVHs of other sizes.
  PFRONT_FOREIGN_CURSOR = 17,
  // The arrays of a BVH were damaged since it was built, or there is a fault in pfront. Standard error says more.
  PFRONT_DAMAGED = 18,
  // The BVH borrows a blob, which stays as it is: a copy of its nodes and its order can be adopted and refitted.
  PFRONT_READ_ONLY = 19,
  // The bytes do not begin as a blob does.
  PFRONT_BLOB_MAGIC = 20,
  // Version `given` has written the blob; only `needed` is known.
  PFRONT_BLOB_VERSION = 21,
  // The blob has `needed` bytes; there are `given`.
  PFRONT_BLOB_LENGTH = 22,
  // Byte `index` of the blob is not what its counts and its version determine.
  PFRONT_BLOB_BYTE = 23,
  // The checksum of the blob is `given` and must be `needed`: some byte has changed.
  PFRONT_BLOB_CHECKSUM = 24,
  // Blobs are little-endian, and this machine is not: it can write them, but not borrow.
  PFRONT_BIG_ENDIAN = 25,
  // The calling thread flushes subnormal numbers or does not round to nearest. On x86-64 and AArch64 each function
  // sets what it needs and restores it on return, so this is for other processors only.
  PFRONT_FLOAT_ENVIRONMENT = 26,
  // The pose `what` is flat or not finite, so that it has no inverse.
  PFRONT_NO_INVERSE = 27,
  // The allocator `what` does not have `needed` bytes. Nothing has changed.
  PFRONT_OUT_OF_MEMORY = 28,
  // Body `index` is not in the scene: it was removed, or never added.
  PFRONT_STALE_BODY = 29,
  // Vertex `index` has a coordinate beyond 2^125, the limit in f64.
  PFRONT_POSITION_RANGE = 30,
  // Positions or a blob are in f64 where f32 is taken, or in f32 where f64 is.
  PFRONT_OTHER_PRECISION = 31,
  // The position in f32 of vertex `index` of a blob is not that in f64 minus the origin.
  PFRONT_SHADOW = 32,
  // Another thread is inside a call with `what`, which is for one thread at a time, or is to be freed.
  PFRONT_BUSY = 33,
  // `what` has threads, which a child of fork has not: this process did not make it.
  PFRONT_FORKED = 34,
  // The quaternion `what` is no rotation: the square of its length is not within 1/1024 of 1, or is NaN.
  PFRONT_NOT_UNIT = 35,
  // There is no GPU that can be used, or the library was built without.
  PFRONT_NO_DEVICE = 36,
  // The GPU failed: it is lost or out of memory, has no room for a mesh, or does not compute with a coordinate as large as one of
  // these. Another executor may answer.
  PFRONT_DEVICE = 37,
  // The distance `what` is NaN, infinite or negative.
  PFRONT_DISTANCE = 38,
  // The model `what` is no solid: edge `given` of triangle `index`, from that corner to the next, has an odd number of triangles.
  PFRONT_OPEN_EDGE = 39,
  // Triangles `index` and `given` of the model `what` meet beyond the corners that they share.
  PFRONT_MEETS_ITSELF = 40,
  // The model `what` is no solid: it has no volume.
  PFRONT_NO_VOLUME = 41,
  // Triangle `index` of a model is not the same at the `end` of a motion as at its start; or `what` is a pose of one that deforms; or body `index` has
  // two ends among `ends`.
  PFRONT_MOTION = 42,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_status_t pfront_status_t;
#else
typedef uint32_t pfront_status_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The relation of a solid a to a solid b, by their interiors and their surfaces.
enum pfront_relation_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It hangs on triangles that meet their own mesh, or a body is no solid.
  PFRONT_RELATION_UNDETERMINED = 0,
  // No point in common.
  PFRONT_RELATION_APART = 1,
  // Apart, and at most the distance away that was asked for.
  PFRONT_RELATION_NEAR = 2,
  // The surfaces meet, the interiors do not.
  PFRONT_RELATION_TOUCHING = 3,
  // The interiors meet, and each solid is partly outside of the other.
  PFRONT_RELATION_CROSSING = 4,
  // a is inside b, and not all of b is in a. Their surfaces may meet.
  PFRONT_RELATION_A_IN_B = 5,
  // b is inside a, and not all of a is in b.
  PFRONT_RELATION_B_IN_A = 6,
  // The same solid, whatever its triangles.
  PFRONT_RELATION_EQUAL = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_relation_t pfront_relation_t;
#else
typedef uint32_t pfront_relation_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where a point is, as a solid sees it.
enum pfront_location_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Neither inside nor on the surface.
  PFRONT_LOCATION_OUTSIDE = 0,
  // In the interior.
  PFRONT_LOCATION_INSIDE = 1,
  // On a triangle, also on one that bounds nothing.
  PFRONT_LOCATION_SURFACE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_location_t pfront_location_t;
#else
typedef uint32_t pfront_location_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How an index buffer holds its indices.
enum pfront_index_type_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // 32 bits each.
  PFRONT_INDEX_U32 = 0,
  // 16 bits each.
  PFRONT_INDEX_U16 = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_index_type_t pfront_index_type_t;
#else
typedef uint32_t pfront_index_type_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The rule by which pairs of triangles of one mesh count.
enum pfront_rule_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // All that have more in common than what they share by index: neighbours count when they fold over.
  PFRONT_SHARED_INDEX = 0,
  // Only those without a common vertex index.
  PFRONT_SKIP_NEIGHBOURS = 1,
  // All whose boxes overlap. With each box of a set given as a triangle through two opposite corners, this is the
  // broad phase of the set.
  PFRONT_BOXES_ONLY = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_rule_t pfront_rule_t;
#else
typedef uint32_t pfront_rule_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How two triangles meet.
enum pfront_contact_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // They do not.
  PFRONT_APART = 0,
  // Their planes differ: they meet in a segment, or in a point if its ends are equal.
  PFRONT_CROSSING = 1,
  // They lie in one plane, or one has no area: the segment is the longest chord between corners of the region they
  // share.
  PFRONT_FLAT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_contact_kind_t pfront_contact_kind_t;
#else
typedef uint32_t pfront_contact_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Who answers.
enum pfront_device_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The CPU.
  PFRONT_CPU = 0,
  // The best GPU, always; what no GPU decides, such as bodies in f64, the workers do.
  PFRONT_GPU = 1,
  // The CPU, or the best GPU where that pays.
  PFRONT_AUTO = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pfront_device_t pfront_device_t;
#else
typedef uint32_t pfront_device_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Threads or a GPU that answer. Any number of threads, scenes and queries may use one at once.
typedef struct pfront_executor_t pfront_executor_t;

// A query about models, which remembers from frame to frame. For one thread at a time; another one is refused:
// PFRONT_BUSY.
typedef struct pfront_model_query_t pfront_model_query_t;

// A mesh and its BVH, for the bodies of scenes. Any number of threads and scenes may use one at once.
typedef struct pfront_model_t pfront_model_t;

// Many bodies, which are models in poses. Functions that take a pointer to one that is not const are for one thread at a time.
// Another one is refused: PFRONT_BUSY.
typedef struct pfront_scene_t pfront_scene_t;

// A pose: three rows of a matrix, and in the last column the translation. Meant to be rigid; any finite affine map
// works. `a_from_b` takes the coordinates of b to those of a. A posed coordinate is `((r0*x + r1*y) + r2*z) + t` in
// f32, never fused.
//
// With the poses of two bodies in the world, that of a query is `a_from_b = world_from_a^-1 * world_from_b`:
// `pfront_pose_inverse`, then `pfront_pose_multiply`. Entries may be anything until a query checks them.
typedef struct pfront_pose_t {
  // Row-major.
  float rows[3][4];
} pfront_pose_t;

// Where a call went wrong: see `pfront_status_t` for what the numbers mean. Functions that take a pointer to one
// write it whatever becomes of the call; it may be null.
typedef struct pfront_error_t {
  // The status that the function returned.
  pfront_status_t status;
  // The parameter or member at fault, by name; null where there is none. The string lives for ever.
  const char *what;
  // The vertex, triangle, node, entry or row at fault.
  size_t index;
  // The number that is needed, or the limit.
  size_t needed;
  // The number that was given.
  size_t given;
} pfront_error_t;

// A mesh that was checked: arrays of the caller's, which must stay where they are.
typedef struct pfront_mesh_t {
  // For pfront to know that it has checked it.
  uint32_t seal;
  // x, y, z of each vertex in turn.
  const float *positions;
  // How many vertices: a third of the floats.
  size_t vertex_count;
  // The three vertices of each triangle in turn.
  const uint32_t *triangles;
  // How many triangles: a third of the indices.
  size_t triangle_count;
} pfront_mesh_t;

// A mesh as an engine keeps it: a vertex buffer and an index buffer. Positions that are not packed, and indices of 16
// bits, may lie at any address.
typedef struct pfront_buffers_t {
  // x, y and z of the first vertex, three floats in turn; those of vertex i lie i * `stride` bytes further on.
  const void *positions;
  // How many vertices.
  size_t vertex_count;
  // Bytes from one vertex to the next, at least 12; 0 stands for 12, which is packed.
  size_t stride;
  // The three vertices of each triangle in turn.
  const void *triangles;
  // How many triangles: a third of the indices.
  size_t triangle_count;
  // A `pfront_index_type_t`.
  uint32_t index_type;
} pfront_buffers_t;

// A node of a BVH.
typedef struct pfront_node_t {
  // The smallest corner of its box.
  float min[3];
  // In a leaf, where its triangles begin in the order; else its left child, next to which is the right one.
  uint32_t first;
  // The largest corner of its box.
  float max[3];
  // How many triangles a leaf holds; else 0.
  uint32_t count;
} pfront_node_t;

// Memory for one build at a time, which need not be initialised; or what is to be adopted.
typedef struct pfront_bvh_memory_t {
  // Becomes part of the BVH.
  struct pfront_node_t *nodes;
  // `pfront_node_bound` nodes always are enough.
  size_t node_capacity;
  // Becomes part of the BVH.
  uint32_t *order;
  // One entry a triangle.
  size_t order_capacity;
  // Free again after the build; of any alignment.
  void *scratch;
  // In bytes: `pfront_morton_scratch_bytes` or `pfront_sah_scratch_bytes`.
  size_t scratch_bytes;
} pfront_bvh_memory_t;

// A mesh and its BVH: arrays of the caller's, which must stay where they are. A copy is another view of the same.
typedef struct pfront_bvh_t {
  // For pfront to know that it has made it.
  uint32_t seal;
  // The mesh.
  struct pfront_mesh_t mesh;
  // The nodes: first the root, then an unused one. Read-only if they are in a blob.
  struct pfront_node_t *nodes;
  // How many nodes are in use: more than that can be given back.
  size_t node_count;
  // The triangles, leaf by leaf; one entry a triangle.
  const uint32_t *order;
} pfront_bvh_t;

// A box along the axes.
typedef struct pfront_aabb_t {
  // The smallest corner.
  float min[3];
  // The largest corner.
  float max[3];
} pfront_aabb_t;

// A question about two BVHs, or about one. It holds copies of `pfront_bvh_t`, so make it again after a refit or a
// build, and for each pose. Any number of threads may use it at once.
typedef struct pfront_query_t {
  // For pfront to know that it has made it, and what of.
  uint32_t seal;
  // A `pfront_rule_t`, for one BVH; may be changed.
  uint32_t rule;
  // The first BVH.
  struct pfront_bvh_t a;
  // The second BVH; if there is only one, the same.
  struct pfront_bvh_t b;
  // Where a stands.
  struct pfront_pose_t frame_from_a;
  // Where b stands.
  struct pfront_pose_t frame_from_b;
  // The certified history of one-rings, for one BVH; or null.
  const uint32_t *history;
} pfront_query_t;

// Where a walk stands: what `pfront_query_page` and `pfront_query_step` go on from. A copy is a bookmark. Each thread
// needs its own.
typedef struct pfront_cursor_t {
  // For pfront to know that it has made it.
  uint32_t seal;
  // 1 when nothing is left, else 0. To be read.
  uint32_t done;
  // Box tests so far. To be read.
  uint64_t box_tests;
  // Triangle tests so far. To be read.
  uint64_t triangle_tests;
  // Private.
  uint64_t node_counts[2];
  // Private.
  uint64_t state[PFRONT_CURSOR_WORDS];
} pfront_cursor_t;

// A node of a bounding volume test tree: one node of either BVH, or two of one.
typedef struct pfront_node_pair_t {
  // Node of the first BVH.
  uint32_t a;
  // Node of the second.
  uint32_t b;
} pfront_node_pair_t;

// Two triangles that meet: one of the first mesh and one of the second, or two of one mesh with `a < b`.
typedef struct pfront_pair_t {
  // Triangle of the first mesh.
  uint32_t a;
  // Triangle of the second mesh.
  uint32_t b;
} pfront_pair_t;

// Where two triangles meet, and how they face, in the frame of the query.
typedef struct pfront_contact_t {
  // A `pfront_contact_kind_t`; if it is PFRONT_APART all else is 0.
  uint32_t kind;
  // The ends of the segment in which they meet.
  float segment[2][3];
  // Unit normals of both by the right-hand rule; 0 for a triangle without area.
  float normals[2][3];
} pfront_contact_t;

// A node of a front: a part of a query that one worker answers.
typedef struct pfront_front_node_t {
  // Where its worker begins: for `pfront_cursor_at`.
  struct pfront_node_pair_t pair;
  // Private.
  uint64_t path[2];
  // Its expected cost. The worker puts its true cost in the same place:
  // `1 + box_tests + PFRONT_TRIANGLE_COST * triangle_tests` of the cursor, so that it is above 0.
  float cost;
  // The query it belongs to.
  uint32_t query;
  // The worker it is assigned to.
  uint32_t part;
  // Private.
  uint32_t history;
} pfront_front_node_t;

// The front of a frame and what is remembered of the last one: how the queries of a frame are divided among workers.
typedef struct pfront_front_t {
  // For pfront to know that it has made it.
  uint32_t seal;
  // No node that can be split costs more than 1/g of what a worker gets, where the last frame told what it cost; 8 by
  // default. May be changed.
  double g;
  // The same where costs are estimates; 48 by default. May be changed.
  double g_estimated;
  // The front.
  struct pfront_front_node_t *nodes;
  // A front that is full is coarser, but nothing is lost. It needs at least one node a query; some 150 a worker are
  // plenty.
  size_t node_capacity;
  // How many nodes there are. To be read.
  size_t node_count;
  // The cost history: the nodes of the last front, with what they cost; may be null.
  struct pfront_front_node_t *history;
  // As many as there are nodes; 0 to forget each frame.
  size_t history_capacity;
  // How many are in use; set it to 0 to forget the last frame.
  size_t history_count;
  // 1 if some node is coarser than was asked for. To be read.
  uint32_t full;
  // 1 if what was remembered was of use. To be read.
  uint32_t coherent;
  // Box tests that the front took. To be read.
  uint64_t box_tests;
} pfront_front_t;

// The part of a front that one worker gets.
typedef struct pfront_part_t {
  // Its expected cost in all.
  double cost;
  // The worker, from 0.
  uint32_t number;
} pfront_part_t;

// A pair of functions that a call gets memory by. They are called on the calling thread.
typedef struct pfront_allocator_t {
  // Returns so many bytes, at least 8, at a multiple of 8 bytes; or null if there are not as many.
  void *(*allocate)(void *context, size_t bytes);
  // Takes back what `allocate` has returned for so many bytes.
  void (*release)(void *context, void *memory, size_t bytes);
  // Handed to both; may be null.
  void *context;
} pfront_allocator_t;

// A list of pairs in memory of an allocator, to be freed by `pfront_pair_list_free`.
typedef struct pfront_pair_list_t {
  // For pfront to know that it has made it.
  uint32_t seal;
  // The pairs, sorted by a, then b.
  struct pfront_pair_t *pairs;
  // How many pairs there are.
  size_t count;
  // Private.
  size_t capacity;
  // Private.
  struct pfront_allocator_t allocator;
} pfront_pair_list_t;

// A pose in f64, which the bodies of scenes may have. A posed coordinate is `((r0*x + r1*y) + r2*z) + t` in f64, never
// fused.
typedef struct pfront_pose64_t {
  // Row-major.
  double rows[3][4];
} pfront_pose64_t;

// Two models, the second posed, or one model and itself.
typedef struct pfront_subject_t {
  // The first.
  const struct pfront_model_t *a;
  // The second; null for `a` and itself, which has no pose.
  const struct pfront_model_t *b;
  // The pose of `b`; null if there is none.
  const struct pfront_pose_t *a_from_b;
  // A pose in f64 in place of `a_from_b`, unless it is null; then the answer is that of f64.
  const struct pfront_pose64_t *a_from_b_f64;
  // A `pfront_rule_t` for one model and itself: PFRONT_SHARED_INDEX or PFRONT_SKIP_NEIGHBOURS.
  uint32_t rule;
} pfront_subject_t;

// The smallest distance of two meshes, and where it is.
typedef struct pfront_gap_t {
  // The least that it can be; 0 if triangles intersect.
  double low;
  // The greatest that it can be; 0 if triangles intersect.
  double high;
  // The nearest triangles, or two that intersect.
  struct pfront_pair_t pair;
  // The nearest points of both, rounded.
  double points[2][3];
} pfront_gap_t;

// Two triangles that meet, and where they do, in the frame of the first model.
typedef struct pfront_model_contact_t {
  // The triangles.
  struct pfront_pair_t pair;
  // Where they meet.
  struct pfront_contact_t contact;
} pfront_model_contact_t;

// The answer about two solids.
typedef struct pfront_between_t {
  // The relation of a to b.
  pfront_relation_t relation;
  // 1 if the surfaces meet, as those of nested solids may, else 0.
  uint32_t meets;
  // Triangles that show it, or on which it hangs; UINT32_MAX twice if there are none. They may differ between executors.
  struct pfront_pair_t pair;
} pfront_between_t;

// A connected part of what two surfaces have in common: a point, curves, areas, or what is joined of these.
typedef struct pfront_patch_t {
  // 0 for a point, 1 for curves, 2 if there are areas.
  uint32_t dimension;
  // 1 if it surely has no end, else 0: a curve that comes back to where it began, or areas without an outline.
  uint32_t is_closed;
  // The number of triangle pairs that meet there.
  size_t pair_count;
  // The first of them.
  struct pfront_pair_t pair;
  // The least and the greatest that the length of its curves and of the outlines of its areas can be.
  double length[2];
  // The least and the greatest that its area can be.
  double area[2];
} pfront_patch_t;

// A model that moves from time 0 to time 1, each vertex in a straight line: between two poses in the world, or between the positions of two
// models.
typedef struct pfront_motion_t {
  // The model at time 0.
  const struct pfront_model_t *start;
  // A model of the same triangles at time 1, for one that deforms, which then has no poses; else null.
  const struct pfront_model_t *end;
  // The pose at time 0; null if there is none.
  const struct pfront_pose64_t *from;
  // The pose at time 1; null if it is the first.
  const struct pfront_pose64_t *to;
} pfront_motion_t;

// When two triangles meet first, as far as it is proven.
typedef struct pfront_impact_t {
  // The triangles.
  struct pfront_pair_t pair;
  // They do not meet before this time; 0 is the start of the motion and 1 its end.
  double from;
  // They certainly meet between `from` and this time; INFINITY if that is open, as where they touch and do not pass.
  double to;
} pfront_impact_t;

// A triangle that a segment meets.
typedef struct pfront_segment_hit_t {
  // The triangle.
  uint32_t triangle;
  // The parameter of their first common point, rounded: 0 where the segment starts, 1 where it ends.
  double at;
} pfront_segment_hit_t;

// Two triangles of different bodies that meet.
typedef struct pfront_scene_hit_t {
  // The bodies, the one that was added first before the other.
  uint64_t bodies[2];
  // A triangle of the first body and one of the second.
  struct pfront_pair_t pair;
} pfront_scene_hit_t;

// Two triangles of different bodies that meet, and where they do, in the world.
typedef struct pfront_scene_contact_t {
  // The triangles.
  struct pfront_scene_hit_t hit;
  // Where they meet.
  struct pfront_contact_t contact;
} pfront_scene_contact_t;

// `pfront_scene_contact_t` in f64.
typedef struct pfront_scene_contact64_t {
  // The triangles.
  struct pfront_scene_hit_t hit;
  // Whether they lie in one plane, or one has no area: then the segment is the longest chord between corners of the
  // region they share.
  uint64_t is_flat;
  // The ends of the segment in which they meet.
  double segment[2][3];
  // Unit normals of both by the right-hand rule; 0 for a triangle without area.
  float normals[2][3];
} pfront_scene_contact64_t;

// Where a body goes, each vertex in a straight line.
typedef struct pfront_body_end_t {
  // The body.
  uint64_t body;
  // Its pose at time 1; at time 0 it has that of the scene.
  struct pfront_pose64_t world_from_body;
} pfront_body_end_t;

// When two triangles of bodies meet first, as far as it is proven.
typedef struct pfront_scene_impact_t {
  // The triangles.
  struct pfront_scene_hit_t hit;
  // They do not meet before this time.
  double from;
  // They certainly meet between `from` and this time; INFINITY if that is open, as where they touch and do not pass.
  double to;
} pfront_scene_impact_t;

// A body that was part of another one.
typedef struct pfront_piece_t {
  // The body.
  uint64_t body;
  // The number of its part.
  uint32_t part;
  // How many triangles it has.
  uint32_t triangle_count;
} pfront_piece_t;

// The relations of two bodies that are allowed.
typedef struct pfront_allowed_t {
  // The sum of `1 << relation`, a `pfront_relation_t` each. PFRONT_RELATION_UNDETERMINED never is.
  uint32_t relations;
  // The largest volume by which bodies that cross may overlap; 0 for none.
  double overlap_volume;
  // 1 to measure contacts too, else 0.
  uint32_t with_contacts;
} pfront_allowed_t;

// Two bodies whose boxes overlap. Numbers that were not asked for are NaN.
typedef struct pfront_checked_pair_t {
  // The bodies, that which was added first before the other.
  uint64_t bodies[2];
  // The relation of the first to the second.
  pfront_relation_t relation;
  // 1 if that is allowed, else 0.
  uint32_t is_allowed;
  // 1 if the surfaces meet, else 0.
  uint32_t meets;
  // Triangles that show it, or on which it hangs; UINT32_MAX twice if there are none.
  struct pfront_pair_t pair;
  // The least and the greatest that the common volume of bodies that cross can be, if neither meets itself.
  double overlap_volume[2];
  // The connected patches of what the surfaces have in common, if contacts were asked for; else 0.
  size_t patches;
  // The dimension of these: 0 for points alone, 1 for curves, 2 if there are areas.
  uint32_t dimension;
  // The least and the greatest that the length of their curves and of the outlines of their areas can be.
  double length[2];
  // The least and the greatest that their area can be.
  double area[2];
  // The least and the greatest that the smallest distance of bodies that are near can be.
  double gap[2];
  // A point in the world where the triangles meet.
  double place[3];
} pfront_checked_pair_t;

// A body that is no solid, so that what it is to others is undetermined.
typedef struct pfront_refused_body_t {
  // The body.
  uint64_t body;
  // PFRONT_OPEN_EDGE, PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME.
  pfront_status_t status;
  // The triangle at fault, as `index` of an error; 0 if there is no volume.
  uint32_t triangle;
  // Its open edge or the other triangle, as `given` of an error; 0 if there is no volume.
  uint32_t given;
} pfront_refused_body_t;

// A triangle of a body that a segment meets.
typedef struct pfront_scene_segment_hit_t {
  // The body.
  uint64_t body;
  // The triangle, and where.
  struct pfront_segment_hit_t hit;
} pfront_scene_segment_hit_t;

// A body that contains a point, or whose box does and which is no solid.
typedef struct pfront_containing_body_t {
  // The body.
  uint64_t body;
  // Inside, or on the surface; outside if it is no solid.
  pfront_location_t location;
  // PFRONT_OK, or PFRONT_OPEN_EDGE if it is no solid.
  pfront_status_t status;
  // The triangle at fault, as `index` of an error; 0 if there is none.
  uint32_t triangle;
  // Its open edge, as `given` of an error; 0 if there is none.
  uint32_t given;
} pfront_containing_body_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The meaning of an error code, in a sentence without numbers. Takes any number; the string lives for ever.
const char *pfront_error_text(uint32_t status);

// The version of the library, as in "0.1.0". The string lives for ever.
const char *pfront_version(void);

// Makes a pose from a matrix of 16 floats by columns, as OpenGL, Vulkan, glam and three.js keep it. Its last row, 0 0 0
// 1 of every affine map, is ignored.
pfront_status_t pfront_pose_from_cols_array(const float *matrix,
                                            struct pfront_pose_t *pose,
                                            struct pfront_error_t *error);

// Makes a pose from a rotation, a unit quaternion of 4 floats (x, y, z, w), and a translation of 3 that comes after it. A
// quaternion the square of whose length differs from 1 by more than 1/1024, or is NaN, is PFRONT_NOT_UNIT: normalise it first.
// One within that is taken as it is.
pfront_status_t pfront_pose_from_rotation_translation(const float *rotation,
                                                      const float *translation,
                                                      struct pfront_pose_t *pose,
                                                      struct pfront_error_t *error);

// Makes the pose that takes every point back, computed in f64 and rounded once. `inverse` may be `pose` itself.
pfront_status_t pfront_pose_inverse(const struct pfront_pose_t *pose,
                                    struct pfront_pose_t *inverse,
                                    struct pfront_error_t *error);

// Makes the product `a_from_c = a_from_b * b_from_c`: the pose on the right comes first. Computed in f64 and rounded
// once. `a_from_c` may be one of the others.
pfront_status_t pfront_pose_multiply(const struct pfront_pose_t *a_from_b,
                                     const struct pfront_pose_t *b_from_c,
                                     struct pfront_pose_t *a_from_c,
                                     struct pfront_error_t *error);

// Checks that every coordinate is finite and every index below `vertex_count`, and makes a mesh of it. Duplicate
// triangles, triangles without area, vertices in no triangle and no triangles at all are fine.
//
// Takes time in O(vertices + triangles).
pfront_status_t pfront_mesh_check(const float *positions,
                                  size_t vertex_count,
                                  const uint32_t *triangles,
                                  size_t triangle_count,
                                  struct pfront_mesh_t *mesh,
                                  struct pfront_error_t *error);

// How many bytes of memory `pfront_mesh_from_buffers` needs; 0 if it can borrow both buffers. In O(1).
pfront_status_t pfront_mesh_bytes(const struct pfront_buffers_t *buffers,
                                  size_t *mesh_bytes,
                                  struct pfront_error_t *error);

// Makes a mesh of a vertex buffer and an index buffer and checks it as `pfront_mesh_check` does. Packed positions and
// indices of 32 bits are borrowed, and must stay where they are; anything else is copied into `memory`, of any
// alignment, which takes their place. `pfront_mesh_bytes` tells how large that must be; it may be null if that is 0.
//
// When a mesh deforms, make it again and hand its positions to `pfront_bvh_refit`. In O(vertices + triangles).
pfront_status_t pfront_mesh_from_buffers(const struct pfront_buffers_t *buffers,
                                         void *memory,
                                         size_t memory_bytes,
                                         struct pfront_mesh_t *mesh,
                                         struct pfront_error_t *error);

// How many nodes are enough for a BVH of so many triangles; SIZE_MAX if no mesh has so many. With leaves of 8
// triangles most take a fifth of it.
size_t pfront_node_bound(size_t triangle_count);

// How much scratch `pfront_bvh_build_morton` needs for so many triangles; SIZE_MAX if that cannot be.
size_t pfront_morton_scratch_bytes(size_t triangle_count);

// How much scratch `pfront_bvh_build_sah` needs for so many triangles; SIZE_MAX if that cannot be.
size_t pfront_sah_scratch_bytes(size_t triangle_count);

// How much scratch `pfront_bvh_adopt` and `pfront_bvh_from_blob` need for so many triangles to take one pass over the
// order, and 7 bytes at least; SIZE_MAX if that cannot be.
size_t pfront_adopt_scratch_bytes(size_t triangle_count);

// Builds a BVH along a Morton curve, in O(n) and several times faster than `pfront_bvh_build_sah`, for those who
// rebuild every frame. `leaf_size` is the most triangles that a leaf may hold, 1 to 8, or 0 for the default.
//
// Fewer nodes than `pfront_node_bound` do if the tree has no more; PFRONT_TOO_SMALL then tells how many it has.
pfront_status_t pfront_bvh_build_morton(const struct pfront_mesh_t *mesh,
                                        uint32_t leaf_size,
                                        const struct pfront_bvh_memory_t *memory,
                                        struct pfront_bvh_t *bvh,
                                        struct pfront_error_t *error);

// Builds a BVH by the surface area heuristic, in O(n log n): the tree that queries walk fastest. `leaf_size` is as for
// `pfront_bvh_build_morton`. Takes up to 72 KiB of stack.
pfront_status_t pfront_bvh_build_sah(const struct pfront_mesh_t *mesh,
                                     uint32_t leaf_size,
                                     const struct pfront_bvh_memory_t *memory,
                                     struct pfront_bvh_t *bvh,
                                     struct pfront_error_t *error);

// Makes a BVH of arrays from elsewhere, as from a file, after checking all that a query relies on. The capacities in
// `memory` are how many nodes and entries there are. With less scratch than `pfront_adopt_scratch_bytes`, down to 7
// bytes, the answer is the same and takes more passes over the order. Nothing but scratch is written; nodes and order
// may lie in read-only memory unless the BVH is refitted.
pfront_status_t pfront_bvh_adopt(const struct pfront_mesh_t *mesh,
                                 const struct pfront_bvh_memory_t *memory,
                                 struct pfront_bvh_t *bvh,
                                 struct pfront_error_t *error);

// Fits a BVH to new positions of its mesh, in O(triangles). Its arrays are written; queries and fronts that hold the
// BVH are to be made again, and cursors to be started again.
//
// `positions` take the place of those of the mesh; they may be the same array, changed in place. If one is not finite
// the boxes stay as they were: then give other positions before the next query. `quality`, which may be null, is told
// how good the tree still is, see PFRONT_REBUILD_RATIO. A BVH that borrows a blob is refused.
pfront_status_t pfront_bvh_refit(struct pfront_bvh_t *bvh,
                                 const float *positions,
                                 size_t vertex_count,
                                 float *quality,
                                 struct pfront_error_t *error);

// How many tests a triangle of the mesh is expected to need to find those near it; lower is better. In O(triangles).
pfront_status_t pfront_bvh_quality(const struct pfront_bvh_t *bvh,
                                   float *quality,
                                   struct pfront_error_t *error);

// A box that contains every vertex of every triangle in a pose, rounding included, for a broad phase. The box of an empty
// mesh reaches from infinity to minus infinity. In O(1).
pfront_status_t pfront_bvh_bounds(const struct pfront_bvh_t *bvh,
                                  const struct pfront_pose_t *world_from_bvh,
                                  struct pfront_aabb_t *bounds,
                                  struct pfront_error_t *error);

// How many bytes `pfront_blob_write` writes of a BVH, its mesh included; or how many the blob of a borrowed one has.
pfront_status_t pfront_blob_size(const struct pfront_bvh_t *bvh,
                                 size_t *blob_bytes,
                                 struct pfront_error_t *error);

// Writes a BVH and its mesh as a blob: bytes that are the same on every machine, with a checksum, for a file or for
// flash. `blob` may lie anywhere, and is written as far as `pfront_blob_size` tells. In O(bytes).
pfront_status_t pfront_blob_write(const struct pfront_bvh_t *bvh,
                                  void *blob,
                                  size_t blob_bytes,
                                  struct pfront_error_t *error);

// How much scratch `pfront_bvh_from_blob` needs for a blob to take one pass over its order: by its header, which is all
// that is checked. In O(1).
pfront_status_t pfront_blob_scratch_bytes(const void *blob,
                                          size_t blob_bytes,
                                          size_t *scratch_bytes,
                                          struct pfront_error_t *error);

// Makes a BVH of the blob that `blob_bytes` bytes begin with, where it lies, after checking all that a query relies on:
// the checksum, and since that is no signature, every coordinate, index, box and child. The bytes behind the blob are left
// alone.
//
// `blob` must be at a multiple of 4 bytes, and had better be at one of 64; it is only read, now and by queries, and may
// lie in read-only memory. `pfront_bvh_refit` refuses such a BVH. `scratch` is as for `pfront_bvh_adopt`, of
// `pfront_blob_scratch_bytes` or down to 7 bytes, and free again afterwards. In O(bytes).
pfront_status_t pfront_bvh_from_blob(const void *blob,
                                     size_t blob_bytes,
                                     void *scratch,
                                     size_t scratch_bytes,
                                     struct pfront_bvh_t *bvh,
                                     struct pfront_error_t *error);

// How many words the history of one-rings has; SIZE_MAX if that cannot be.
size_t pfront_history_bound(size_t vertex_count, size_t triangle_count);

// How much scratch `pfront_one_rings_link` needs; SIZE_MAX if that cannot be.
size_t pfront_link_scratch_bytes(size_t vertex_count, size_t triangle_count);

// Finds out how the triangles around each vertex are connected: once for a mesh, whatever its positions will be.
// `history` need not be initialised. `pfront_query_self` uses it for meshes with the same triangles. In
// O(vertices + triangles).
pfront_status_t pfront_one_rings_link(const struct pfront_mesh_t *mesh,
                                      uint32_t *history,
                                      size_t history_count,
                                      void *scratch,
                                      size_t scratch_bytes,
                                      struct pfront_error_t *error);

// Asks which triangles of `a` meet which of `b`, posed by `a_from_b`. The frame is that of a, and so are contacts.
pfront_status_t pfront_query_pair(const struct pfront_bvh_t *a,
                                  const struct pfront_bvh_t *b,
                                  const struct pfront_pose_t *a_from_b,
                                  struct pfront_query_t *query,
                                  struct pfront_error_t *error);

// Asks which triangles of `a` meet which of `b`, both posed into a third frame. The choice of a frame changes how
// vertices are rounded, and so what is found.
pfront_status_t pfront_query_world(const struct pfront_bvh_t *a,
                                   const struct pfront_pose_t *world_from_a,
                                   const struct pfront_bvh_t *b,
                                   const struct pfront_pose_t *world_from_b,
                                   struct pfront_query_t *query,
                                   struct pfront_error_t *error);

// Asks which triangles of one mesh meet each other, each unordered pair once. `history`, which may be null, is that of
// `pfront_one_rings_link` for the same triangles, with `PFRONT_HISTORY_BOUND` words. It changes no answer but makes most
// neighbours cheap: it is certified for the positions of the mesh here, in O(vertices + triangles), and must last as
// long as the query. `rule` is a `pfront_rule_t`.
pfront_status_t pfront_query_self(const struct pfront_bvh_t *bvh,
                                  uint32_t *history,
                                  uint32_t rule,
                                  struct pfront_query_t *query,
                                  struct pfront_error_t *error);

// Sets a cursor before the first triangle pair of a query.
pfront_status_t pfront_cursor_start(const struct pfront_query_t *query,
                                    struct pfront_cursor_t *cursor,
                                    struct pfront_error_t *error);

// Sets a cursor before the first triangle pair below one node of a front: see `pfront_front_divide`.
pfront_status_t pfront_cursor_at(const struct pfront_query_t *query,
                                 struct pfront_node_pair_t node,
                                 struct pfront_cursor_t *cursor,
                                 struct pfront_error_t *error);

// Goes on from a cursor and writes up to `capacity` pairs that meet, of which there is at least room for one. Nothing is
// ever dropped: when `cursor.done` is 1, all pages together are the whole answer. Only the last page may be empty.
//
// The order is fixed for given BVHs, and otherwise arbitrary: sort the whole by a, then b, for a list that does not
// depend on how BVHs were built. Takes up to 29 KiB of stack.
pfront_status_t pfront_query_page(const struct pfront_query_t *query,
                                  struct pfront_cursor_t *cursor,
                                  struct pfront_pair_t *page,
                                  size_t capacity,
                                  size_t *count,
                                  struct pfront_error_t *error);

// `pfront_query_page` that also stops after `budget` + 16 box and triangle tests at most, to spread a query over
// frames. Pages may be empty then; with a budget of 0 nothing is done.
pfront_status_t pfront_query_step(const struct pfront_query_t *query,
                                  struct pfront_cursor_t *cursor,
                                  uint64_t budget,
                                  struct pfront_pair_t *page,
                                  size_t capacity,
                                  size_t *count,
                                  struct pfront_error_t *error);

// Tells how many pairs meet.
pfront_status_t pfront_query_count(const struct pfront_query_t *query,
                                   uint64_t *count,
                                   struct pfront_error_t *error);

// Finds some pair that meets, and stops at the first: `found` is 1 if there is one, else 0 and `pair` is not written.
pfront_status_t pfront_query_any(const struct pfront_query_t *query,
                                 struct pfront_pair_t *pair,
                                 uint32_t *found,
                                 struct pfront_error_t *error);

// Tells where the triangles of each of `count` pairs meet, into as many `contacts`. The pairs need not be of an answer.
pfront_status_t pfront_query_contacts(const struct pfront_query_t *query,
                                      const struct pfront_pair_t *pairs,
                                      size_t count,
                                      struct pfront_contact_t *contacts,
                                      struct pfront_error_t *error);

// Makes a front in the caller's memory, with nothing remembered, which need not be initialised. `history` may be null
// if `history_capacity` is 0.
pfront_status_t pfront_front_init(struct pfront_front_t *front,
                                  struct pfront_front_node_t *nodes,
                                  size_t node_capacity,
                                  struct pfront_front_node_t *history,
                                  size_t history_capacity,
                                  struct pfront_error_t *error);

// Divides the queries of a frame into nodes of about equal cost, and assigns these to `workers`, of which there is at
// least one: the p-partition front of Zhang and Kim (2014). `parts` has one element a worker and tells in the end what
// each is predicted to cost. `history` is sorted.
//
// Then each worker, on a thread of its own, goes through the nodes whose `part` is its number: it sets its own cursor to
// the node by `pfront_cursor_at`, asks page by page until that is done, and writes what this cost to the node. All
// pages together are the answer; which pairs come from which node is the same for any number of threads.
pfront_status_t pfront_front_divide(struct pfront_front_t *front,
                                    const struct pfront_query_t *queries,
                                    size_t query_count,
                                    struct pfront_part_t *parts,
                                    size_t workers,
                                    struct pfront_error_t *error);

// Remembers what the nodes of a front have cost, for the next `pfront_front_divide`: after all workers are done.
pfront_status_t pfront_front_remember(struct pfront_front_t *front,
                                      struct pfront_error_t *error);

// Tells a front that the next frame asks other queries than the last: the one with number `i` gets `numbers[i]`, or is
// gone if that is UINT32_MAX or `i` is not below `count`. No two get the same. Without this, keep all numbers, or set
// `history_count` to 0.
pfront_status_t pfront_front_renumber(struct pfront_front_t *front,
                                      const uint32_t *numbers,
                                      size_t count,
                                      struct pfront_error_t *error);

// Finds all pairs of triangles of `a` and `b` that meet, `b` in the pose `a_from_b`: exactly, and sorted. BVHs are
// built on the way and dropped; to ask again about the same meshes, keep them: see `pfront_query_pair`.
//
// `list` need not be initialised; it takes memory of `allocator`, which a null pointer leaves to malloc, unless the
// library is without the standard library. `pfront_pair_list_free` gives it back. Other memory, about 100 bytes a
// triangle, is given back at once.
pfront_status_t pfront_all(const struct pfront_buffers_t *a,
                           const struct pfront_buffers_t *b,
                           const struct pfront_pose_t *a_from_b,
                           const struct pfront_allocator_t *allocator,
                           struct pfront_pair_list_t *list,
                           struct pfront_error_t *error);

// Finds all pairs of triangles of one mesh that meet, by a `pfront_rule_t`; all else is as for `pfront_all`.
pfront_status_t pfront_self(const struct pfront_buffers_t *buffers,
                            uint32_t rule,
                            const struct pfront_allocator_t *allocator,
                            struct pfront_pair_list_t *list,
                            struct pfront_error_t *error);

// Finds some pair of triangles of `a` and `b` that meet, and stops at the first: `found` is 1 if there is one, else 0
// and `pair` is not written. All else is as for `pfront_all`; there is nothing to free.
pfront_status_t pfront_any(const struct pfront_buffers_t *a,
                           const struct pfront_buffers_t *b,
                           const struct pfront_pose_t *a_from_b,
                           const struct pfront_allocator_t *allocator,
                           struct pfront_pair_t *pair,
                           uint32_t *found,
                           struct pfront_error_t *error);

// Gives the memory of a list back to its allocator. The list is not one any more afterwards, and PFRONT_NOT_MADE if it
// is freed again.
pfront_status_t pfront_pair_list_free(struct pfront_pair_list_t *list,
                                      struct pfront_error_t *error);

// Makes a model of a vertex buffer and an index buffer, which are copied, and builds its BVH by the surface area
// heuristic.
pfront_status_t pfront_model_create(const struct pfront_buffers_t *buffers,
                                    struct pfront_model_t **model,
                                    struct pfront_error_t *error);

// `pfront_model_create` of positions in double in place of float: `stride` is at least 24, and 0 stands for 24. Coordinates
// are at most 2^125. Questions about the model are decided in f64, exactly for the positions given, whatever the other body
// and the poses. Takes 24 bytes a vertex more, unless floats hold every coordinate.
pfront_status_t pfront_model_create_f64(const struct pfront_buffers_t *buffers,
                                        struct pfront_model_t **model,
                                        struct pfront_error_t *error);

// Makes a model of a blob, whose mesh and BVH are checked and copied, so that nothing is built. The bytes may lie
// anywhere, and are of no use afterwards.
pfront_status_t pfront_model_from_blob(const void *blob,
                                       size_t blob_bytes,
                                       struct pfront_model_t **model,
                                       struct pfront_error_t *error);

// Moves the vertices of a model, given in its own frame: as many as it has, `stride` bytes apart, where 0 stands for 12. The threads of `executor`
// refit its BVH, or the calling one if that is null; for a GPU, the next question refits it there. Bodies that were made of the model stay
// as they are, and so do queries that keep it: then the model is copied first, also for positions that are refused. PFRONT_BUSY if another thread is inside a call
// with it. In O(vertices + triangles), but that a BVH which has worn is built anew.
pfront_status_t pfront_model_set_positions(struct pfront_model_t *model,
                                           const struct pfront_executor_t *executor,
                                           const void *positions,
                                           size_t vertex_count,
                                           size_t stride,
                                           struct pfront_error_t *error);

// `pfront_model_set_positions` of a model in f64, of positions in double: 0 stands for 24.
pfront_status_t pfront_model_set_positions_f64(struct pfront_model_t *model,
                                               const struct pfront_executor_t *executor,
                                               const void *positions,
                                               size_t vertex_count,
                                               size_t stride,
                                               struct pfront_error_t *error);

// Frees a model; null is fine. Bodies that were made of it stay as they are. PFRONT_BUSY if another thread is inside a call
// with it.
pfront_status_t pfront_model_free(struct pfront_model_t *model,
                                  struct pfront_error_t *error);

// Makes an executor of a `pfront_device_t`. With `workers` above 1, which needs a library that was built with threads, a frame
// that is worth it is divided into as many parts, for as many threads as the machine has cores; else the calling thread works
// alone, and more than 1 is PFRONT_OUT_OF_RANGE. 0 counts as 1. Under PFRONT_GPU the workers answer what a GPU does not.
//
// PFRONT_NO_DEVICE if there is no GPU that can be used, or the library was built without. Opening one takes a second or two,
// measuring it for PFRONT_AUTO as long again: make one executor and keep it. A child of fork can use and make executors without
// threads and GPU only, once its parent has made one with either; the others are PFRONT_FORKED there, and can only be freed, which
// leaves their memory.
pfront_status_t pfront_executor_create(uint32_t device,
                                       uint32_t workers,
                                       struct pfront_executor_t **executor,
                                       struct pfront_error_t *error);

// Frees an executor; null is fine. Scenes and queries that were made with it go on. PFRONT_BUSY if another thread is inside a
// call with it.
pfront_status_t pfront_executor_free(struct pfront_executor_t *executor,
                                     struct pfront_error_t *error);

// Makes a query that asks `executor`, or the calling thread if that is null. It keeps its last answer, and what its frames
// took: use one for each series of frames that resemble each other.
pfront_status_t pfront_model_query_create(const struct pfront_executor_t *executor,
                                          struct pfront_model_query_t **query,
                                          struct pfront_error_t *error);

// Frees a query and all that it has handed out; null is fine. PFRONT_BUSY if another thread is inside a call with it.
pfront_status_t pfront_model_query_free(struct pfront_model_query_t *query,
                                        struct pfront_error_t *error);

// The query is asked for pairs of triangles at most `distance` apart from now on, in place of those that intersect, which 0 asks
// for again. A GPU answers it about two models; about one and itself CPUs answer. Contacts are those of the pairs that intersect, and
// triangles of one mesh that share a vertex are asked about as `rule` says.
pfront_status_t pfront_model_query_within(struct pfront_model_query_t *query,
                                          float distance,
                                          struct pfront_error_t *error);

// Finds all pairs of triangles of a subject that meet: `count` of them in `pairs`, sorted. They belong to the query and are good
// until this is called again, or the query is freed.
pfront_status_t pfront_model_query_all(struct pfront_model_query_t *query,
                                       const struct pfront_subject_t *subject,
                                       const struct pfront_pair_t **pairs,
                                       size_t *count,
                                       struct pfront_error_t *error);

// Finds the smallest distance of two models, in the frame of `a`: `found` is 1 and `gap` tells it, if it is at most `limit`,
// which is INFINITY for any; else, or if a model has no triangles, `found` is 0 and `gap` is not written. A model and itself are
// PFRONT_NULL. CPUs answer, whatever the executor, and the distance of `pfront_model_query_within` does not matter.
pfront_status_t pfront_model_query_distance(struct pfront_model_query_t *query,
                                            const struct pfront_subject_t *subject,
                                            float limit,
                                            struct pfront_gap_t *gap,
                                            uint32_t *found,
                                            struct pfront_error_t *error);

// Finds some pair that meets, and stops at the first: `found` is 1 if there is one, else 0 and `pair` is not written.
pfront_status_t pfront_model_query_any(struct pfront_model_query_t *query,
                                       const struct pfront_subject_t *subject,
                                       struct pfront_pair_t *pair,
                                       uint32_t *found,
                                       struct pfront_error_t *error);

// Tells how many pairs meet.
pfront_status_t pfront_model_query_count(struct pfront_model_query_t *query,
                                         const struct pfront_subject_t *subject,
                                         uint64_t *count,
                                         struct pfront_error_t *error);

// `pfront_model_query_all` that also tells where they meet. `contacts` belongs to the query and is good until this is called again,
// or the query is freed.
pfront_status_t pfront_model_query_contacts(struct pfront_model_query_t *query,
                                            const struct pfront_subject_t *subject,
                                            const struct pfront_model_contact_t **contacts,
                                            size_t *count,
                                            struct pfront_error_t *error);

// Finds for each of `subject_count` subjects some pair that meets: `found[i]` is 1 if there is one, else 0 and `pairs[i]` is not
// written. Where that pays, all threads of `executor` work on them, or its GPU; null stands for the calling thread. A subject at
// fault is `index` of the error.
pfront_status_t pfront_batch_any(const struct pfront_executor_t *executor,
                                 const struct pfront_subject_t *subjects,
                                 size_t subject_count,
                                 struct pfront_pair_t *pairs,
                                 uint32_t *found,
                                 struct pfront_error_t *error);

// Tells for each of `subject_count` subjects how many pairs meet. All else is as for `pfront_batch_any`.
pfront_status_t pfront_batch_count(const struct pfront_executor_t *executor,
                                   const struct pfront_subject_t *subjects,
                                   size_t subject_count,
                                   uint64_t *counts,
                                   struct pfront_error_t *error);

// Finds the smallest distance of the models of each of `subject_count` subjects, as `pfront_model_query_distance` does: what a planner
// asks of many poses. `found[i]` is 1 and `gaps[i]` tells it, if it is at most `limit`, which is INFINITY for any; else `found[i]` is 0
// and `gaps[i]` is not written. A model and itself are PFRONT_NULL. CPUs answer, on all threads of `executor`; null stands for the
// calling thread. A subject at fault is `index` of the error.
pfront_status_t pfront_batch_distance(const struct pfront_executor_t *executor,
                                      const struct pfront_subject_t *subjects,
                                      size_t subject_count,
                                      float limit,
                                      struct pfront_gap_t *gaps,
                                      uint32_t *found,
                                      struct pfront_error_t *error);

// Finds what one solid is to another, exactly: models whose meshes are closed. Vertices at the same place are one, and several bodies in
// one mesh are one solid. With `pfront_model_query_within`, solids that are apart are near if they are at most so far apart. A model and
// itself are PFRONT_NULL, and what is no solid is PFRONT_OPEN_EDGE, PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME.
//
// Rounding alone can make flush parts cross by a trifle: ask for the volume before calling that a clash. The query keeps
// a model with what has to be known of it once, 36 bytes a triangle and 44 a vertex, until it is asked about another one as a solid.
pfront_status_t pfront_model_query_relation(struct pfront_model_query_t *query,
                                            const struct pfront_subject_t *subject,
                                            struct pfront_between_t *between,
                                            struct pfront_error_t *error);

// Finds the volume that two solids have in common, in the units of `a`: it is at least `low` and at most `high`. All else is as for
// `pfront_model_query_relation`, but triangles of a model that meet beyond the corners that they share, inside the other
// solid or on its surface, are PFRONT_MEETS_ITSELF here.
pfront_status_t pfront_model_query_overlap_volume(struct pfront_model_query_t *query,
                                                  const struct pfront_subject_t *subject,
                                                  double *low,
                                                  double *high,
                                                  struct pfront_error_t *error);

// Finds all that two surfaces have in common, in connected patches: `count` of them in `patches`, in the order of their first pairs, in the
// units of `a`. Exact signs tell what is connected; lengths and areas are intervals. Vertices at the same place are one. Where a mesh
// meets itself, what it covers twice counts twice. A model and itself are PFRONT_NULL. `patches` belongs to the query and is good
// until this is called again, or the query is freed.
pfront_status_t pfront_model_query_patches(struct pfront_model_query_t *query,
                                           const struct pfront_subject_t *subject,
                                           const struct pfront_patch_t **patches,
                                           size_t *count,
                                           struct pfront_error_t *error);

// Finds all pairs of triangles of two models that meet while both move: `count` of them in `impacts`, sorted by their pairs. With `b` null, those
// of `a` with itself while it deforms, by `rule`: PFRONT_SHARED_INDEX or PFRONT_SKIP_NEIGHBOURS. No pair is missed. CPUs answer, whatever
// the executor. After `pfront_model_query_within`, pairs are those that come within the distance on the way. `impacts` belongs to the query and is
// good until this is called again, or the query is freed.
pfront_status_t pfront_model_query_impacts(struct pfront_model_query_t *query,
                                           const struct pfront_motion_t *a,
                                           const struct pfront_motion_t *b,
                                           uint32_t rule,
                                           const struct pfront_impact_t **impacts,
                                           size_t *count,
                                           struct pfront_error_t *error);

// Finds the pair of triangles that meets first: `found` is 1 and `impact` tells it, or `found` is 0 and `impact` is not written. All else is
// as for `pfront_model_query_impacts`.
pfront_status_t pfront_model_query_first_impact(struct pfront_model_query_t *query,
                                                const struct pfront_motion_t *a,
                                                const struct pfront_motion_t *b,
                                                uint32_t rule,
                                                struct pfront_impact_t *impact,
                                                uint32_t *found,
                                                struct pfront_error_t *error);

// Finds some pair of triangles that meets, and stops at the first that certainly does: `found` is 1 and `impact` tells it, or `found` is 0
// and `impact` is not written. `to` is INFINITY only if all that `pfront_model_query_impacts` finds are open. Executors may find different
// pairs. All else is as for `pfront_model_query_impacts`.
pfront_status_t pfront_model_query_any_impact(struct pfront_model_query_t *query,
                                              const struct pfront_motion_t *a,
                                              const struct pfront_motion_t *b,
                                              uint32_t rule,
                                              struct pfront_impact_t *impact,
                                              uint32_t *found,
                                              struct pfront_error_t *error);

// Tells how many pairs of triangles meet: at least `low`, which certainly do, and at most `high`, which are all that
// `pfront_model_query_impacts` finds. No list is kept. All else is as for `pfront_model_query_impacts`.
pfront_status_t pfront_model_query_count_impacts(struct pfront_model_query_t *query,
                                                 const struct pfront_motion_t *a,
                                                 const struct pfront_motion_t *b,
                                                 uint32_t rule,
                                                 uint64_t *low,
                                                 uint64_t *high,
                                                 struct pfront_error_t *error);

// Finds all triangles of a model that the closed segment between two points meets, each of 3 doubles: `count` of them in `hits`, sorted by
// triangles. Exactly: touching counts, and a segment from a point to itself is that point. Coordinates are at most 2^125. `hits` belongs
// to the query and is good until this is called again, or the query is freed. The calling thread answers, whatever the executor.
pfront_status_t pfront_model_query_segment(struct pfront_model_query_t *query,
                                           const struct pfront_model_t *model,
                                           const double *from,
                                           const double *to,
                                           const struct pfront_segment_hit_t **hits,
                                           size_t *count,
                                           struct pfront_error_t *error);

// Finds the first triangle of a model along the segment from one point to another, each of 3 doubles: `found` is 1 and `hit` tells it,
// else 0 and `hit` is not written. Exactly: of triangles that it meets in one point, the one with the lowest index. Any number of threads may ask
// about a model at once.
pfront_status_t pfront_model_segment_first(const struct pfront_model_t *model,
                                           const double *from,
                                           const double *to,
                                           struct pfront_segment_hit_t *hit,
                                           uint32_t *found,
                                           struct pfront_error_t *error);

// Tells for each of `point_count` points, of 3 doubles, where it is, as a model sees it whose mesh is closed: a `pfront_location_t` in each
// of `locations`. Exactly, by winding numbers, also where triangles meet their own mesh. A model that is no solid is PFRONT_OPEN_EDGE,
// PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME; a point at fault is `index` of the error. The query keeps a model as
// for `pfront_model_query_relation`.
pfront_status_t pfront_model_query_inside(struct pfront_model_query_t *query,
                                          const struct pfront_model_t *model,
                                          const double *points,
                                          size_t point_count,
                                          uint32_t *locations,
                                          struct pfront_error_t *error);

// Makes a scene without bodies, which asks `executor`, or the calling thread if that is null.
//
// A scene takes memory by malloc. PFRONT_OUT_OF_MEMORY if an answer or a mesh does not fit: then nothing has changed, and the
// call can be made again. After PFRONT_DAMAGED a scene can only be freed. A child of fork may use a scene whose executor has
// neither threads nor a GPU; any other one is PFRONT_FORKED there, and can only be freed.
pfront_status_t pfront_scene_create(const struct pfront_executor_t *executor,
                                    struct pfront_scene_t **scene,
                                    struct pfront_error_t *error);

// The scene is asked for pairs of triangles at most `distance` apart from now on, in place of those that intersect, which 0 asks
// for again. CPUs answer, whatever the executor. Contacts are those of the pairs that intersect.
pfront_status_t pfront_scene_within(struct pfront_scene_t *scene,
                                    float distance,
                                    struct pfront_error_t *error);

// Frees a scene and all that it has handed out; null is fine. Models stay. PFRONT_BUSY if another thread is inside a call with
// it.
pfront_status_t pfront_scene_free(struct pfront_scene_t *scene,
                                  struct pfront_error_t *error);

// Adds a body: a model, which many bodies may share, in the pose `world_from_body`. `body` names it for good:
// numbers are never used again, and they ascend in the order of adding.
pfront_status_t pfront_scene_add(struct pfront_scene_t *scene,
                                 const struct pfront_model_t *model,
                                 const struct pfront_pose_t *world_from_body,
                                 uint64_t *body,
                                 struct pfront_error_t *error);

// Takes a body out.
pfront_status_t pfront_scene_remove(struct pfront_scene_t *scene,
                                    uint64_t body,
                                    struct pfront_error_t *error);

// Moves a body to the pose `world_from_body`. If that is the pose it has, the body counts as one that stands still,
// which costs nothing in the next frame.
pfront_status_t pfront_scene_set_pose(struct pfront_scene_t *scene,
                                      uint64_t body,
                                      const struct pfront_pose_t *world_from_body,
                                      struct pfront_error_t *error);

// `pfront_scene_set_pose` with a pose in f64, in which the body is then asked about, whatever the other one. A body that
// is to have one from the start is added with PFRONT_POSE_IDENTITY first.
pfront_status_t pfront_scene_set_pose_f64(struct pfront_scene_t *scene,
                                          uint64_t body,
                                          const struct pfront_pose64_t *world_from_body,
                                          struct pfront_error_t *error);

// Moves the vertices of a body, given in its own frame: as many as its model has, `stride` bytes apart, where 0 stands
// for 12. From then on the body has a model of its own. In O(vertices + triangles).
pfront_status_t pfront_scene_set_positions(struct pfront_scene_t *scene,
                                           uint64_t body,
                                           const void *positions,
                                           size_t vertex_count,
                                           size_t stride,
                                           struct pfront_error_t *error);

// `pfront_scene_set_positions` of a body whose model is in f64, of positions in double: 0 stands for 24.
pfront_status_t pfront_scene_set_positions_f64(struct pfront_scene_t *scene,
                                               uint64_t body,
                                               const void *positions,
                                               size_t vertex_count,
                                               size_t stride,
                                               struct pfront_error_t *error);

// Says which groups a body is in and which it may meet: two bodies are asked about if each is a member of a group
// that the other's filter lets through. All bits are set at first.
pfront_status_t pfront_scene_set_groups(struct pfront_scene_t *scene,
                                        uint64_t body,
                                        uint32_t memberships,
                                        uint32_t filter,
                                        struct pfront_error_t *error);

// Asks with all else whether a body meets itself, as cloth does, by the rule of `pfront_query_self`; or no longer, if `asked` is
// 0. A hit of it has the same body twice.
pfront_status_t pfront_scene_ask_itself(struct pfront_scene_t *scene,
                                        uint64_t body,
                                        uint32_t asked,
                                        struct pfront_error_t *error);

// Ignores two bodies, as the links of a joint that overlap by design; or no longer, if `ignored` is 0.
pfront_status_t pfront_scene_ignore(struct pfront_scene_t *scene,
                                    uint64_t a,
                                    uint64_t b,
                                    uint32_t ignored,
                                    struct pfront_error_t *error);

// Keeps a number of the caller's with a body, such as the index of an entity; it is 0 at first.
pfront_status_t pfront_scene_set_user_data(struct pfront_scene_t *scene,
                                           uint64_t body,
                                           uint64_t user_data,
                                           struct pfront_error_t *error);

// Tells the number that is kept with a body.
pfront_status_t pfront_scene_user_data(const struct pfront_scene_t *scene,
                                       uint64_t body,
                                       uint64_t *user_data,
                                       struct pfront_error_t *error);

// Finds all pairs of triangles of different bodies that meet: `count` of them in `hits`, sorted by bodies, then
// triangles. They belong to the scene and are good until this is called again, or the scene is freed. Answers about
// bodies that stand still are kept, so that a frame costs what the others do.
pfront_status_t pfront_scene_update(struct pfront_scene_t *scene,
                                    const struct pfront_scene_hit_t **hits,
                                    size_t *count,
                                    struct pfront_error_t *error);

// `pfront_scene_update` that also tells where they meet. `contacts` belongs to the scene and is good until this is called
// again, or the scene is freed.
pfront_status_t pfront_scene_contacts(struct pfront_scene_t *scene,
                                      const struct pfront_scene_contact_t **contacts,
                                      size_t *count,
                                      struct pfront_error_t *error);

// `pfront_scene_contacts` in f64: of bodies in f64 not rounded. Only the hits are kept from frame to frame. `contacts` is good
// until this is called again, or the scene is freed.
pfront_status_t pfront_scene_contacts_f64(struct pfront_scene_t *scene,
                                          const struct pfront_scene_contact64_t **contacts,
                                          size_t *count,
                                          struct pfront_error_t *error);

// Finds some pair of triangles of different bodies that meet, and stops at the first: `found` is 1 if there is one,
// else 0 and `hit` is not written.
pfront_status_t pfront_scene_any(struct pfront_scene_t *scene,
                                 struct pfront_scene_hit_t *hit,
                                 uint32_t *found,
                                 struct pfront_error_t *error);

// Tells how many pairs of triangles of different bodies meet.
pfront_status_t pfront_scene_count(struct pfront_scene_t *scene,
                                   uint64_t *count,
                                   struct pfront_error_t *error);

// Finds all pairs of triangles of different bodies that meet while the `end_count` bodies of `ends` move, each given once; all others stay
// where they are, and the scene is the same afterwards. `count` of them are in `impacts`, sorted by bodies, then triangles. No pair is missed. After
// `pfront_scene_within`, pairs are those that come within the distance on the way. CPUs answer, whatever the executor. `impacts` belongs to the
// scene and is good until this is called again, or the scene is freed.
pfront_status_t pfront_scene_impacts(struct pfront_scene_t *scene,
                                     const struct pfront_body_end_t *ends,
                                     size_t end_count,
                                     const struct pfront_scene_impact_t **impacts,
                                     size_t *count,
                                     struct pfront_error_t *error);

// Finds the pair of triangles that meets first, by time, then by bodies and triangles: `found` is 1 and `impact` tells it, or `found` is 0 and
// `impact` is not written. All else is as for `pfront_scene_impacts`.
pfront_status_t pfront_scene_first_impact(struct pfront_scene_t *scene,
                                          const struct pfront_body_end_t *ends,
                                          size_t end_count,
                                          struct pfront_scene_impact_t *impact,
                                          uint32_t *found,
                                          struct pfront_error_t *error);

// Finds some pair of triangles that meets, and stops at the first that certainly does: `found` is 1 and `impact` tells it, or `found` is 0
// and `impact` is not written. `to` is INFINITY only if all that `pfront_scene_impacts` finds are open. Executors may find different
// pairs. All else is as for `pfront_scene_impacts`.
pfront_status_t pfront_scene_any_impact(struct pfront_scene_t *scene,
                                        const struct pfront_body_end_t *ends,
                                        size_t end_count,
                                        struct pfront_scene_impact_t *impact,
                                        uint32_t *found,
                                        struct pfront_error_t *error);

// Tells how many pairs of triangles meet: at least `low`, which certainly do, and at most `high`, which are all that
// `pfront_scene_impacts` finds. No list is kept. All else is as for `pfront_scene_impacts`.
pfront_status_t pfront_scene_count_impacts(struct pfront_scene_t *scene,
                                           const struct pfront_body_end_t *ends,
                                           size_t end_count,
                                           uint64_t *low,
                                           uint64_t *high,
                                           struct pfront_error_t *error);

// Finds which bodies meet, each two until their first hit: `count` pairs in `pairs`, sorted, of which each is two numbers, the
// body that was added first before the other; a body that is asked about itself twice. They belong to the scene and are
// good until this is called again, or the scene is freed.
pfront_status_t pfront_scene_intersecting_bodies(struct pfront_scene_t *scene,
                                                 const uint64_t (**pairs)[2],
                                                 size_t *count,
                                                 struct pfront_error_t *error);

// Finds the bodies whose box in the world overlaps the box from `min` to `max`, each of 3 floats: `count` of them in `bodies`,
// sorted. They belong to the scene and are good until this is called again, or the scene is freed.
pfront_status_t pfront_scene_bodies_in(struct pfront_scene_t *scene,
                                       const float *min,
                                       const float *max,
                                       const uint64_t **bodies,
                                       size_t *count,
                                       struct pfront_error_t *error);

// Finds the body that is nearest to `body`, and their smallest distance in the world: `found` is 1, `nearest` names it and `gap`
// tells the distance, if it is at most `limit`, which is INFINITY for any; else `found` is 0 and neither is written. Triangle `a` of the pair
// is of `body`. Bodies that it may not meet are left out.
pfront_status_t pfront_scene_distance(struct pfront_scene_t *scene,
                                      uint64_t body,
                                      float limit,
                                      uint64_t *nearest,
                                      struct pfront_gap_t *gap,
                                      uint32_t *found,
                                      struct pfront_error_t *error);

// Calls `visit` with `context` and each hit, on the calling thread, bodies in order and their triangles in none, until it returns
// another number than 0: then `stopped` is 1, else 0. `visit` runs in the default floating-point environment; a call with this scene
// is PFRONT_BUSY there, and it must not leave by an exception or by longjmp. Nothing is kept.
pfront_status_t pfront_scene_visit(struct pfront_scene_t *scene,
                                   int32_t (*visit)(void *context,
                                                    const struct pfront_scene_hit_t *hit),
                                   void *context,
                                   uint32_t *stopped,
                                   struct pfront_error_t *error);

// Gives a body another model.
pfront_status_t pfront_scene_set_model(struct pfront_scene_t *scene,
                                       uint64_t body,
                                       const struct pfront_model_t *model,
                                       struct pfront_error_t *error);

// Splits a body: triangle i goes to part `parts[i]`, of which there are as many as triangles. Each part becomes a body in the same
// pose, with a mesh of its own whose triangles are in the old order, the groups and the number of the old one, which is gone, and asked about itself if that was; nobody ignores it. `pieces` tells
// `count` of them, by parts; it belongs to the scene and is good until this is called again, or the scene is freed.
pfront_status_t pfront_scene_split(struct pfront_scene_t *scene,
                                   uint64_t body,
                                   const uint32_t *parts,
                                   size_t triangle_count,
                                   const struct pfront_piece_t **pieces,
                                   size_t *count,
                                   struct pfront_error_t *error);

// Finds the relation of every two bodies whose boxes overlap, and whether it is allowed: `count` rows in `pairs`, sorted by bodies, and the
// bodies among them that are no solids, `refused_count` in `refused`. If `allowed` is null, bodies may be apart or touch, and overlap by
// nothing. With `pfront_scene_within`, bodies that are apart are near if they are at most so far apart. Bodies that ignore each other are left out. CPUs
// answer, whatever the executor. Both lists belong to the scene and are good until this is called again, or the scene is freed.
//
// Each pair is asked in the frame of its first body, so that parts that are flush and turned alike stay flush.
pfront_status_t pfront_scene_check(struct pfront_scene_t *scene,
                                   const struct pfront_allowed_t *allowed,
                                   const struct pfront_checked_pair_t **pairs,
                                   size_t *count,
                                   const struct pfront_refused_body_t **refused,
                                   size_t *refused_count,
                                   struct pfront_error_t *error);

// Finds all triangles that the closed segment between two points of the world meets, each of 3 doubles: `count` of them in `hits`, sorted
// by bodies, then triangles. Exactly, for the bodies as they are posed, each in the precision of its model and its pose; touching counts. `hits`
// belongs to the scene and is good until this is called again, or the scene is freed. The calling thread answers, whatever the executor.
pfront_status_t pfront_scene_segment(struct pfront_scene_t *scene,
                                     const double *from,
                                     const double *to,
                                     const struct pfront_scene_segment_hit_t **hits,
                                     size_t *count,
                                     struct pfront_error_t *error);

// Finds the first triangle along the segment from one point of the world to another, each of 3 doubles: `found` is 1 and `hit` tells it,
// else 0 and `hit` is not written. Exactly: of triangles that it meets in one point, that of the body that was added first, and of its triangles
// the one with the lowest index.
pfront_status_t pfront_scene_segment_first(struct pfront_scene_t *scene,
                                           const double *from,
                                           const double *to,
                                           struct pfront_scene_segment_hit_t *hit,
                                           uint32_t *found,
                                           struct pfront_error_t *error);

// Finds the bodies that contain a point of the world, of 3 doubles, in their interior or on their surface: `count` of them in `bodies`, in the order of
// adding, and among them those whose box contains it and whose mesh is open. Exactly, for the bodies as they are posed. `bodies`
// belongs to the scene and is good until this is called again, or the scene is freed. The calling thread answers, whatever the executor.
pfront_status_t pfront_scene_inside(struct pfront_scene_t *scene,
                                    const double *point,
                                    const struct pfront_containing_body_t **bodies,
                                    size_t *count,
                                    struct pfront_error_t *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

// Leaves everything where it is, to the bit: pfront_pose_t pose = PFRONT_POSE_IDENTITY;
#define PFRONT_POSE_IDENTITY {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}

// How much memory is enough for n triangles, v vertices and m nodes as constants, for static arrays: what the functions
// of the same names return, but for numbers that no mesh can have.
#define PFRONT_NODE_BOUND(n) (2 * (size_t)(n))
#define PFRONT_MORTON_SCRATCH_BYTES(n) (16 * (size_t)(n) + 7)
#define PFRONT_SAH_SCRATCH_BYTES(n) (32 * (size_t)(n) + 3)
#define PFRONT_ADOPT_SCRATCH_BYTES(n) (4 * ((size_t)(n) > 32 ? ((size_t)(n) + 31) / 32 : 1) + 3)
#define PFRONT_HISTORY_BOUND(v, n) ((size_t)(v))
#define PFRONT_LINK_SCRATCH_BYTES(v, n) (4 * (size_t)(v) + 12 * (size_t)(n) + 7)

// A compiler that lays out structures in another way than the library expects refuses these.
typedef char pfront_node_t_has_32_bytes[sizeof(pfront_node_t) == 32 ? 1 : -1];
typedef char pfront_pair_t_has_8_bytes[sizeof(pfront_pair_t) == 8 ? 1 : -1];
typedef char pfront_contact_t_has_52_bytes[sizeof(pfront_contact_t) == 52 ? 1 : -1];
typedef char pfront_front_node_t_has_40_bytes[sizeof(pfront_front_node_t) == 40 ? 1 : -1];
typedef char pfront_cursor_t_has_3936_bytes[sizeof(pfront_cursor_t) == 3936 ? 1 : -1];

#endif
