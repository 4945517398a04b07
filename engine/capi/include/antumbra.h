/* Antumbra: exact occlusion culling that never waits for the GPU. The C interface.
 *
 * Rules of all functions:
 * - The result is ANTUMBRA_RESULT_OK or an error. After an error nothing was written to the outputs,
 *   unless the function says so, but the AntumbraError, which says what to do. It may be null.
 * - Set the struct_size of each struct that has one to its sizeof, also of an AntumbraError and of
 *   structs for output, and what you do not set to 0.
 * - A pointer and a count describe an array; null is allowed if the count is 0. Input and output
 *   arrays do not overlap.
 * - Objects belong to a context. A handle that is 0, was destroyed, or belongs to another context or
 *   kind of object is an error.
 * - Any function may be called on any thread. A function that changes an object needs it alone, one
 *   that reads shares it with others that read; otherwise the result is ANTUMBRA_RESULT_BUSY, and
 *   nothing waits. antumbra_context_destroy comes after all other calls have returned.
 * - A panic inside becomes ANTUMBRA_RESULT_PANIC. The object that was being changed then answers
 *   ANTUMBRA_RESULT_POISONED to everything but its destruction.
 * - Callbacks return: no exception and no longjmp leaves them.
 * - There is no global state: two contexts know nothing of each other.
 */


#ifndef ANTUMBRA_H
#define ANTUMBRA_H

/* Made from the sources of antumbra-capi by cbindgen: do not edit. */

#include <stddef.h>
#include <stdint.h>

/**
 * Tests by flags that fragments set: they take no queries.
 */
#define ANTUMBRA_HAS_FLAGS 1

/**
 * Tests by a compute shader that reads the depth buffer.
 */
#define ANTUMBRA_HAS_COMPUTE 2

/**
 * Everything in the view frustum is drawn, nothing is tested: the reference.
 */
#define ANTUMBRA_STRATEGY_FRUSTUM 0

/**
 * Late answers, made exact by tests in the same frame.
 */
#define ANTUMBRA_STRATEGY_ANTUMBRA 1

/**
 * The object of a leaf that has none.
 */
#define ANTUMBRA_NO_OBJECT UINT32_MAX

/**
 * The purpose of a query: a box whose leaves are drawn if it shows.
 */
#define ANTUMBRA_QUERY_PROXY 0

/**
 * The purpose of a query: a box on which no draw of this frame depends.
 */
#define ANTUMBRA_QUERY_PULL_UP 1

/**
 * The purpose of a query: the box of a leaf that is drawn anyway.
 */
#define ANTUMBRA_QUERY_VISIBLE_BOX 2

/**
 * The purpose of a query: the draw of a leaf that is drawn anyway.
 */
#define ANTUMBRA_QUERY_VISIBLE_DRAW 3

/**
 * The mechanism that tests a box: an occlusion query.
 */
#define ANTUMBRA_TESTER_QUERY 0

/**
 * The mechanism that tests a box: a flag that its fragments set.
 */
#define ANTUMBRA_TESTER_FLAG 1

/**
 * The mechanism that tests a box: a comparison with the depth buffer in a compute shader.
 */
#define ANTUMBRA_TESTER_COMPUTE 2

/**
 * The number of a draw's query if it has none.
 */
#define ANTUMBRA_NO_QUERY UINT32_MAX

/**
 * Depth is 1 at the near plane and 0 infinitely far away.
 */
#define ANTUMBRA_DEPTH_REVERSED 0

/**
 * Depth is 0 at the near plane and 1 at the far plane, or infinitely far away.
 */
#define ANTUMBRA_DEPTH_STANDARD 1

/**
 * The y of clip space points down, as Vulkan's.
 */
#define ANTUMBRA_CLIP_Y_DOWN 0

/**
 * The y of clip space points up: the host turns images over by a viewport of negative height.
 */
#define ANTUMBRA_CLIP_Y_UP 1

/**
 * An error: something could not be done.
 */
#define ANTUMBRA_LOG_ERROR 1

/**
 * A warning: it works, but not as well as it could.
 */
#define ANTUMBRA_LOG_WARN 2

/**
 * A decision worth knowing, such as the way a device is used.
 */
#define ANTUMBRA_LOG_INFO 3

/**
 * Details for those who look for a defect.
 */
#define ANTUMBRA_LOG_DEBUG 4

/**
 * The version of the interface: its declarations and their meaning. It grows by one with a change
 * that breaks programs compiled before. New functions, and new fields at the end of structs with a
 * `struct_size`, do not.
 */
#define ANTUMBRA_ABI_VERSION 1

/**
 * The result of a call.
 */
enum AntumbraResult
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * It did what it says.
     */
    ANTUMBRA_RESULT_OK = 0,
    /**
     * A pointer is null that must not be, or is not aligned.
     */
    ANTUMBRA_RESULT_BAD_POINTER = -1,
    /**
     * A `struct_size` is the size of no version of the struct, or a field that this version of
     * the library does not know is not 0.
     */
    ANTUMBRA_RESULT_BAD_STRUCT_SIZE = -2,
    /**
     * A value is outside of its range, or does not fit the others.
     */
    ANTUMBRA_RESULT_BAD_ARGUMENT = -3,
    /**
     * A handle that is 0, was destroyed, or belongs to another context or kind of object.
     */
    ANTUMBRA_RESULT_UNKNOWN_HANDLE = -4,
    /**
     * Another call is using the object.
     */
    ANTUMBRA_RESULT_BUSY = -5,
    /**
     * The object was being changed when a panic happened: destroy it.
     */
    ANTUMBRA_RESULT_POISONED = -6,
    /**
     * A defect of the library: please report the message.
     */
    ANTUMBRA_RESULT_PANIC = -7,
    /**
     * There is not enough memory.
     */
    ANTUMBRA_RESULT_NO_MEMORY = -8,
    /**
     * The program was compiled with another version of the interface.
     */
    ANTUMBRA_RESULT_ABI_VERSION = -9,
    /**
     * The device lacks something that is needed.
     */
    ANTUMBRA_RESULT_UNSUPPORTED = -10,
    /**
     * The Vulkan device is lost: destroy it and all that was made on it.
     */
    ANTUMBRA_RESULT_DEVICE_LOST = -11,
    /**
     * A call of Vulkan failed; the message names it.
     */
    ANTUMBRA_RESULT_VULKAN = -12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum AntumbraResult AntumbraResult;
#else
typedef int32_t AntumbraResult;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * All objects of one user of the library. Several can live at the same time.
 */
typedef struct AntumbraContext AntumbraContext;

/**
 * Takes a message of a level (`ANTUMBRA_LOG_..`). `message` is UTF-8 with a 0 at the end, valid
 * during the call. It is called on the thread that called the library, during that call, and must
 * not call the library.
 */
typedef void (*AntumbraLogCallback)(void *user,
                                    uint32_t level,
                                    const char *message);

/**
 * The options of a context.
 */
typedef struct AntumbraContextDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * `ANTUMBRA_ABI_VERSION`, as the caller was compiled.
     */
    uint32_t abi_version;
    /**
     * The function that takes messages; null for none. Default: null.
     */
    AntumbraLogCallback log;
    /**
     * The first argument of `log`. Default: null.
     */
    void *log_user;
    /**
     * The last level that is passed on, `ANTUMBRA_LOG_ERROR` to `ANTUMBRA_LOG_DEBUG`. Default:
     * `ANTUMBRA_LOG_WARN`.
     */
    uint32_t log_level;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} AntumbraContextDesc;

/**
 * The message of a call that failed, in memory of the caller.
 */
typedef struct AntumbraError {
    /**
     * Size of this struct in bytes, set by the caller. A caller who wants less text may have a
     * smaller struct.
     */
    uint32_t struct_size;
    /**
     * The result of the call, an `AntumbraResult`.
     */
    int32_t result;
    /**
     * The reason and what to do, in UTF-8 with a 0 at the end; empty after a success.
     */
    char message[504];
} AntumbraError;

/**
 * The options of a culler.
 */
typedef struct AntumbraCullerDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The ways to test boxes that the host has besides occlusion queries: `ANTUMBRA_HAS_..`.
     * Default: 0.
     */
    uint32_t testers;
    /**
     * The most samples with which a box or an object counts as hidden. Above 0 the image is not
     * exact, and all tests are queries that count. Default: 0.
     */
    uint32_t sample_threshold;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The seed of the random intervals between tests; equal seeds and inputs make equal plans.
     * Default: 0.
     */
    uint64_t seed;
} AntumbraCullerDesc;

/**
 * The culler of one view of one hierarchy, with what it knows from earlier frames.
 */
typedef struct AntumbraCuller {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraCuller;

/**
 * A hierarchy of bounding volumes.
 */
typedef struct AntumbraHierarchy {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraHierarchy;

/**
 * The identity of a query, to be given back with its answer as it is.
 */
typedef struct AntumbraQueryTag {
    /**
     * The frame of the query, as the culler counts.
     */
    uint64_t frame;
    /**
     * The node that is tested.
     */
    uint32_t node;
    /**
     * The generation of the hierarchy that the node belongs to.
     */
    uint32_t generation;
    /**
     * An `ANTUMBRA_QUERY_..`.
     */
    uint32_t kind;
    /**
     * The most samples that count as none.
     */
    uint32_t sample_threshold;
} AntumbraQueryTag;

/**
 * The result of a query. It may come late, never, twice, and in any order.
 */
typedef struct AntumbraAnswer {
    /**
     * The tag, as in the plan.
     */
    struct AntumbraQueryTag tag;
    /**
     * Samples that passed; where queries are not precise, any number but 0 for "some".
     */
    uint32_t samples;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} AntumbraAnswer;

/**
 * The view of one frame: the host's matrix, with its jitter, and the image that is drawn.
 */
typedef struct AntumbraViewDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Steps of the sub-pixel grid as a power of two: `VkPhysicalDeviceLimits`'
     * `subPixelPrecisionBits`, or more where positions are more precise.
     */
    uint32_t sub_pixel_bits;
    /**
     * World to clip space as shaders multiply it with positions, column by column; depth from 0 to
     * 1.
     */
    float clip_from_world[16];
    /**
     * Width of the image (pixels), above 0.
     */
    uint32_t width;
    /**
     * Height of the image (pixels), above 0.
     */
    uint32_t height;
    /**
     * The direction in which depths grow: an `ANTUMBRA_DEPTH_..`. Default:
     * `ANTUMBRA_DEPTH_REVERSED`.
     */
    uint32_t depth;
    /**
     * The direction of y: an `ANTUMBRA_CLIP_Y_..`. Default: `ANTUMBRA_CLIP_Y_DOWN`.
     */
    uint32_t clip_y;
} AntumbraViewDesc;

/**
 * The input of a plan.
 */
typedef struct AntumbraPlanDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_STRATEGY_..`.
     */
    uint32_t strategy;
    /**
     * The view.
     */
    const struct AntumbraViewDesc *view;
    /**
     * The most occlusion queries of the plan; leaves for which none is left are drawn. Default:
     * 4096.
     */
    size_t query_budget;
} AntumbraPlanDesc;

/**
 * A leaf to draw.
 */
typedef struct AntumbraDraw {
    /**
     * The leaf.
     */
    uint32_t leaf;
    /**
     * Its object.
     */
    uint32_t object;
    /**
     * The number of its query in `queries`: draw it within one. `ANTUMBRA_NO_QUERY` for none.
     */
    uint32_t query;
} AntumbraDraw;

/**
 * An axis-aligned box in world space (metres). Coordinates are finite and at most 1e15, and no
 * minimum is above its maximum.
 */
typedef struct AntumbraAabb {
    /**
     * The corner with the smallest coordinates.
     */
    float min[3];
    /**
     * The corner with the largest coordinates.
     */
    float max[3];
} AntumbraAabb;

/**
 * A box to test against the depth of all that was drawn before.
 */
typedef struct AntumbraTest {
    /**
     * The identity of its query.
     */
    struct AntumbraQueryTag tag;
    /**
     * The box, enlarged by what rounding may lose.
     */
    struct AntumbraAabb bounds;
    /**
     * The first of the leaves to draw in this frame if the box shows.
     */
    uint32_t first_leaf;
    /**
     * The number of these leaves; may be 0.
     */
    uint32_t leaf_count;
    /**
     * An `ANTUMBRA_TESTER_..`: the mechanism that the plan counts with. All give the same result.
     */
    uint32_t tester;
    /**
     * The depth of the node in the hierarchy, for debug views.
     */
    uint32_t level;
} AntumbraTest;

/**
 * A range of tests that are made before the draws that they reveal.
 */
typedef struct AntumbraRound {
    /**
     * The first test.
     */
    uint32_t first_test;
    /**
     * The number of tests, above 0.
     */
    uint32_t test_count;
} AntumbraRound;

/**
 * The draws and tests of a frame.
 *
 * In this order: clear the depth; draw `draws`, those with a query within an occlusion query; then
 * for each of `rounds`: test its boxes against the depth so far, front faces only, without writing
 * depth; a box shows if more samples than its `sample_threshold` pass; draw the leaves of the
 * boxes that show. Every object whose box meets the frustum is in exactly one place.
 *
 * The arrays belong to the culler and are valid until the next call with it.
 */
typedef struct AntumbraFramePlan {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Nodes that the plan looked at: its work.
     */
    uint32_t nodes_visited;
    /**
     * The planned frame: 1 for the first of a culler.
     */
    uint64_t frame;
    /**
     * The leaves to draw at once, front to back.
     */
    const struct AntumbraDraw *draws;
    /**
     * The number of `draws`.
     */
    size_t draw_count;
    /**
     * The queries of `draws`.
     */
    const struct AntumbraQueryTag *queries;
    /**
     * The number of `queries`.
     */
    size_t query_count;
    /**
     * The boxes to test, front to back.
     */
    const struct AntumbraTest *tests;
    /**
     * The number of `tests`.
     */
    size_t test_count;
    /**
     * Ranges of `tests`, one after the other.
     */
    const struct AntumbraRound *rounds;
    /**
     * The number of `rounds`.
     */
    size_t round_count;
} AntumbraFramePlan;

/**
 * The objects of a new hierarchy.
 */
typedef struct AntumbraHierarchyDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The boxes of the objects; the position of a box is its object's id. They are copied.
     */
    const struct AntumbraAabb *boxes;
    /**
     * The number of boxes.
     */
    size_t box_count;
    /**
     * The number of objects for which there is room before everything must be built again; less
     * than `box_count` counts as `box_count`. Default: 0.
     */
    size_t capacity;
} AntumbraHierarchyDesc;

/**
 * The leaves of a hierarchy in the order of plans: objects near each other in space are so here,
 * and what one test decides about is one range of leaves.
 */
typedef struct AntumbraLeaves {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The object of each leaf; `ANTUMBRA_NO_OBJECT` where there is none. Valid until the hierarchy
     * changes.
     */
    const uint32_t *objects;
    /**
     * The number of leaves.
     */
    size_t count;
    /**
     * A number that changes with any entry of `objects`.
     */
    uint64_t revision;
} AntumbraLeaves;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns the version of the interface that the library was compiled with.
 */
uint32_t antumbra_abi_version(void);

/**
 * Creates a context.
 *
 * # Safety
 * The rules of the interface; `desc.log` may be called on each thread that uses the context, until
 * it is destroyed.
 */
AntumbraResult antumbra_context_create(const struct AntumbraContextDesc *desc,
                                       struct AntumbraContext **context,
                                       struct AntumbraError *error);

/**
 * Destroys a context and all that is left in it. Null is no error.
 *
 * # Safety
 * The rules of the interface; no other call uses the context, now or later.
 */
AntumbraResult antumbra_context_destroy(struct AntumbraContext *context,
                                        struct AntumbraError *error);

/**
 * Creates a culler that knows nothing yet.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_culler_create(const struct AntumbraContext *context,
                                      const struct AntumbraCullerDesc *desc,
                                      struct AntumbraCuller *culler,
                                      struct AntumbraError *error);

/**
 * Destroys a culler. A handle of 0 is no error.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_culler_destroy(const struct AntumbraContext *context,
                                       struct AntumbraCuller culler,
                                       struct AntumbraError *error);

/**
 * Forgets all that is known, after a change that makes it worthless.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_culler_reset(const struct AntumbraContext *context,
                                     struct AntumbraCuller culler,
                                     struct AntumbraError *error);

/**
 * Takes answers to queries of earlier plans: in any order, late, twice, or never. Those that fit
 * nothing any more are ignored. If one is none at all, nothing is taken.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_culler_ingest(const struct AntumbraContext *context,
                                      struct AntumbraCuller culler,
                                      struct AntumbraHierarchy hierarchy,
                                      const struct AntumbraAnswer *answers,
                                      size_t count,
                                      struct AntumbraError *error);

/**
 * Plans the next frame.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_culler_plan(const struct AntumbraContext *context,
                                    struct AntumbraCuller culler,
                                    struct AntumbraHierarchy hierarchy,
                                    const struct AntumbraPlanDesc *desc,
                                    struct AntumbraFramePlan *plan,
                                    struct AntumbraError *error);

/**
 * Creates a hierarchy over the boxes of objects.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_create(const struct AntumbraContext *context,
                                         const struct AntumbraHierarchyDesc *desc,
                                         struct AntumbraHierarchy *hierarchy,
                                         struct AntumbraError *error);

/**
 * Destroys a hierarchy. A handle of 0 is no error.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_destroy(const struct AntumbraContext *context,
                                          struct AntumbraHierarchy hierarchy,
                                          struct AntumbraError *error);

/**
 * Moves objects: object `objects[i]` has the box `boxes[i]` from now on. After an error those
 * before the one that the message names have moved.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_move(const struct AntumbraContext *context,
                                       struct AntumbraHierarchy hierarchy,
                                       const uint32_t *objects,
                                       const struct AntumbraAabb *boxes,
                                       size_t count,
                                       struct AntumbraError *error);

/**
 * Adds objects and writes their ids, which may be those of objects that were removed. Without room
 * left everything is built again with twice the room; ids and histories stay. After an error
 * `added` says how many objects were added.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_insert(const struct AntumbraContext *context,
                                         struct AntumbraHierarchy hierarchy,
                                         const struct AntumbraAabb *boxes,
                                         size_t count,
                                         uint32_t *objects,
                                         size_t *added,
                                         struct AntumbraError *error);

/**
 * Removes objects. Their ids are given to objects that are added later. After an error those
 * before the one that the message names were removed.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_remove(const struct AntumbraContext *context,
                                         struct AntumbraHierarchy hierarchy,
                                         const uint32_t *objects,
                                         size_t count,
                                         struct AntumbraError *error);

/**
 * Rebuilds parts that moving has worn, a bounded number of leaves. To be called once per frame,
 * after the frame's other changes, if objects move.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_update(const struct AntumbraContext *context,
                                         struct AntumbraHierarchy hierarchy,
                                         struct AntumbraError *error);

/**
 * Writes the objects of all leaves, in the order that plans refer to.
 *
 * # Safety
 * The rules of the interface.
 */
AntumbraResult antumbra_hierarchy_leaves(const struct AntumbraContext *context,
                                         struct AntumbraHierarchy hierarchy,
                                         struct AntumbraLeaves *leaves,
                                         struct AntumbraError *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ANTUMBRA_H */
