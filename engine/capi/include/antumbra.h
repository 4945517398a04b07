/* Antumbra: exact occlusion culling that never waits for the GPU. The C interface.
 *
 * Made from the sources of antumbra-capi by cbindgen: do not edit.
 *
 * Sections:
 * 1. Version, results, log and contexts
 * 2. Decisions alone: boxes in, plan out, answers in. Any graphics API.
 * 3. Devices                                                             (Vulkan)
 * 4. The self-test and the costs of a device                             (Vulkan)
 * 5. The executor: tests and draws in your command buffer                (Vulkan)
 * 6. The renderer: meshes or files in, images out                        (Vulkan)
 *
 * Words: the host is the program that calls the library. `AntumbraCamera::width` is the field
 * `width` of the struct AntumbraCamera. An `ANTUMBRA_DEPTH_..` is one of the constants that begin
 * so. A set of such constants is their bits, joined by `|`.
 *
 * Rules of all functions:
 * - The result is ANTUMBRA_RESULT_OK or an error. An error leaves the outputs unchanged, unless the
 *   function says otherwise; the message in the AntumbraError says what to do. The pointer to the
 *   AntumbraError may be null.
 * - Initialise every struct that has a struct_size with ANTUMBRA_INIT(its type), including
 *   AntumbraError and structs for output: struct_size becomes the sizeof, and all other fields
 *   become 0. Then set the fields that you need; every other field must stay 0. 0 means the
 *   default, which the comment of the field names; a required field has no default. To ask for none
 *   where the default is not none, pass the constant that the comment names, such as
 *   ANTUMBRA_NO_QUERIES. The structs that the library passes to callbacks are filled in by the
 *   library.
 * - Structs without a struct_size are plain values: a box, a vertex, an answer. Set all their
 *   fields.
 * - A reserved field must be 0 in input, and is 0 in output.
 * - A pointer and a count describe an array; null is allowed if the count is 0. An array of structs
 *   with a struct_size is an array of pointers to them. Input and output arrays must not overlap.
 * - Input is copied during the call, unless the comment says otherwise.
 * - Every object belongs to a context. A handle that was destroyed, or belongs to another context
 *   or kind of object, is an error. So is a handle of 0, unless the comment says otherwise.
 * - Any function may be called on any thread. A call that changes an object must not overlap any
 *   other call with this object; calls that only read it may overlap. The result of a conflict is
 *   ANTUMBRA_RESULT_BUSY, and no call waits. Call antumbra_context_destroy after all other calls
 *   have returned.
 * - A bug in the library becomes ANTUMBRA_RESULT_PANIC. Later calls with the object that was being
 *   changed return ANTUMBRA_RESULT_POISONED, except its destruction.
 * - Callbacks must return: no exception and no longjmp may leave them.
 * - The interface has no global state of its own: contexts are independent of each other.
 * - Where a comment says that the caller promises something, the library cannot check it, and the
 *   behaviour is undefined otherwise.
 */

#ifndef ANTUMBRA_H
#define ANTUMBRA_H

#include <stddef.h>
#include <stdint.h>

/* Sections 3 to 6 need Vulkan: include <antumbra_vulkan.h>, or <vulkan/vulkan.h> before this. */
#if defined(VULKAN_CORE_H_) && !defined(ANTUMBRA_VULKAN)
#define ANTUMBRA_VULKAN
#endif
#ifdef ANTUMBRA_VULKAN
#include <vulkan/vulkan_core.h>
#endif

/* The initial value of a struct: its struct_size, and 0 in all other fields.
 *     AntumbraPlanDesc desc = ANTUMBRA_INIT(AntumbraPlanDesc);
 * In C it is an initialiser; to assign it later, write a cast before it:
 *     desc = (AntumbraPlanDesc)ANTUMBRA_INIT(AntumbraPlanDesc); */
#ifdef __cplusplus
extern "C++" {
namespace antumbra {
template <typename T> constexpr T init() {
    T value = {};
    value.struct_size = static_cast<uint32_t>(sizeof(T));
    return value;
}
}
}
#define ANTUMBRA_INIT(type) antumbra::init<type>()
#else
#define ANTUMBRA_INIT(type) {.struct_size = (uint32_t)sizeof(type)}
#endif

/* A budget of no occlusion queries: objects that no other tester tests are drawn. */
#define ANTUMBRA_NO_QUERIES SIZE_MAX

/* A number of clips: all clips of a file that can play together. */
#define ANTUMBRA_ALL_CLIPS SIZE_MAX

#ifdef __cplusplus
extern "C" {
#endif

/* =================================================================================================
 * 1. Version, results, log and contexts
 * A program creates a context first: it owns all other objects, and passes messages on.
 * ============================================================================================== */

/**
 * The version of the interface: its declarations and their meaning. It grows by one with each
 * change that breaks compiled programs. New functions, and new fields at the end of structs with a
 * `struct_size`, do not change it.
 */
#define ANTUMBRA_ABI_VERSION 1

/**
 * The default: warnings and errors.
 */
#define ANTUMBRA_LOG_DEFAULT 0

/**
 * An error: something could not be done.
 */
#define ANTUMBRA_LOG_ERROR 1

/**
 * A warning: something works, but not as well as it could.
 */
#define ANTUMBRA_LOG_WARN 2

/**
 * A decision worth knowing, such as the way a device is used.
 */
#define ANTUMBRA_LOG_INFO 3

/**
 * Details for debugging.
 */
#define ANTUMBRA_LOG_DEBUG 4

/**
 * The result of a call.
 */
enum AntumbraResult
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The call succeeded.
     */
    ANTUMBRA_RESULT_OK = 0,
    /**
     * A required pointer is null, or a pointer is not aligned.
     */
    ANTUMBRA_RESULT_BAD_POINTER = -1,
    /**
     * A `struct_size` does not belong to any version of the struct, or a field that this version
     * of the library does not know is not 0.
     */
    ANTUMBRA_RESULT_BAD_STRUCT_SIZE = -2,
    /**
     * A value is outside its range, or does not fit other values.
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
     * An earlier call that was changing the object ended with `ANTUMBRA_RESULT_PANIC`: destroy the
     * object.
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
     * The device or the machine lacks something that is needed.
     */
    ANTUMBRA_RESULT_UNSUPPORTED = -10,
    /**
     * The Vulkan device is lost: destroy it and everything that was created on it.
     */
    ANTUMBRA_RESULT_DEVICE_LOST = -11,
    /**
     * A call of Vulkan failed; the message names it.
     */
    ANTUMBRA_RESULT_VULKAN = -12,
    /**
     * A file that cannot be read or shown; the message names the file, the object in it, and the
     * reason.
     */
    ANTUMBRA_RESULT_BAD_FILE = -13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum AntumbraResult AntumbraResult;
#else
typedef int32_t AntumbraResult;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The owner of all objects of one user of the library. Several contexts can exist at once.
 */
typedef struct AntumbraContext AntumbraContext;

/**
 * Takes a message of a level (`ANTUMBRA_LOG_..`). `message` is UTF-8 with a 0 at the end, valid
 * during the call. The callback runs on the thread that called the library, during that call, and
 * must not call the library.
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
     * Required: the `ANTUMBRA_ABI_VERSION` that the caller was compiled with.
     */
    uint32_t abi_version;
    /**
     * The function that takes messages. Default: null, for none.
     */
    AntumbraLogCallback log;
    /**
     * The first argument of `log`. Default: null.
     */
    void *log_user;
    /**
     * The least severe level that is passed on, `ANTUMBRA_LOG_ERROR` to `ANTUMBRA_LOG_DEBUG`. For
     * no messages at all, leave `log` null. Default: `ANTUMBRA_LOG_WARN`.
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
     * Size of this struct in bytes, set by the caller. A caller may use a smaller struct to get
     * less text.
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
 * Returns the version of the interface that the library was compiled with.
 */
uint32_t antumbra_abi_version(void);

/**
 * Creates a context.
 *
 * The caller promises that `desc.log` may be called on each thread that uses the context, until
 * the context is destroyed.
 */
AntumbraResult antumbra_context_create(const AntumbraContextDesc *desc,
                                       AntumbraContext **context,
                                       AntumbraError *error);

/**
 * Destroys a context and all objects in it. Null is not an error.
 *
 * The caller promises that no other call uses the context, now or later.
 */
AntumbraResult antumbra_context_destroy(AntumbraContext *context,
                                        AntumbraError *error);

/* =================================================================================================
 * 2. Decisions alone
 * The host has objects with boxes, in a hierarchy. Each leaf of it has one object or none;
 * plans name leaves, and antumbra_hierarchy_leaves says which objects they are. In each
 * frame a culler plans, for a camera, which leaves to draw at once, and which boxes to test
 * against the depth so far. If a box shows, its leaves are drawn, too. A tester is a way to
 * test a box: an occlusion query, or another one that the host has. The results of queries
 * go back to the culler in a later frame, as answers.
 * ============================================================================================== */

/**
 * Depth is 1 at the near plane, and 0 at the far plane or infinitely far away.
 */
#define ANTUMBRA_DEPTH_REVERSED 0

/**
 * Depth is 0 at the near plane, and 1 at the far plane or infinitely far away.
 */
#define ANTUMBRA_DEPTH_STANDARD 1

/**
 * The y axis of clip space points down, as in Vulkan.
 */
#define ANTUMBRA_CLIP_Y_DOWN 0

/**
 * The y axis of clip space points up: the host flips images by a viewport of negative height.
 */
#define ANTUMBRA_CLIP_Y_UP 1

/**
 * The object number of a leaf without an object.
 */
#define ANTUMBRA_NO_OBJECT UINT32_MAX

/**
 * The host can test by flags that fragments set. These tests take no queries.
 */
#define ANTUMBRA_HAS_FLAGS 1

/**
 * The host can test by a compute shader that reads the depth buffer.
 */
#define ANTUMBRA_HAS_COMPUTE 2

/**
 * Answers of earlier frames decide what is drawn first; tests in the same frame make it exact.
 */
#define ANTUMBRA_STRATEGY_ANTUMBRA 0

/**
 * Everything in the view frustum is drawn, nothing is tested: the reference.
 */
#define ANTUMBRA_STRATEGY_FRUSTUM 1

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
 * The value of `AntumbraDraw::query` for a draw without a query.
 */
#define ANTUMBRA_NO_QUERY UINT32_MAX

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
     * Default: null, with a `box_count` of 0.
     */
    const AntumbraAabb *boxes;
    /**
     * The number of boxes, up to 2^30. Default: 0.
     */
    size_t box_count;
    /**
     * The number of objects that fit before the hierarchy must grow, up to 2^30. A value below
     * `box_count` counts as `box_count`. Default: 0.
     */
    size_t capacity;
} AntumbraHierarchyDesc;

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
 * The leaves of a hierarchy, in the order that plans refer to. Objects near each other in space
 * are near each other in this order, and a test decides about one range of leaves.
 */
typedef struct AntumbraLeaves {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The object of each leaf; `ANTUMBRA_NO_OBJECT` for a leaf without one. Valid until objects
     * are added or removed, or the hierarchy is updated or rebuilt. Moves change nothing.
     */
    const uint32_t *objects;
    /**
     * The number of leaves.
     */
    size_t count;
    /**
     * A number that changes whenever an entry of `objects` changes.
     */
    uint64_t revision;
} AntumbraLeaves;

/**
 * The options of a culler.
 */
typedef struct AntumbraCullerDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The testers that the host has besides occlusion queries: a set of `ANTUMBRA_HAS_..`.
     * Default: 0, none.
     */
    uint32_t testers;
    /**
     * A box or an object counts as hidden if at most this number of samples pass. Above 0 the
     * image is not exact, and all tests are precise occlusion queries. Any number. Default: 0.
     */
    uint32_t sample_threshold;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The seed of the random intervals between tests; equal seeds and inputs make equal plans. Any
     * number. Default: 0.
     */
    uint64_t seed;
} AntumbraCullerDesc;

/**
 * The culler of one view of one hierarchy, with its history of earlier frames.
 */
typedef struct AntumbraCuller {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraCuller;

/**
 * The identity of a query. The host returns it unchanged with the answer.
 */
typedef struct AntumbraQueryTag {
    /**
     * The number of the frame, as the culler counts.
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
     * The box or object counts as hidden if at most this number of samples pass.
     */
    uint32_t sample_threshold;
} AntumbraQueryTag;

/**
 * The result of a query. Results may come late, twice, in any order, or never.
 */
typedef struct AntumbraAnswer {
    /**
     * The tag, as in the plan.
     */
    AntumbraQueryTag tag;
    /**
     * The number of samples that passed. If queries are not precise, any number above 0 means
     * "some".
     */
    uint32_t samples;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} AntumbraAnswer;

/**
 * The camera of one frame: the host's matrix, with its jitter, and the image that is drawn.
 */
typedef struct AntumbraCamera {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The number of fractional bits in the rasteriser's vertex positions (pixels):
     * `subPixelPrecisionBits` of `VkPhysicalDeviceLimits`. A rasteriser that does not snap
     * vertices to a grid takes the number of fractional bits that its positions always have. With
     * 32-bit floats this is 22 minus the logarithm to base 2 of the image's larger side, rounded
     * up: 12 for up to 1,024 pixels, 11 for up to 2,048. With 64-bit floats it is 24. A smaller
     * number is always safe, since boxes are then tested a little larger; a number that is too
     * large may lose a sample. Values above 24 count as 24. Default: 4, the minimum of Vulkan.
     */
    uint32_t sub_pixel_bits;
    /**
     * Required: the matrix from world to clip space, column by column, by which shaders multiply
     * positions. Depth is from 0 to 1.
     */
    float clip_from_world[16];
    /**
     * Required: width of the image (pixels).
     */
    uint32_t width;
    /**
     * Required: height of the image (pixels).
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
} AntumbraCamera;

/**
 * The input of a plan.
 */
typedef struct AntumbraPlanDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_STRATEGY_..`. Default: `ANTUMBRA_STRATEGY_ANTUMBRA`.
     */
    uint32_t strategy;
    /**
     * Required: the camera.
     */
    const AntumbraCamera *camera;
    /**
     * The most occlusion queries of the plan, any number, or `ANTUMBRA_NO_QUERIES`. Leaves for
     * which no query is left are drawn. Default: 4096.
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
     * The index in `queries` of the occlusion query around the draw; `ANTUMBRA_NO_QUERY` for none.
     */
    uint32_t query;
} AntumbraDraw;

/**
 * A box to test against the depth of all that was drawn before.
 */
typedef struct AntumbraTest {
    /**
     * The identity of its query.
     */
    AntumbraQueryTag tag;
    /**
     * The box, enlarged to make up for rounding errors.
     */
    AntumbraAabb bounds;
    /**
     * The first of the leaves to draw in this frame if the box shows.
     */
    uint32_t first_leaf;
    /**
     * The number of these leaves; may be 0.
     */
    uint32_t leaf_count;
    /**
     * An `ANTUMBRA_TESTER_..`: the mechanism that the plan assumes. All give the same result.
     */
    uint32_t tester;
    /**
     * The depth of the node in the hierarchy, for debug views.
     */
    uint32_t level;
} AntumbraTest;

/**
 * A range of tests that can run together, before the draws that they reveal.
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
 * The host clears the depth and draws `draws`, those with a query inside an occlusion query. Then,
 * for each of `rounds`, it tests the boxes of the round against the depth so far, and draws the
 * leaves of the boxes that show. A test renders front faces only, compares with "as near or
 * nearer" (`>=` for reversed depth), and does not write depth. Boxes around the eye, or cut by the
 * near plane, are not tested: their objects are drawn. A box shows if more samples than its
 * `sample_threshold` pass. Every object whose box meets the frustum appears once, in `draws` or as
 * a leaf of a test.
 *
 * The arrays belong to the culler and are valid until the next call with it.
 */
typedef struct AntumbraFramePlan {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The number of nodes that planning visited, a measure of its work.
     */
    uint32_t nodes_visited;
    /**
     * The planned frame: 1 for the first of a culler.
     */
    uint64_t frame;
    /**
     * The leaves to draw without a test, front to back.
     */
    const AntumbraDraw *draws;
    /**
     * The number of `draws`.
     */
    size_t draw_count;
    /**
     * The queries of `draws`.
     */
    const AntumbraQueryTag *queries;
    /**
     * The number of `queries`.
     */
    size_t query_count;
    /**
     * The boxes to test, front to back.
     */
    const AntumbraTest *tests;
    /**
     * The number of `tests`.
     */
    size_t test_count;
    /**
     * Consecutive ranges of `tests`.
     */
    const AntumbraRound *rounds;
    /**
     * The number of `rounds`.
     */
    size_t round_count;
} AntumbraFramePlan;

/**
 * Creates a hierarchy over the boxes of objects.
 */
AntumbraResult antumbra_hierarchy_create(const AntumbraContext *context,
                                         const AntumbraHierarchyDesc *desc,
                                         AntumbraHierarchy *hierarchy,
                                         AntumbraError *error);

/**
 * Destroys a hierarchy. A handle of 0 is not an error.
 */
AntumbraResult antumbra_hierarchy_destroy(const AntumbraContext *context,
                                          AntumbraHierarchy hierarchy,
                                          AntumbraError *error);

/**
 * Moves objects: object `objects[i]` has the box `boxes[i]` from now on. After an error the
 * objects before the one in the message have moved. The order of leaves does not change.
 */
AntumbraResult antumbra_hierarchy_move(const AntumbraContext *context,
                                       AntumbraHierarchy hierarchy,
                                       const uint32_t *objects,
                                       const AntumbraAabb *boxes,
                                       size_t count,
                                       AntumbraError *error);

/**
 * Adds objects and writes their ids, which may be those of objects that were removed. Ids and
 * histories of other objects stay. After an error nothing was added.
 *
 * The time depends on the number of added objects. If they do not fit
 * (`AntumbraHierarchyDesc::capacity`), the hierarchy grows to hold them and a further sixteenth of
 * all objects: 0.2 seconds for 10,000,000 objects. If their number reaches the number of existing
 * objects, everything is rebuilt: about a second per 1,000,000 objects.
 */
AntumbraResult antumbra_hierarchy_insert(const AntumbraContext *context,
                                         AntumbraHierarchy hierarchy,
                                         const AntumbraAabb *boxes,
                                         size_t count,
                                         uint32_t *objects,
                                         AntumbraError *error);

/**
 * Removes objects. Objects that are added later reuse their ids. After an error the objects before
 * the one in the message have been removed.
 */
AntumbraResult antumbra_hierarchy_remove(const AntumbraContext *context,
                                         AntumbraHierarchy hierarchy,
                                         const uint32_t *objects,
                                         size_t count,
                                         AntumbraError *error);

/**
 * Rebuilds subtrees that moving objects have degraded, up to a bounded number of leaves. If
 * objects move, call it once per frame, after the other changes of the frame.
 */
AntumbraResult antumbra_hierarchy_update(const AntumbraContext *context,
                                         AntumbraHierarchy hierarchy,
                                         AntumbraError *error);

/**
 * Rebuilds the whole hierarchy for the current boxes. After many insertions or long moves plans
 * become longer, though they stay correct; a rebuild makes them short again. Ids and histories
 * stay. Takes about a second per 1,000,000 objects, so it is meant for a pause of the program.
 */
AntumbraResult antumbra_hierarchy_rebuild(const AntumbraContext *context,
                                          AntumbraHierarchy hierarchy,
                                          AntumbraError *error);

/**
 * Writes the objects of all leaves, in the order that plans refer to. Call it again after
 * `antumbra_hierarchy_insert`, `_remove`, `_update` and `_rebuild`. Moves change nothing.
 */
AntumbraResult antumbra_hierarchy_leaves(const AntumbraContext *context,
                                         AntumbraHierarchy hierarchy,
                                         AntumbraLeaves *leaves,
                                         AntumbraError *error);

/**
 * Creates a culler without a history.
 */
AntumbraResult antumbra_culler_create(const AntumbraContext *context,
                                      const AntumbraCullerDesc *desc,
                                      AntumbraCuller *culler,
                                      AntumbraError *error);

/**
 * Destroys a culler. A handle of 0 is not an error.
 */
AntumbraResult antumbra_culler_destroy(const AntumbraContext *context,
                                       AntumbraCuller culler,
                                       AntumbraError *error);

/**
 * Clears the history of a culler, after a change that makes the history worthless.
 */
AntumbraResult antumbra_culler_reset(const AntumbraContext *context,
                                     AntumbraCuller culler,
                                     AntumbraError *error);

/**
 * Takes answers to queries of earlier plans. Answers may come in any order, late, twice, or never;
 * outdated answers are ignored. If an answer is invalid, no answer is taken.
 */
AntumbraResult antumbra_culler_ingest(const AntumbraContext *context,
                                      AntumbraCuller culler,
                                      AntumbraHierarchy hierarchy,
                                      const AntumbraAnswer *answers,
                                      size_t count,
                                      AntumbraError *error);

/**
 * Plans the next frame.
 */
AntumbraResult antumbra_culler_plan(const AntumbraContext *context,
                                    AntumbraCuller culler,
                                    AntumbraHierarchy hierarchy,
                                    const AntumbraPlanDesc *desc,
                                    AntumbraFramePlan *plan,
                                    AntumbraError *error);

#ifdef ANTUMBRA_VULKAN

/* =================================================================================================
 * 3. Devices
 * The host asks for the requirements, creates its VkDevice with them, and adopts it: with a
 * queue for a renderer, and without one for scenes of the executor. For a program without
 * Vulkan of its own, the library opens a device.
 * ============================================================================================== */

/**
 * The largest number of extensions that the library requests.
 */
#define ANTUMBRA_EXTENSIONS_MAX 8

/**
 * The validation layer is not loaded.
 */
#define ANTUMBRA_VALIDATION_OFF 0

/**
 * The validation layer checks the use of every call. Its messages are warnings in the log of the
 * context.
 */
#define ANTUMBRA_VALIDATION_CORE 1

/**
 * As `ANTUMBRA_VALIDATION_CORE`, and the layer finds hazards between commands.
 */
#define ANTUMBRA_VALIDATION_SYNCHRONIZATION 2

/**
 * The type of `vkGetInstanceProcAddr`.
 */
typedef PFN_vkVoidFunction (*AntumbraInstanceProcAddr)(VkInstance,
                                                       const char*);

/**
 * A physical device of a host.
 */
typedef struct AntumbraAdapterDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The version of Vulkan in the `VkApplicationInfo` of the instance, at least 1.3. Default:
     * `VK_API_VERSION_1_3`.
     */
    uint32_t api_version;
    /**
     * Required: `vkGetInstanceProcAddr`, through which the instance was made.
     */
    AntumbraInstanceProcAddr instance_proc_addr;
    /**
     * Required: the instance.
     */
    VkInstance instance;
    /**
     * Required: the physical device.
     */
    VkPhysicalDevice physical_device;
} AntumbraAdapterDesc;

/**
 * The features of a device, in structs of the host. Null counts as a struct with all features off:
 * `antumbra_requirements` then turns none of them on, and `antumbra_device_adopt` refuses the
 * device if one of them is needed. Features that the host turned on by other structs, such as
 * `VkPhysicalDeviceDynamicRenderingFeatures`, are set in these structs for the adoption.
 */
typedef struct AntumbraFeatures {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The features of Vulkan 1.0, of which some are needed. Default: null.
     */
    VkPhysicalDeviceFeatures *core;
    /**
     * The features of Vulkan 1.2, with their `sType`; a renderer needs some. Default: null.
     */
    VkPhysicalDeviceVulkan12Features *vulkan_12;
    /**
     * The features of Vulkan 1.3, with their `sType`, of which some are needed. Default: null.
     */
    VkPhysicalDeviceVulkan13Features *vulkan_13;
    /**
     * The features of `VK_EXT_conditional_rendering`, with their `sType`. Never needed. Default:
     * null.
     */
    VkPhysicalDeviceConditionalRenderingFeaturesEXT *conditional_rendering;
} AntumbraFeatures;

/**
 * The requirements of the library on a physical device, besides features.
 */
typedef struct AntumbraRequirements {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The lowest version of Vulkan for instance and device.
     */
    uint32_t api_version;
    /**
     * The flags of the queue family whose command buffers are recorded into, or that a renderer
     * submits to.
     */
    VkQueueFlags queue_flags;
    /**
     * The first queue family with these flags; `UINT32_MAX` if there is none.
     */
    uint32_t queue_family;
    /**
     * The number of extensions to turn on, all of which the device has.
     */
    uint32_t extension_count;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The names of the extensions, valid as long as the library is loaded.
     */
    const char *extensions[ANTUMBRA_EXTENSIONS_MAX];
} AntumbraRequirements;

/**
 * Takes or releases the host's lock of a queue. The callback runs on the thread that renders, and
 * must not call the library.
 */
typedef void (*AntumbraQueueLockCallback)(void *user);

/**
 * A queue that host and renderer share.
 */
typedef struct AntumbraQueueDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * Required: the queue.
     */
    VkQueue queue;
    /**
     * Called before each submit; returns when no other thread uses the queue. Default: null, if
     * the host uses the queue only on the thread that renders.
     */
    AntumbraQueueLockCallback lock;
    /**
     * Called after each submit; lets other threads use the queue again. Default: null, as `lock`.
     */
    AntumbraQueueLockCallback unlock;
    /**
     * The first argument of both. Default: null.
     */
    void *user;
} AntumbraQueueDesc;

/**
 * A device that a host created and still owns.
 */
typedef struct AntumbraDeviceDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The queue family of the command buffers that are recorded into, or of `queue`. Default: 0,
     * the first one.
     */
    uint32_t queue_family;
    /**
     * Required: the physical device.
     */
    const AntumbraAdapterDesc *adapter;
    /**
     * Required: the device.
     */
    VkDevice device;
    /**
     * Required: the features that are on.
     */
    const AntumbraFeatures *features;
    /**
     * The names of the extensions that are on, and `VK_EXT_debug_utils` if the instance has it:
     * then all Vulkan objects get names for debuggers. Names that the library does not know are
     * ignored. Default: null, with an `extension_count` of 0.
     */
    const char *const *extensions;
    /**
     * The number of extensions. Default: 0.
     */
    size_t extension_count;
    /**
     * The callbacks for the host memory of Vulkan objects, called on any thread until the device
     * and everything that was created on it are destroyed. Default: null, for none.
     */
    const VkAllocationCallbacks *allocation_callbacks;
    /**
     * The pipeline cache. Default: `VK_NULL_HANDLE`, for a cache of the library.
     */
    VkPipelineCache pipeline_cache;
    /**
     * The queue that a renderer submits to, of the family `queue_family`. Default: null, for a
     * device on which scenes are recorded into command buffers of the host.
     */
    const AntumbraQueueDesc *queue;
    /**
     * The most bytes of Vulkan memory that the library allocates on the device, in blocks that
     * buffers and images share. What does not fit fails with `ANTUMBRA_RESULT_NO_MEMORY`. Default:
     * 0, for no bound but that of the device.
     */
    uint64_t memory_budget_bytes;
} AntumbraDeviceDesc;

/**
 * A device of a host, which was adopted, or one that the library opened.
 */
typedef struct AntumbraDevice {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraDevice;

/**
 * The options of a device that the library opens.
 */
typedef struct AntumbraDeviceOpenDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_VALIDATION_..`. Default: `ANTUMBRA_VALIDATION_OFF`.
     */
    uint32_t validation;
    /**
     * A part of the name of the device or of its driver, in any case, or the index of the device,
     * in UTF-8 with a 0 at the end. Default: null, for the best device.
     */
    const char *name;
    /**
     * As `AntumbraDeviceDesc::memory_budget_bytes`. Default: 0, for no bound but that of the
     * device.
     */
    uint64_t memory_budget_bytes;
} AntumbraDeviceOpenDesc;

/**
 * Writes the requirements of the executor on a physical device. Turns on the features in the
 * structs of `features` that the executor needs or can use, and leaves all others as they are.
 * Call it before the device is created, with the structs that the device is created with. If the
 * result is `ANTUMBRA_RESULT_UNSUPPORTED`, the message names what is missing.
 *
 * The caller promises that the handles are valid.
 */
AntumbraResult antumbra_requirements(const AntumbraContext *context,
                                     const AntumbraAdapterDesc *adapter,
                                     const AntumbraFeatures *features,
                                     AntumbraRequirements *requirements,
                                     AntumbraError *error);

/**
 * Adopts the device of a host. The library never destroys objects of the host. A device with a
 * queue is for renderers, which submit to the queue. A device without a queue is for scenes:
 * nothing is submitted, and the host's frame numbers say which frames are over. If the result is
 * `ANTUMBRA_RESULT_UNSUPPORTED`, the message names what is not on.
 *
 * The caller promises that the handles belong together, and live until this device and everything
 * that is created on it are destroyed. All features and extensions that `desc` names are on.
 */
AntumbraResult antumbra_device_adopt(const AntumbraContext *context,
                                     const AntumbraDeviceDesc *desc,
                                     AntumbraDevice *device,
                                     AntumbraError *error);

/**
 * Declares that all frames are over on the GPU, or will never be submitted, so that their
 * resources can be freed. Call it before the device is destroyed; otherwise resources that the
 * last frames may still use are never freed, and the log says so. A device with a queue tracks its
 * frames itself: the result is `ANTUMBRA_RESULT_BAD_ARGUMENT`.
 *
 * The caller promises that this is true.
 */
AntumbraResult antumbra_device_finished(const AntumbraContext *context,
                                        AntumbraDevice device,
                                        AntumbraError *error);

/**
 * Ends the adoption of a device, which the host still owns, or closes a device that the library
 * opened. Scenes and renderers on it live on until they are destroyed. With a queue, this call or
 * the destruction of the last renderer waits until all submitted frames are over; the wait is
 * bounded. A handle of 0 is not an error.
 */
AntumbraResult antumbra_device_destroy(const AntumbraContext *context,
                                       AntumbraDevice device,
                                       AntumbraError *error);

/**
 * Opens a device for renderers, with a queue of its own, for a program that has none. The Vulkan
 * loader of the machine is loaded now, so the program needs to link none. The result is
 * `ANTUMBRA_RESULT_UNSUPPORTED` if there is no loader, driver or suitable device; the message says
 * what to install. `antumbra_device_destroy` closes the device. Headless: images are read by
 * `antumbra_renderer_read_image`.
 */
AntumbraResult antumbra_device_open(const AntumbraContext *context,
                                    const AntumbraDeviceOpenDesc *desc,
                                    AntumbraDevice *device,
                                    AntumbraError *error);

/* =================================================================================================
 * 4. The self-test and the costs of a device
 * Both are optional, and need a device that was adopted with a queue. The self-test finds
 * assumptions about the driver that do not hold; what rests on them can be disabled.
 * ============================================================================================== */

/**
 * Occlusion queries distinguish visible from hidden geometry, and count exactly.
 */
#define ANTUMBRA_ASSUMPTION_QUERY_COUNTS (1 << 0)

/**
 * The results of a frame are in mapped memory when the frame is over.
 */
#define ANTUMBRA_ASSUMPTION_LATE_RESULTS (1 << 1)

/**
 * A proxy covers every sample that its object covers.
 */
#define ANTUMBRA_ASSUMPTION_PROXY_COVERAGE (1 << 2)

/**
 * A fragment of a proxy is never farther away than the object's fragment at the same sample.
 */
#define ANTUMBRA_ASSUMPTION_PROXY_DEPTH (1 << 3)

/**
 * Fragment shaders with early tests write nothing where the depth test fails.
 */
#define ANTUMBRA_ASSUMPTION_EARLY_TESTS (1 << 4)

/**
 * Later commands see the writes of fragment shaders.
 */
#define ANTUMBRA_ASSUMPTION_FLAG_WRITES (1 << 5)

/**
 * Compute shaders read the depth that was drawn.
 */
#define ANTUMBRA_ASSUMPTION_COMPUTED_DEPTHS (1 << 6)

/**
 * Conditional rendering skips draws whose predicate is zero, and no others.
 */
#define ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING (1 << 7)

/**
 * Draws obey draw counts in a buffer.
 */
#define ANTUMBRA_ASSUMPTION_DRAW_COUNTS (1 << 8)

/**
 * Draws obey instance counts that a compute shader wrote.
 */
#define ANTUMBRA_ASSUMPTION_INSTANCE_COUNTS (1 << 9)

/**
 * Lists of commands that compute shaders wrote are drawn in their order.
 */
#define ANTUMBRA_ASSUMPTION_COMPACTED_LISTS (1 << 10)

/**
 * Of draws with equal depth the first one wins.
 */
#define ANTUMBRA_ASSUMPTION_DRAW_ORDER (1 << 11)

/**
 * Two passes give the same vertex the same depth.
 */
#define ANTUMBRA_ASSUMPTION_REPEATED_DEPTH (1 << 12)

/**
 * A walk with occlusion queries draws the same images as frustum culling.
 */
#define ANTUMBRA_ASSUMPTION_QUERIED_WALK (1 << 13)

/**
 * A walk with flags draws the same images as frustum culling.
 */
#define ANTUMBRA_ASSUMPTION_FLAGGED_WALK (1 << 14)

/**
 * A walk with the compute tester draws the same images as frustum culling.
 */
#define ANTUMBRA_ASSUMPTION_COMPUTED_WALK (1 << 15)

/**
 * The outcome of a self-test: sets of `ANTUMBRA_ASSUMPTION_..`. Assumptions in neither set hold.
 */
typedef struct AntumbraSelfTest {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The assumptions that do not hold, for `AntumbraRendererDesc::disabled` and
     * `AntumbraSceneDesc::disabled`.
     */
    uint32_t broken;
    /**
     * The assumptions that could not be tested, since the device lacks the features that rely on
     * them.
     */
    uint32_t not_tested;
    /**
     * 1 if a tester and a way to skip draws are left. 0 if only `ANTUMBRA_STRATEGY_FRUSTUM` draws
     * correct images, which renderers then use.
     */
    uint32_t can_cull;
} AntumbraSelfTest;

/**
 * The device and the image for which costs are measured.
 */
typedef struct AntumbraDeviceCostsDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: ways to skip draws that
     * rest on them are not measured. Default: 0, none.
     */
    uint32_t disabled;
    /**
     * Required: the device, which was adopted with a queue.
     */
    AntumbraDevice device;
    /**
     * Required: width of the image (pixels).
     */
    uint32_t width;
    /**
     * Required: height of the image (pixels).
     */
    uint32_t height;
    /**
     * Samples per pixel, 1 or 4. Default: 1.
     */
    uint32_t samples;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} AntumbraDeviceCostsDesc;

/**
 * The costs of tests and draws on a device, and of the ways to skip hidden draws.
 */
typedef struct AntumbraDeviceCosts {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraDeviceCosts;

/**
 * Tests the driver of a device that was adopted with a queue: small frames check each assumption
 * that exactness rests on. Takes about a second, and waits for the device repeatedly. Call it
 * before the first frame.
 *
 * The caller promises that the callbacks of the queue do what `AntumbraQueueDesc` says.
 */
AntumbraResult antumbra_self_test(const AntumbraContext *context,
                                  AntumbraDevice device,
                                  AntumbraSelfTest *outcome,
                                  AntumbraError *error);

/**
 * Measures the costs of tests, of draws, and of the ways to skip hidden draws, on a device that
 * was adopted with a queue. Scenes use the costs (`AntumbraSceneDesc::costs`) on the same device,
 * which may be adopted again without a queue. Takes half a second on a software driver, and waits
 * for the device repeatedly. Call it before the first frame.
 *
 * The caller promises that the callbacks of the queue do what `AntumbraQueueDesc` says.
 */
AntumbraResult antumbra_device_costs_measure(const AntumbraContext *context,
                                             const AntumbraDeviceCostsDesc *desc,
                                             AntumbraDeviceCosts *costs,
                                             AntumbraError *error);

/**
 * Destroys costs. Scenes that were created with them stay as they are. A handle of 0 is not an
 * error.
 */
AntumbraResult antumbra_device_costs_destroy(const AntumbraContext *context,
                                             AntumbraDeviceCosts costs,
                                             AntumbraError *error);

/* =================================================================================================
 * 5. The executor
 * A scene has the objects of the host, each with a box and with indexed indirect draws. A
 * draw is in a bucket: a pipeline of the host. A view of the scene has a history of its own.
 * In each frame antumbra_scene_record records the tests and draws of all views into a
 * command buffer of the host. Predication is the way that the GPU skips hidden draws. Frames
 * have numbers, and the host says which frames are over.
 * ============================================================================================== */

/**
 * The most colour images of a view.
 */
#define ANTUMBRA_COLOURS_MAX 8

/**
 * Hidden draws are skipped in the device's best way, or in the cheapest way if costs are given.
 */
#define ANTUMBRA_PREDICATION_BEST 0

/**
 * Hidden draws are skipped by conditional rendering.
 */
#define ANTUMBRA_PREDICATION_CONDITIONAL 1

/**
 * Hidden draws are skipped by draw counts.
 */
#define ANTUMBRA_PREDICATION_COUNTS 2

/**
 * Hidden draws are skipped by instance counts.
 */
#define ANTUMBRA_PREDICATION_INSTANCES 3

/**
 * Compacted lists hold only draws that show: one list per bucket and round, with a draw count.
 */
#define ANTUMBRA_PREDICATION_COMPACTED 4

/**
 * The host may submit a frame again before it is safe: commands reset its queries in each run.
 */
#define ANTUMBRA_RESUBMISSION_ALLOWED 0

/**
 * The host submits each frame at most once. The CPU resets its queries if the device's
 * `hostQueryReset` is on, since some drivers wait once per query that a command resets.
 */
#define ANTUMBRA_RESUBMISSION_NEVER 1

/**
 * The executor draws: it calls the host to bind what the draws of a bucket need.
 */
#define ANTUMBRA_DRAWS_BY_CALLBACK 0

/**
 * The host draws from lists, before and after the tests that the executor records.
 */
#define ANTUMBRA_DRAWS_BY_LISTS 1

/**
 * The attachments that all views of a scene are drawn to.
 */
typedef struct AntumbraAttachments {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Required: the format of the depth.
     */
    VkFormat depth_format;
    /**
     * Samples per pixel of all attachments. Default: `VK_SAMPLE_COUNT_1_BIT`.
     */
    VkSampleCountFlagBits samples;
    /**
     * The direction in which depths grow: an `ANTUMBRA_DEPTH_..`, the same as in cameras. Default:
     * `ANTUMBRA_DEPTH_REVERSED`.
     */
    uint32_t depth;
    /**
     * The number of colour attachments, up to `ANTUMBRA_COLOURS_MAX`. Default: 0.
     */
    uint32_t colour_count;
    /**
     * The subpass of `render_pass` that is drawn in. Default: 0.
     */
    uint32_t subpass;
    /**
     * The formats of the colours, in the order of their locations. The first `colour_count` of
     * them must be set. Default: `VK_FORMAT_UNDEFINED`, for the others.
     */
    VkFormat colour_formats[ANTUMBRA_COLOURS_MAX];
    /**
     * The render pass of a host that begins its renderings itself. Default: `VK_NULL_HANDLE`, for
     * dynamic rendering.
     */
    VkRenderPass render_pass;
} AntumbraAttachments;

/**
 * The options of a scene.
 */
typedef struct AntumbraSceneDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The most frames that may have begun and are not known to be over, up to 64. Default: 2.
     */
    uint32_t frames_in_flight;
    /**
     * Required: the device.
     */
    AntumbraDevice device;
    /**
     * Required: the attachments of all views.
     */
    const AntumbraAttachments *attachments;
    /**
     * The number of buckets, up to 65536. A bucket is a pipeline in a pass, in which draws of
     * objects are drawn together. Buckets are drawn in the order of their numbers. Default: 1.
     */
    uint32_t bucket_count;
    /**
     * The number of objects that fit before the scene must grow. Default: 0.
     */
    uint32_t object_capacity;
    /**
     * The number of draws that fit before they are uploaded again to larger buffers. Default: 0.
     */
    uint32_t draw_capacity;
    /**
     * An `ANTUMBRA_PREDICATION_..`. Default: `ANTUMBRA_PREDICATION_BEST`.
     */
    uint32_t predication;
    /**
     * An `ANTUMBRA_DRAWS_..`. Default: `ANTUMBRA_DRAWS_BY_CALLBACK`.
     */
    uint32_t draws;
    /**
     * An `ANTUMBRA_RESUBMISSION_..`. Default: `ANTUMBRA_RESUBMISSION_ALLOWED`.
     */
    uint32_t resubmission;
    /**
     * A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: what rests on them is not
     * used. Default: 0, none.
     */
    uint32_t disabled;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The measured costs of the same physical device. With them, the scene skips hidden draws in
     * the cheapest way for `object_capacity` objects, and leaves out tests that cost more than
     * they are expected to save. Default: 0, none: everything that may be hidden is tested.
     */
    AntumbraDeviceCosts costs;
} AntumbraSceneDesc;

/**
 * The objects of a host on its device.
 */
typedef struct AntumbraScene {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraScene;

/**
 * An object that is added.
 */
typedef struct AntumbraObject {
    /**
     * The box around everything that the object draws.
     */
    AntumbraAabb bounds;
    /**
     * The index of its first draw in the array of draws.
     */
    uint32_t first_draw;
    /**
     * The number of its draws.
     */
    uint32_t draw_count;
} AntumbraObject;

/**
 * A draw of an object: an indexed indirect command in a bucket.
 */
typedef struct AntumbraObjectDraw {
    /**
     * The bucket.
     */
    uint32_t bucket;
    /**
     * As in `VkDrawIndexedIndirectCommand`.
     */
    uint32_t index_count;
    /**
     * As in `VkDrawIndexedIndirectCommand`; any number.
     */
    uint32_t instance_count;
    /**
     * As in `VkDrawIndexedIndirectCommand`.
     */
    uint32_t first_index;
    /**
     * As in `VkDrawIndexedIndirectCommand`.
     */
    int32_t vertex_offset;
    /**
     * As in `VkDrawIndexedIndirectCommand`.
     */
    uint32_t first_instance;
} AntumbraObjectDraw;

/**
 * A view of a scene, with its history of earlier frames.
 */
typedef struct AntumbraView {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraView;

/**
 * The counts of the newest frame of a view whose results are known.
 */
typedef struct AntumbraViewStats {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The frame, counted from 1 in its view; 0 if none is known.
     */
    uint64_t frame;
    /**
     * The objects that the GPU drew.
     */
    uint64_t objects;
    /**
     * The objects among them that a test revealed.
     */
    uint64_t revealed;
    /**
     * The occlusion queries in the newest plan of the view, which may be of a later frame.
     */
    uint64_t queries;
    /**
     * The boxes that the newest plan tests.
     */
    uint64_t tests;
    /**
     * An `ANTUMBRA_PREDICATION_..`: the way that hidden draws are skipped, unless the host draws
     * from lists.
     */
    uint32_t predication;
    /**
     * 1 if costs decide which boxes are tested, and by which tester; else 0.
     */
    uint32_t has_cost;
} AntumbraViewStats;

/**
 * The indexed indirect draws of one bucket: for `vkCmdDrawIndexedIndirectCount`, or
 * `vkCmdDrawIndexedIndirect` without a count.
 */
typedef struct AntumbraDrawList {
    /**
     * The bucket.
     */
    uint32_t bucket;
    /**
     * The largest number of commands, above 0: `VkDrawIndexedIndirectCommand`s without gaps.
     */
    uint32_t most;
    /**
     * The buffer of the commands.
     */
    VkBuffer commands;
    /**
     * The offset of the first command in bytes.
     */
    uint64_t commands_offset;
    /**
     * The buffer of the number of commands, 32 bits. Null if the device does not support draw
     * counts: then all `most` commands are drawn, and some of them are empty.
     */
    VkBuffer count;
    /**
     * The offset of the number in bytes.
     */
    uint64_t count_offset;
} AntumbraDrawList;

/**
 * The draws of a view in the newest frame, a list per bucket, in the order of their buckets.
 *
 * The order on the queue is: the visible draws, in renderings of the host that clear; the command
 * buffer of the frame; the revealed draws, in renderings that keep the contents. The buffers live
 * until the frame is over.
 */
typedef struct AntumbraDrawLists {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The draws that are assumed to be visible. Valid until the view is recorded again.
     */
    const AntumbraDrawList *visible;
    /**
     * The number of their lists.
     */
    size_t visible_count;
    /**
     * The draws that the tests of the frame reveal. Valid until the view is recorded again.
     */
    const AntumbraDrawList *revealed;
    /**
     * The number of their lists.
     */
    size_t revealed_count;
} AntumbraDrawLists;

/**
 * The state of an image where its use changes between another user and the executor.
 */
typedef struct AntumbraImageState {
    /**
     * The layout, which is not checked. `VK_IMAGE_LAYOUT_UNDEFINED` on entry discards the
     * contents; on exit it leaves the image in its layout as an attachment.
     */
    VkImageLayout layout;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The stages of the other user that access the image.
     */
    VkPipelineStageFlags2 stages;
    /**
     * The accesses of these stages.
     */
    VkAccessFlags2 access;
} AntumbraImageState;

/**
 * An image of the host that is drawn to: its first level and layer.
 */
typedef struct AntumbraImage {
    /**
     * The image.
     */
    VkImage image;
    /**
     * A 2D view of the image with all aspects of the format.
     */
    VkImageView view;
    /**
     * The format of the view.
     */
    VkFormat format;
    /**
     * The usage that the image was created with: `VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT` at
     * least for a depth, `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT` for a colour.
     * `VK_IMAGE_USAGE_TRANSFER_SRC_BIT` of a depth image allows tests by compute shaders.
     */
    VkImageUsageFlags usage;
    /**
     * The state before the first command of the executor.
     */
    AntumbraImageState entry;
    /**
     * The state after the last command of the executor.
     */
    AntumbraImageState exit;
} AntumbraImage;

/**
 * The images of a view in a frame.
 */
typedef struct AntumbraTargetDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The number of colour images: the number of the scene's colour attachments, or 0 if the host
     * begins its renderings itself. Default: 0.
     */
    uint32_t colour_count;
    /**
     * Required: the depth.
     */
    AntumbraImage depth;
    /**
     * The colours. Default: null, with a `colour_count` of 0.
     */
    const AntumbraImage *colours;
    /**
     * Required: width of all images (pixels). The library cannot check that the images are that
     * large.
     */
    uint32_t width;
    /**
     * Required: height of all images (pixels), as the width.
     */
    uint32_t height;
} AntumbraTargetDesc;

/**
 * A view in a frame.
 */
typedef struct AntumbraViewFrame {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_STRATEGY_..`. Default: `ANTUMBRA_STRATEGY_ANTUMBRA`.
     */
    uint32_t strategy;
    /**
     * Required: the view.
     */
    AntumbraView view;
    /**
     * Required: its camera.
     */
    const AntumbraCamera *camera;
    /**
     * Required: its images.
     */
    const AntumbraTargetDesc *target;
    /**
     * The most occlusion queries, any number, or `ANTUMBRA_NO_QUERIES`. Leaves for which no query
     * is left are drawn. Default: 4096.
     */
    size_t query_budget;
} AntumbraViewFrame;

/**
 * The draws that follow a call of `AntumbraBindCallback`.
 */
typedef struct AntumbraBinding {
    /**
     * Size of this struct in bytes, as the library was compiled.
     */
    uint32_t struct_size;
    /**
     * The bucket of the draws.
     */
    uint32_t bucket;
    /**
     * The command buffer.
     */
    VkCommandBuffer commands;
    /**
     * The view.
     */
    AntumbraView view;
} AntumbraBinding;

/**
 * Binds the pipeline, descriptor sets, vertex and index buffers for the indexed indirect draws of
 * a bucket that follow. Viewport and scissor cover the target, with y down. A host whose y axis
 * points up, or that draws to a part of the target, sets its own viewport and scissor here. The
 * callback must not leave a query or a conditional rendering open, and must not call the library
 * with this scene.
 *
 * Objects must be rasterised as boxes are: the vertex shader snaps positions to the grid of
 * sub-pixels as share/antumbra/snap.glsl does (its steps are half the size of the image times
 * `2^subPixelPrecisionBits`), and declares `gl_Position` as `invariant` if several passes must
 * agree. Compare depths with "as near or nearer" (`VK_COMPARE_OP_GREATER_OR_EQUAL` for reversed
 * depth). Otherwise an object that is seen edge-on may be missed.
 */
typedef void (*AntumbraBindCallback)(void *user,
                                     const AntumbraBinding *binding);

/**
 * A rendering that begins or ends.
 */
typedef struct AntumbraRendering {
    /**
     * Size of this struct in bytes, as the library was compiled.
     */
    uint32_t struct_size;
    /**
     * 1 for the first rendering of the view, which clears (colours to 0, unless the rendering is
     * the host's own); 0 for others, which keep the contents.
     */
    uint32_t is_first;
    /**
     * The command buffer.
     */
    VkCommandBuffer commands;
    /**
     * The view.
     */
    AntumbraView view;
} AntumbraRendering;

/**
 * Begins or ends a rendering of the host's own, such as a render pass object. Must not call the
 * library with this scene.
 */
typedef void (*AntumbraRenderingCallback)(void *user,
                                          const AntumbraRendering *rendering);

/**
 * A frame to be recorded.
 */
typedef struct AntumbraFrameDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The number of views. Default: 0.
     */
    uint32_t view_count;
    /**
     * The views, each at most once. Default: null, with a `view_count` of 0.
     */
    const AntumbraViewFrame *const *views;
    /**
     * Required: a primary command buffer that is being recorded, outside of renderings and
     * queries.
     */
    VkCommandBuffer commands;
    /**
     * Required: the number of this frame, above the numbers of all earlier frames on the device,
     * of other scenes, too.
     */
    uint64_t current;
    /**
     * The number of a frame: it and all earlier frames are over on the GPU, or will never be
     * submitted. The newest such frame is best. Below `current`, and never below the `safe` of an
     * earlier frame. Default: 0, none.
     */
    uint64_t safe;
    /**
     * Binds the state that draws need. Default: null, only for a host that draws from lists.
     */
    AntumbraBindCallback bind;
    /**
     * The first argument of all callbacks. Default: null.
     */
    void *user;
    /**
     * Begins a rendering. Default: null, for dynamic rendering to the images of the target.
     */
    AntumbraRenderingCallback begin_rendering;
    /**
     * Ends a rendering. Default: null, as `begin_rendering`.
     */
    AntumbraRenderingCallback end_rendering;
    /**
     * The most occlusion queries of all views together, any number, or `ANTUMBRA_NO_QUERIES`.
     * Views with more to test get the queries that other views leave. Default: 0, for a budget per
     * view.
     */
    size_t query_budget;
} AntumbraFrameDesc;

/**
 * Creates a scene without objects.
 */
AntumbraResult antumbra_scene_create(const AntumbraContext *context,
                                     const AntumbraSceneDesc *desc,
                                     AntumbraScene *scene,
                                     AntumbraError *error);

/**
 * Destroys a scene and its views. Resources that frames may still use are freed when these frames
 * are over. A handle of 0 is not an error.
 */
AntumbraResult antumbra_scene_destroy(const AntumbraContext *context,
                                      AntumbraScene scene,
                                      AntumbraError *error);

/**
 * Adds objects and writes their ids, which may be those of objects that were removed. After an
 * error nothing was added.
 *
 * The time depends on the number of added objects. If they do not fit
 * (`AntumbraSceneDesc::object_capacity`), the scene grows to hold them and a further sixteenth of
 * all objects, and the next frame uploads all objects to larger buffers. If their number reaches
 * the number of existing objects, everything is rebuilt: some seconds per 1,000,000 objects.
 */
AntumbraResult antumbra_scene_add(const AntumbraContext *context,
                                  AntumbraScene scene,
                                  const AntumbraObject *objects,
                                  size_t count,
                                  const AntumbraObjectDraw *draws,
                                  size_t draw_count,
                                  uint32_t *ids,
                                  AntumbraError *error);

/**
 * Removes objects. After an error the objects before the one in the message have been removed.
 */
AntumbraResult antumbra_scene_remove(const AntumbraContext *context,
                                     AntumbraScene scene,
                                     const uint32_t *objects,
                                     size_t count,
                                     AntumbraError *error);

/**
 * Moves objects: object `objects[i]` has the box `boxes[i]` from now on. The host itself gives the
 * new transform to its draws. After an error the objects before the one in the message have moved.
 */
AntumbraResult antumbra_scene_move(const AntumbraContext *context,
                                   AntumbraScene scene,
                                   const uint32_t *objects,
                                   const AntumbraAabb *boxes,
                                   size_t count,
                                   AntumbraError *error);

/**
 * Replaces the draws of an object.
 */
AntumbraResult antumbra_scene_set_draws(const AntumbraContext *context,
                                        AntumbraScene scene,
                                        uint32_t object,
                                        const AntumbraObjectDraw *draws,
                                        size_t draw_count,
                                        AntumbraError *error);

/**
 * Creates a view of a scene, without a history.
 */
AntumbraResult antumbra_view_create(const AntumbraContext *context,
                                    AntumbraScene scene,
                                    AntumbraView *view,
                                    AntumbraError *error);

/**
 * Destroys a view. A handle of 0 is not an error.
 */
AntumbraResult antumbra_view_destroy(const AntumbraContext *context,
                                     AntumbraScene scene,
                                     AntumbraView view,
                                     AntumbraError *error);

/**
 * Writes the counts of the newest frame of a view whose results are known.
 */
AntumbraResult antumbra_view_stats(const AntumbraContext *context,
                                   AntumbraScene scene,
                                   AntumbraView view,
                                   AntumbraViewStats *stats,
                                   AntumbraError *error);

/**
 * Writes the draw lists of a view in the newest frame, for a scene with `ANTUMBRA_DRAWS_BY_LISTS`.
 * Before the first frame there are no lists.
 */
AntumbraResult antumbra_view_lists(const AntumbraContext *context,
                                   AntumbraScene scene,
                                   AntumbraView view,
                                   AntumbraDrawLists *lists,
                                   AntumbraError *error);

/**
 * Records a frame of a scene into a command buffer of the host: changes of the scene, then draws
 * and tests of all views. Never waits, and never submits. If the host draws from lists, only tests
 * are recorded: the images must contain the visible draws when the command buffer executes.
 *
 * The host submits each frame once, in the order of the frame numbers. Other orders are allowed,
 * too. A frame that is never submitted has no effect: its answers are ignored. A frame may be
 * submitted twice, unless the scene has `ANTUMBRA_RESUBMISSION_NEVER`: both runs draw correct
 * images if a barrier or a semaphore orders them. A frame may be submitted after a later frame: it
 * then shows changed objects as the later frame left them. After an error the command buffer must
 * not be submitted, and the next frame needs a higher number.
 *
 * The caller promises: the command buffer belongs to the scene's device and to the queue family of
 * its `AntumbraDeviceDesc`. All frames up to `safe` are over. When the command buffer executes,
 * the images are in their `entry` states, and nothing else uses them until it is over.
 */
AntumbraResult antumbra_scene_record(const AntumbraContext *context,
                                     AntumbraScene scene,
                                     const AntumbraFrameDesc *desc,
                                     AntumbraError *error);

/* =================================================================================================
 * 6. The renderer
 * For a host without a renderer of its own: it passes meshes and objects, or the scene of a
 * file with its clips, and a camera per frame, and gets an image. The library submits to the
 * queue of the host, or of the device that it opened. Each view has a history of its own.
 * ============================================================================================== */

/**
 * A part that violates glTF is left out or repaired, a note names it, and the rest is shown.
 */
#define ANTUMBRA_BROKEN_PARTS_LEFT_OUT 0

/**
 * The file is refused at its first part that violates glTF.
 */
#define ANTUMBRA_BROKEN_PARTS_REFUSED 1

/**
 * The scene is where the file says.
 */
#define ANTUMBRA_SCENE_PLACE_AS_IN_FILE 0

/**
 * A scene far from the origin is moved there by whole metres, so that positions of parts and
 * cameras are not rounded. `AntumbraSceneFileInfo::origin` says by how many.
 */
#define ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN 1

/**
 * The camera that shows everything at rest, diagonally from the front and above.
 */
#define ANTUMBRA_CAMERA_OVERVIEW UINT32_MAX

/**
 * Tests that cost more than they are expected to save are left out, by a built-in table of costs
 * that the times of frames correct.
 */
#define ANTUMBRA_COST_MODEL_BUILT_IN 0

/**
 * Everything that may be hidden is tested.
 */
#define ANTUMBRA_COST_MODEL_OFF 1

/**
 * Tests that cost more than they are expected to save are left out, by costs that are measured
 * when the renderer is made; they also choose the predication mode.
 */
#define ANTUMBRA_COST_MODEL_MEASURED 2

/**
 * No shadows.
 */
#define ANTUMBRA_SHADOWS_OFF 0

/**
 * Shadow maps, which are kept until something in them changes.
 */
#define ANTUMBRA_SHADOWS_MAPS 1

/**
 * Stencil shadow volumes: hard edges, exact to the pixel. They need one sample per pixel, and the
 * features `depthClamp` and `fragmentStoresAndAtomics` of the device.
 */
#define ANTUMBRA_SHADOWS_VOLUMES 2

/**
 * A disk of samples as wide as the penumbra: 8 on its edge, and 56 more where these disagree.
 */
#define ANTUMBRA_SHADOW_FILTER_ADAPTIVE 0

/**
 * One sample: edges as wide as a texel.
 */
#define ANTUMBRA_SHADOW_FILTER_SINGLE 1

/**
 * Three by three samples.
 */
#define ANTUMBRA_SHADOW_FILTER_PCF3 2

/**
 * PCSS, whose width depends on the distance to the blocker: 8 samples find it, 12 filter.
 */
#define ANTUMBRA_SHADOW_FILTER_PCSS12 3

/**
 * All 64 samples of the disk, at every pixel.
 */
#define ANTUMBRA_SHADOW_FILTER_FIXED64 4

/**
 * As `ANTUMBRA_SHADOW_FILTER_PCSS12`, with 32 and 64 samples.
 */
#define ANTUMBRA_SHADOW_FILTER_PCSS64 5

/**
 * Samples are compared with the depth of the receiver's plane.
 */
#define ANTUMBRA_SHADOW_BIAS_PLANE 0

/**
 * The maps hold the surfaces that face away from the light, for closed meshes.
 */
#define ANTUMBRA_SHADOW_BIAS_BACK_FACES 1

/**
 * The maps hold depths halfway between fronts and backs, and all casters are drawn.
 */
#define ANTUMBRA_SHADOW_BIAS_MIDPOINT 2

/**
 * A map is drawn again only if something in it changed.
 */
#define ANTUMBRA_SHADOW_CACHING_CACHED 0

/**
 * Every map is drawn in every frame.
 */
#define ANTUMBRA_SHADOW_CACHING_UNCACHED 1

/**
 * Casters whose shadow cannot fall on something visible are left out. Needs one sample per pixel;
 * otherwise all casters are drawn.
 */
#define ANTUMBRA_CASTER_CULLING_CULLED 0

/**
 * All casters are drawn.
 */
#define ANTUMBRA_CASTER_CULLING_UNCULLED 1

/**
 * A file and the way to read it: `path`, or `bytes`.
 */
typedef struct AntumbraSceneFileDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_BROKEN_PARTS_..`. Default: `ANTUMBRA_BROKEN_PARTS_LEFT_OUT`.
     */
    uint32_t broken_parts;
    /**
     * The path of a .gltf, .glb, .stl or .obj file, in UTF-8 with a 0 at the end. Files that it
     * refers to are read from its folder. Default: null, for a file in memory.
     */
    const char *path;
    /**
     * The bytes of a .gltf or .glb file. Default: null, with a `byte_count` of 0.
     */
    const uint8_t *bytes;
    /**
     * The number of bytes. Default: 0.
     */
    size_t byte_count;
    /**
     * The folder of the files that `bytes` refer to, as `path`. Default: null, and then they must
     * not refer to files.
     */
    const char *folder;
    /**
     * An `ANTUMBRA_SCENE_PLACE_..`. Default: `ANTUMBRA_SCENE_PLACE_AS_IN_FILE`.
     */
    uint32_t place;
    /**
     * The factor of all light. Default: 0, for a factor of 1, with lights that are dimmed if they
     * would make most objects white.
     */
    float exposure;
    /**
     * The length of the unit of .stl and .obj files (metres). Default: 0, for a millimetre in .stl
     * and a metre in .obj files.
     */
    float unit;
    /**
     * Must be 0.
     */
    uint32_t reserved;
} AntumbraSceneFileDesc;

/**
 * A file of a scene, in memory: meshes, materials, textures, lights, cameras and clips.
 */
typedef struct AntumbraSceneFile {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraSceneFile;

/**
 * The contents of a file.
 */
typedef struct AntumbraSceneFileInfo {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The cameras.
     */
    uint32_t cameras;
    /**
     * The clips.
     */
    uint32_t clips;
    /**
     * The lights, with the numbers that `antumbra_renderer_set_light_shadow` takes. A file without
     * lights is lit by one.
     */
    uint32_t lights;
    /**
     * The notes: deviations from the file, and what is not shown.
     */
    uint32_t notes;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The objects, without transparent ones. Their ids in a renderer are their indices.
     */
    uint64_t objects;
    /**
     * The triangles of these objects.
     */
    uint64_t triangles;
    /**
     * The box around everything visible at rest (metres).
     */
    AntumbraAabb bounds;
    /**
     * The point of the file that is the origin of the scene (metres): 0 unless the scene was moved
     * by `ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN`.
     */
    double origin[3];
} AntumbraSceneFileInfo;

/**
 * A camera of a file.
 */
typedef struct AntumbraSceneFileCamera {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The width of its image divided by the height; 0 if the file does not say.
     */
    float aspect_ratio;
    /**
     * The name, in UTF-8 with a 0 at the end, valid until the file is destroyed.
     */
    const char *name;
} AntumbraSceneFileCamera;

/**
 * A clip of a file: an animation of its nodes.
 */
typedef struct AntumbraSceneFileClip {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The duration, after which it repeats (seconds).
     */
    float duration;
    /**
     * The name, in UTF-8 with a 0 at the end, valid until the file is destroyed.
     */
    const char *name;
} AntumbraSceneFileClip;

/**
 * A note about a file.
 */
typedef struct AntumbraSceneFileNote {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The object in the file and the reason, in UTF-8 with a 0 at the end, valid until the file is
     * destroyed.
     */
    const char *text;
} AntumbraSceneFileNote;

/**
 * A vertex of a mesh.
 */
typedef struct AntumbraVertex {
    /**
     * Position in the space of the mesh (metres); y is up.
     */
    float position[3];
    /**
     * Unit normal.
     */
    float normal[3];
    /**
     * Linear red, green and blue, 0 to 1; then the share of the object's tint, 0 to 1.
     */
    float colour[4];
} AntumbraVertex;

/**
 * A mesh that any number of objects may use. The library copies it.
 */
typedef struct AntumbraMeshDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * Required: the vertices.
     */
    const AntumbraVertex *vertices;
    /**
     * Required: the number of vertices.
     */
    size_t vertex_count;
    /**
     * Required: three indices of vertices for each triangle, counter-clockwise seen from outside.
     */
    const uint32_t *indices;
    /**
     * Required: the number of indices.
     */
    size_t index_count;
} AntumbraMeshDesc;

/**
 * A transform from the space of a mesh to the world.
 */
typedef struct AntumbraTransform {
    /**
     * The vectors that the x, y and z axis of the mesh become, then the position of its origin
     * (metres).
     */
    float columns[12];
} AntumbraTransform;

/**
 * An object: a mesh with a transform.
 */
typedef struct AntumbraMeshObject {
    /**
     * The mesh: its index in `AntumbraRendererDesc::meshes`, or the id that
     * `antumbra_renderer_add_meshes` wrote.
     */
    uint32_t mesh;
    /**
     * Linear red, green and blue of 8 bits each, red in the lowest byte. Multiplies the colours of
     * vertices, according to the share of each vertex.
     */
    uint32_t tint;
    /**
     * The transform.
     */
    AntumbraTransform transform;
} AntumbraMeshObject;

/**
 * A sun, the light of the sky, and the background. Colours are linear.
 */
typedef struct AntumbraSunlight {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Vector to the sun, of any length. Default: (0, 1, 0), straight up.
     */
    float towards_sun[3];
    /**
     * Light on surfaces that face the sun; finite, as all colours here. Default: 0, black.
     */
    float sun[3];
    /**
     * Light on surfaces that face up. Default: 0, black.
     */
    float ambient_above[3];
    /**
     * Light on surfaces that face down. Default: 0, black.
     */
    float ambient_below[3];
    /**
     * The colour of the background. Default: 0, black.
     */
    float sky[3];
} AntumbraSunlight;

/**
 * The options of shadows.
 */
typedef struct AntumbraShadowDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_SHADOWS_..`. Default: `ANTUMBRA_SHADOWS_OFF`.
     */
    uint32_t method;
    /**
     * An `ANTUMBRA_SHADOW_FILTER_..`, for maps. Default: `ANTUMBRA_SHADOW_FILTER_ADAPTIVE`.
     */
    uint32_t filter;
    /**
     * An `ANTUMBRA_SHADOW_BIAS_..`, for maps. Default: `ANTUMBRA_SHADOW_BIAS_PLANE`.
     */
    uint32_t bias;
    /**
     * An `ANTUMBRA_SHADOW_CACHING_..`, for maps. Default: `ANTUMBRA_SHADOW_CACHING_CACHED`.
     */
    uint32_t caching;
    /**
     * An `ANTUMBRA_CASTER_CULLING_..`. Default: `ANTUMBRA_CASTER_CULLING_CULLED`.
     */
    uint32_t culling;
    /**
     * The number of maps of the sun, 1 to 8. Each map reaches three times as far as the previous
     * one. Default: 4.
     */
    uint32_t cascades;
    /**
     * The side of a map of the sun in texels, a power of two of at least 16. Default: 2048.
     */
    uint32_t map_side;
    /**
     * The most layers of maps, each with a side of `map_side`, but at least 512 texels. With
     * volumes, the most layers of the mask of lights, each as large as the image. Default: 8.
     */
    uint32_t layers_max;
    /**
     * The distance from the eye to which the sun has shadows (metres), below 1e6. Default: 0, for
     * a distance that suits the scene: 200, and more if its objects are larger than houses.
     */
    float distance;
    /**
     * The width of penumbras (metres), below 1e3. Default: 0, a hard edge.
     */
    float penumbra;
    /**
     * The width of the band in which a cascade blends into the next one, as a share of half its
     * side, up to 0.5. Default: 0, none.
     */
    float cascade_blend;
} AntumbraShadowDesc;

/**
 * The options of a renderer, and the scene that it begins with.
 */
typedef struct AntumbraRendererDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * Frames that may be in flight at once, up to 16. Default: 2.
     */
    uint32_t frames_in_flight;
    /**
     * Required: the device, which was adopted with a queue or opened by the library.
     */
    AntumbraDevice device;
    /**
     * Required: width of the image (pixels).
     */
    uint32_t width;
    /**
     * Required: height of the image (pixels).
     */
    uint32_t height;
    /**
     * The meshes. Default: null, with a `mesh_count` of 0.
     */
    const AntumbraMeshDesc *const *meshes;
    /**
     * The number of meshes. Default: 0.
     */
    size_t mesh_count;
    /**
     * The objects. Their ids are their indices. Neighbours in the array should be near each other.
     * Default: null, with an `object_count` of 0.
     */
    const AntumbraMeshObject *objects;
    /**
     * The number of objects. Default: 0.
     */
    size_t object_count;
    /**
     * The light. Default: null, for a clear afternoon.
     */
    const AntumbraSunlight *light;
    /**
     * The most occlusion queries of a frame, any number, or `ANTUMBRA_NO_QUERIES`. Objects for
     * which no query is left are drawn. Default: 8192.
     */
    size_t query_budget;
    /**
     * An `ANTUMBRA_COST_MODEL_..`. Default: `ANTUMBRA_COST_MODEL_BUILT_IN`.
     */
    uint32_t cost_model;
    /**
     * Room for objects that are added later. Default: 0.
     */
    uint32_t spare_objects;
    /**
     * Room for meshes that are added later. Default: 0.
     */
    uint32_t spare_meshes;
    /**
     * Room for the vertices of meshes that are added later. Default: 0.
     */
    uint32_t spare_vertices;
    /**
     * Room for the indices of meshes that are added later. Default: 0.
     */
    uint32_t spare_indices;
    /**
     * The most bytes of added meshes that a frame copies to the GPU, any number. Default: 1048576.
     */
    uint32_t upload_bytes_per_frame;
    /**
     * Samples per pixel, 1 or 4. With 4, edges are smooth. A device that evaluates depth and
     * coverage of a sample at different positions then supports only `ANTUMBRA_STRATEGY_FRUSTUM`.
     * Default: 1.
     */
    uint32_t samples;
    /**
     * Must be 0.
     */
    uint32_t reserved;
    /**
     * The shadows of the sun, or of the lights of the file. With `ANTUMBRA_SHADOWS_OFF` they can
     * be turned on later: `antumbra_renderer_set_shadows`. Default: null, for a renderer of meshes
     * that never has shadows.
     */
    const AntumbraShadowDesc *shadows;
    /**
     * A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: what rests on them is not
     * used. Default: 0, none.
     */
    uint32_t disabled;
    /**
     * 1 for a renderer that keeps its scene, so that `antumbra_renderer_recover` can draw it on
     * another device: its meshes stay in memory, and frames cost nothing more. Default: 0.
     */
    uint32_t keeps_scene;
    /**
     * The file whose scene is drawn, in place of `meshes`, `objects` and `light`, which must be
     * null then. Several renderers may have the same file, and it may be destroyed afterwards.
     * Default: 0, for a scene of meshes.
     */
    AntumbraSceneFile scene_file;
} AntumbraRendererDesc;

/**
 * A renderer: a scene on a device, and views of it.
 */
typedef struct AntumbraRenderer {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraRenderer;

/**
 * A view of a renderer, with its history of earlier frames.
 */
typedef struct AntumbraRendererView {
    /**
     * The number of the handle; 0 for none.
     */
    uint64_t id;
} AntumbraRendererView;

/**
 * A frame to be rendered.
 */
typedef struct AntumbraRenderDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * An `ANTUMBRA_STRATEGY_..`, which may change in each frame: all strategies draw the same
     * image. The exception is objects that lie in one plane in a renderer without shadows: which
     * of them shows depends on the order of draws there. With `AntumbraRendererDesc::shadows`,
     * whatever its method, depth is drawn first and no order shows. Default:
     * `ANTUMBRA_STRATEGY_ANTUMBRA`.
     */
    uint32_t strategy;
    /**
     * Required: the camera, with reversed depth. Its `sub_pixel_bits` are ignored.
     */
    const AntumbraCamera *camera;
    /**
     * The view whose history the frame uses and continues. A camera that is elsewhere needs
     * another view: `antumbra_renderer_view_create`. Default: 0, the renderer's own view.
     */
    AntumbraRendererView view;
} AntumbraRenderDesc;

/**
 * The image of the newest frame. The renderer owns the image, until the renderer is resized or
 * destroyed.
 *
 * Commands that are submitted to the same queue after the frame use the image after a barrier from
 * `state`. Commands on other queues first wait for `value` of the semaphore `timeline`. Before the
 * next frame is rendered, a barrier on the queue of the renderer must return the image to `state`.
 */
typedef struct AntumbraFinishedImage {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The format of the view, which decodes the colours. Views of the image can also have
     * `VK_FORMAT_R8G8B8A8_UNORM`.
     */
    VkFormat format;
    /**
     * The image, of 8 bits per channel, which may be sampled and copied.
     */
    VkImage image;
    /**
     * A view of the image.
     */
    VkImageView view;
    /**
     * Width (pixels).
     */
    uint32_t width;
    /**
     * Height (pixels).
     */
    uint32_t height;
    /**
     * The state in which the frame leaves the image.
     */
    AntumbraImageState state;
    /**
     * The timeline semaphore of the device, which the library owns.
     */
    VkSemaphore timeline;
    /**
     * The value of the semaphore at which the image is finished.
     */
    uint64_t value;
} AntumbraFinishedImage;

/**
 * The counts of the newest frame of a view whose results are known, and the state of uploads.
 */
typedef struct AntumbraRendererStats {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * 1 while meshes are being uploaded, whose objects are not drawn yet; else 0.
     */
    uint32_t is_uploading;
    /**
     * The frame, counted from 1; 0 if none is known.
     */
    uint64_t frame;
    /**
     * The objects of the scene in that frame.
     */
    uint64_t total;
    /**
     * The objects among them that the GPU drew.
     */
    uint64_t drawn;
    /**
     * The objects among the drawn ones that a test revealed.
     */
    uint64_t revealed;
    /**
     * The boxes that were tested.
     */
    uint64_t tests;
    /**
     * An `ANTUMBRA_PREDICATION_..`: the way that hidden draws are skipped. With
     * `ANTUMBRA_COST_MODEL_MEASURED` it is the cheapest one, else the device's usual one.
     */
    uint32_t predication;
    /**
     * An `ANTUMBRA_TESTER_..`: the tester that was expected to cost least.
     */
    uint32_t tester;
} AntumbraRendererStats;

/**
 * The counts of the shadows of the newest frame.
 */
typedef struct AntumbraShadowStats {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * The lights with shadows.
     */
    uint32_t lights;
    /**
     * The maps.
     */
    uint32_t maps;
    /**
     * The maps that the frame drew, wholly or in part.
     */
    uint32_t drawn_maps;
    /**
     * The maps among these whose casters are culled.
     */
    uint32_t culled_maps;
    /**
     * The casters in drawn maps, culled or not, or the casters of volumes.
     */
    uint32_t casters;
    /**
     * The tests that decide about culled casters.
     */
    uint32_t tests;
    /**
     * The volumes that are counted by z-fail, since the eye may be inside them.
     */
    uint32_t z_fail_volumes;
    /**
     * The lights that have no shadows for lack of room.
     */
    uint32_t unshadowed_lights;
    /**
     * Is 0.
     */
    uint32_t reserved;
    /**
     * The triangles of casters that are drawn, as far as is known when the frame is submitted.
     */
    uint64_t triangles;
    /**
     * The triangles of culled casters that tests revealed, in the newest frame with results.
     */
    uint64_t revealed_triangles;
} AntumbraShadowStats;

/**
 * The shadow of one light, in place of what the options of all lights say.
 */
typedef struct AntumbraLightShadowDesc {
    /**
     * Size of this struct in bytes.
     */
    uint32_t struct_size;
    /**
     * 1 for a light without shadows. Default: 0, for a light that casts them.
     */
    uint32_t is_off;
    /**
     * The width of its penumbras (metres), below 1e3. Default: 0, a hard edge.
     */
    float penumbra;
} AntumbraLightShadowDesc;

/**
 * Loads a file of a scene, for `AntumbraRendererDesc::scene_file`: glTF 2.0, .stl or .obj. The
 * file may contain anything: everything is checked, and what is demanded is bounded. The result
 * `ANTUMBRA_RESULT_BAD_FILE` comes with the file, the object in it, and the reason. Notes are also
 * warnings in the log. May take seconds; other threads may use the context.
 */
AntumbraResult antumbra_scene_file_load(const AntumbraContext *context,
                                        const AntumbraSceneFileDesc *desc,
                                        AntumbraSceneFile *file,
                                        AntumbraError *error);

/**
 * Destroys a file. Renderers of it stay as they are. A handle of 0 is not an error.
 */
AntumbraResult antumbra_scene_file_destroy(const AntumbraContext *context,
                                           AntumbraSceneFile file,
                                           AntumbraError *error);

/**
 * Writes the contents of a file.
 */
AntumbraResult antumbra_scene_file_info(const AntumbraContext *context,
                                        AntumbraSceneFile file,
                                        AntumbraSceneFileInfo *info,
                                        AntumbraError *error);

/**
 * Writes a camera of a file, from 0 to `AntumbraSceneFileInfo::cameras` - 1. Where it is and what
 * it sees depends on the playing clips: `antumbra_renderer_camera`.
 */
AntumbraResult antumbra_scene_file_camera(const AntumbraContext *context,
                                          AntumbraSceneFile file,
                                          uint32_t index,
                                          AntumbraSceneFileCamera *camera,
                                          AntumbraError *error);

/**
 * Writes a clip of a file, from 0 to `AntumbraSceneFileInfo::clips` - 1.
 */
AntumbraResult antumbra_scene_file_clip(const AntumbraContext *context,
                                        AntumbraSceneFile file,
                                        uint32_t index,
                                        AntumbraSceneFileClip *clip,
                                        AntumbraError *error);

/**
 * Writes a note about a file, from 0 to `AntumbraSceneFileInfo::notes` - 1.
 */
AntumbraResult antumbra_scene_file_note(const AntumbraContext *context,
                                        AntumbraSceneFile file,
                                        uint32_t index,
                                        AntumbraSceneFileNote *note,
                                        AntumbraError *error);

/**
 * Writes the requirements of the renderer, as `antumbra_requirements` does for the executor. For a
 * device that will be adopted with a queue.
 *
 * The caller promises that the handles are valid.
 */
AntumbraResult antumbra_renderer_requirements(const AntumbraContext *context,
                                              const AntumbraAdapterDesc *adapter,
                                              const AntumbraFeatures *features,
                                              AntumbraRequirements *requirements,
                                              AntumbraError *error);

/**
 * Creates a renderer of a scene, and uploads the scene: meshes with vertex colours and a sun, or
 * the scene of a file, at rest, with its materials, textures, lights, and transparent, skinned and
 * animated meshes. Meshes of the host have no materials, and levels of detail exist in the Rust
 * interface only.
 */
AntumbraResult antumbra_renderer_create(const AntumbraContext *context,
                                        const AntumbraRendererDesc *desc,
                                        AntumbraRenderer *renderer,
                                        AntumbraError *error);

/**
 * Continues on another device, which was adopted with a queue or opened, after a call on the
 * present one returned `ANTUMBRA_RESULT_DEVICE_LOST`. The renderer must have been created with
 * `keeps_scene`. It has the same scene, ids, options and playing clips as before, and its views
 * begin without history; its size may change later. Takes as long as `antumbra_renderer_create`.
 * The log has the frames that the lost device did not finish, with the labels of their passes.
 * After an error nothing has changed, and the call can be repeated. Release the lost device
 * afterwards.
 *
 * The caller promises that the host no longer uses the image of an earlier frame.
 */
AntumbraResult antumbra_renderer_recover(const AntumbraContext *context,
                                         AntumbraRenderer renderer,
                                         AntumbraDevice device,
                                         AntumbraError *error);

/**
 * Destroys a renderer without a wait: resources of frames in flight are freed when these frames
 * are over. The host must not use the renderer's image any more. A handle of 0 is not an error.
 */
AntumbraResult antumbra_renderer_destroy(const AntumbraContext *context,
                                         AntumbraRenderer renderer,
                                         AntumbraError *error);

/**
 * Renders a frame and submits it. Waits for the frame that used its memory `frames_in_flight`
 * frames ago, and for nothing else.
 *
 * The caller promises: when the frame executes, the image of the previous frame is in its `state`
 * again, and its other users are over. The callbacks of the queue do what `AntumbraQueueDesc`
 * says.
 */
AntumbraResult antumbra_renderer_render(const AntumbraContext *context,
                                        AntumbraRenderer renderer,
                                        const AntumbraRenderDesc *desc,
                                        AntumbraError *error);

/**
 * Writes the image of the newest frame. Before the first frame the result is
 * `ANTUMBRA_RESULT_BAD_ARGUMENT`.
 */
AntumbraResult antumbra_renderer_image(const AntumbraContext *context,
                                       AntumbraRenderer renderer,
                                       AntumbraFinishedImage *image,
                                       AntumbraError *error);

/**
 * Waits until all frames are over, and writes the newest image: four bytes per pixel, sRGB red,
 * green, blue and alpha, in rows from the top. `byte_count` is four times width times height. The
 * wait is bounded. Submits a copy, so the image must be in its `state`. Meant for tests, and for
 * images that are written to files, not for each frame.
 *
 * The caller promises what `antumbra_renderer_render` says about the image of the previous frame
 * and about the callbacks of the queue.
 */
AntumbraResult antumbra_renderer_read_image(const AntumbraContext *context,
                                            AntumbraRenderer renderer,
                                            uint8_t *rgba,
                                            size_t byte_count,
                                            AntumbraError *error);

/**
 * Changes the size of the images without a wait, and keeps the history of earlier frames. The host
 * must not use the image of an earlier frame any more.
 *
 * The caller promises that the host's commands that use the image are over.
 */
AntumbraResult antumbra_renderer_resize(const AntumbraContext *context,
                                        AntumbraRenderer renderer,
                                        uint32_t width,
                                        uint32_t height,
                                        AntumbraError *error);

/**
 * Adds objects and writes their ids, which may be those of objects that were removed.
 * `AntumbraRendererDesc::spare_objects` must leave room for them. After an error nothing was
 * added.
 */
AntumbraResult antumbra_renderer_add_objects(const AntumbraContext *context,
                                             AntumbraRenderer renderer,
                                             const AntumbraMeshObject *objects,
                                             size_t count,
                                             uint32_t *ids,
                                             AntumbraError *error);

/**
 * Removes objects. After an error nothing was removed.
 */
AntumbraResult antumbra_renderer_remove_objects(const AntumbraContext *context,
                                                AntumbraRenderer renderer,
                                                const uint32_t *objects,
                                                size_t count,
                                                AntumbraError *error);

/**
 * Moves objects: object `objects[i]` has the transform `transforms[i]` from the next frame on.
 * After an error nothing has moved.
 */
AntumbraResult antumbra_renderer_move_objects(const AntumbraContext *context,
                                              AntumbraRenderer renderer,
                                              const uint32_t *objects,
                                              const AntumbraTransform *transforms,
                                              size_t count,
                                              AntumbraError *error);

/**
 * Adds meshes and writes their ids, which may be those of meshes that were removed.
 * `spare_meshes`, `spare_vertices` and `spare_indices` of the `AntumbraRendererDesc` must leave
 * room for them. Objects can use the meshes immediately, and are drawn when the meshes are on the
 * GPU: each frame copies a part. After an error nothing was added.
 */
AntumbraResult antumbra_renderer_add_meshes(const AntumbraContext *context,
                                            AntumbraRenderer renderer,
                                            const AntumbraMeshDesc *const *meshes,
                                            size_t count,
                                            uint32_t *ids,
                                            AntumbraError *error);

/**
 * Removes meshes that no object uses. After an error nothing was removed.
 */
AntumbraResult antumbra_renderer_remove_meshes(const AntumbraContext *context,
                                               AntumbraRenderer renderer,
                                               const uint32_t *meshes,
                                               size_t count,
                                               AntumbraError *error);

/**
 * Writes the counts of the newest frame of the renderer's own view whose results are known.
 */
AntumbraResult antumbra_renderer_stats(const AntumbraContext *context,
                                       AntumbraRenderer renderer,
                                       AntumbraRendererStats *stats,
                                       AntumbraError *error);

/**
 * Waits until all frames of the renderer are over; the wait is bounded. Meant for measurements and
 * for the end of the program, not for each frame.
 */
AntumbraResult antumbra_renderer_wait(const AntumbraContext *context,
                                      AntumbraRenderer renderer,
                                      AntumbraError *error);

/**
 * Creates a view of a renderer, without history, for `AntumbraRenderDesc::view`. Frames of several
 * cameras, such as a mirror and the eye, each have a view: the history of one says little about
 * what another sees. Each frame shows one view, in the renderer's one image.
 */
AntumbraResult antumbra_renderer_view_create(const AntumbraContext *context,
                                             AntumbraRenderer renderer,
                                             AntumbraRendererView *view,
                                             AntumbraError *error);

/**
 * Destroys a view of a renderer without a wait. An image that shows it stays. A handle of 0 is not
 * an error.
 */
AntumbraResult antumbra_renderer_view_destroy(const AntumbraContext *context,
                                              AntumbraRenderer renderer,
                                              AntumbraRendererView view,
                                              AntumbraError *error);

/**
 * Writes the counts of the newest frame of a view whose results are known.
 */
AntumbraResult antumbra_renderer_view_stats(const AntumbraContext *context,
                                            AntumbraRenderer renderer,
                                            AntumbraRendererView view,
                                            AntumbraRendererStats *stats,
                                            AntumbraError *error);

/**
 * Changes the options of shadows; a `method` of 0 turns shadows off. Creates new maps and
 * pipelines, so it is not meant for every frame. The renderer must have been created with an
 * `AntumbraShadowDesc`. After an error nothing has changed.
 */
AntumbraResult antumbra_renderer_set_shadows(const AntumbraContext *context,
                                             AntumbraRenderer renderer,
                                             const AntumbraShadowDesc *desc,
                                             AntumbraError *error);

/**
 * Writes the counts of the shadows of the newest frame.
 */
AntumbraResult antumbra_renderer_shadow_stats(const AntumbraContext *context,
                                              AntumbraRenderer renderer,
                                              AntumbraShadowStats *stats,
                                              AntumbraError *error);

/**
 * Changes the shadow of one light; `desc` is null for what the options of all lights say. The next
 * frame shows it. The sun of an `AntumbraSunlight` is light 0, unless it is black; the lights of a
 * file are counted from 0. The renderer must have been created with an `AntumbraShadowDesc`, or
 * from a file.
 */
AntumbraResult antumbra_renderer_set_light_shadow(const AntumbraContext *context,
                                                  AntumbraRenderer renderer,
                                                  uint32_t light,
                                                  const AntumbraLightShadowDesc *desc,
                                                  AntumbraError *error);

/**
 * Plays clips of the renderer's file in loops that begin at time 0, in place of those that play.
 * From the time `seconds` on they fade in, for `fade_seconds`; a fade of 0 is a cut. Without clips
 * the scene returns to rest; with a `clip_count` of `ANTUMBRA_ALL_CLIPS` all clips play that can
 * play together: no two that animate the same property of a node. Otherwise the later of two such
 * clips wins. Nothing moves before `antumbra_renderer_advance`.
 */
AntumbraResult antumbra_renderer_play(const AntumbraContext *context,
                                      AntumbraRenderer renderer,
                                      const uint32_t *clips,
                                      size_t clip_count,
                                      double seconds,
                                      double fade_seconds,
                                      AntumbraError *error);

/**
 * Moves the scene of the renderer's file to a time of its clips, in any order of times: objects,
 * poses, lights and cameras. The next frame shows it. The cost grows with what moves. Objects of
 * the file that were removed stay away, and clips do not move objects of the host.
 */
AntumbraResult antumbra_renderer_advance(const AntumbraContext *context,
                                         AntumbraRenderer renderer,
                                         double seconds,
                                         AntumbraError *error);

/**
 * Writes a camera of the renderer's file for its images, at the time of the last
 * `antumbra_renderer_advance`, or the view `ANTUMBRA_CAMERA_OVERVIEW`. In images that are narrower
 * than those of the camera, nothing is cut off at the sides.
 */
AntumbraResult antumbra_renderer_camera(const AntumbraContext *context,
                                        AntumbraRenderer renderer,
                                        uint32_t index,
                                        AntumbraCamera *camera,
                                        AntumbraError *error);

#endif /* ANTUMBRA_VULKAN */

#ifdef __cplusplus
}
#endif

#endif /* ANTUMBRA_H */
