/* A Vulkan loader whose devices lack what phones often lack: conditional rendering, draw counts, geometry and
   tessellation shaders, lines, anisotropy, block compression, descriptor indexing, queries that the CPU resets, more
   than 7 storage buffers per stage. REAL_LOADER is the real library. The number of these that a device had, each
   counted once, is written to the file HIDDEN at the end. */
#define VK_NO_PROTOTYPES
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

static PFN_vkGetInstanceProcAddr real_of_instance;
static PFN_vkGetPhysicalDeviceFeatures2 real_features;
static PFN_vkGetPhysicalDeviceProperties real_properties;
static PFN_vkGetPhysicalDeviceProperties2 real_properties2;

enum Kind {
    GEOMETRY,
    TESSELLATION,
    LINES,
    ANISOTROPY,
    BLOCK_COMPRESSION,
    CONDITIONAL,
    DRAW_COUNTS,
    CPU_RESETS,
    INDEXING,
    STORAGE_BUFFERS,
};
/* A bit for each kind. */
static atomic_uint hidden;

__attribute__((destructor)) static void write_hidden(void) {
    const char *path = getenv("HIDDEN");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%d", __builtin_popcount(atomic_load(&hidden)));
    fclose(file);
}

static void hide(enum Kind kind, VkBool32 *feature) {
    if (*feature) atomic_fetch_or(&hidden, 1u << kind);
    *feature = VK_FALSE;
}

static void limit(VkPhysicalDeviceLimits *limits) {
    if (limits->maxPerStageDescriptorStorageBuffers > 7) {
        limits->maxPerStageDescriptorStorageBuffers = 7;
        atomic_fetch_or(&hidden, 1u << STORAGE_BUFFERS);
    }
}

static VKAPI_ATTR void VKAPI_CALL features(VkPhysicalDevice device, VkPhysicalDeviceFeatures2 *found) {
    real_features(device, found);
    hide(GEOMETRY, &found->features.geometryShader);
    hide(TESSELLATION, &found->features.tessellationShader);
    hide(LINES, &found->features.fillModeNonSolid);
    hide(ANISOTROPY, &found->features.samplerAnisotropy);
    hide(BLOCK_COMPRESSION, &found->features.textureCompressionBC);
    for (VkBaseOutStructure *next = found->pNext; next; next = next->pNext) {
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT) {
            hide(CONDITIONAL, &((VkPhysicalDeviceConditionalRenderingFeaturesEXT *)next)->conditionalRendering);
        }
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES) {
            VkPhysicalDeviceVulkan12Features *more = (VkPhysicalDeviceVulkan12Features *)next;
            hide(DRAW_COUNTS, &more->drawIndirectCount);
            hide(CPU_RESETS, &more->hostQueryReset);
            hide(INDEXING, &more->shaderSampledImageArrayNonUniformIndexing);
        }
    }
}

static VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice device, VkPhysicalDeviceProperties *found) {
    real_properties(device, found);
    limit(&found->limits);
}

static VKAPI_ATTR void VKAPI_CALL properties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2 *found) {
    real_properties2(device, found);
    limit(&found->properties.limits);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance, const char *name) {
    if (!real_of_instance) {
        const char *path = getenv("REAL_LOADER");
        void *library = path ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
        if (!library) abort();
        *(void **)&real_of_instance = dlsym(library, "vkGetInstanceProcAddr");
    }
    PFN_vkVoidFunction real = real_of_instance(instance, name);
    if (!real) return NULL;
    if (strcmp(name, "vkGetInstanceProcAddr") == 0) return (PFN_vkVoidFunction)vkGetInstanceProcAddr;
    if (strcmp(name, "vkGetPhysicalDeviceFeatures2") == 0) {
        real_features = (PFN_vkGetPhysicalDeviceFeatures2)real;
        return (PFN_vkVoidFunction)features;
    }
    if (strcmp(name, "vkGetPhysicalDeviceProperties") == 0) {
        real_properties = (PFN_vkGetPhysicalDeviceProperties)real;
        return (PFN_vkVoidFunction)properties;
    }
    if (strcmp(name, "vkGetPhysicalDeviceProperties2") == 0) {
        real_properties2 = (PFN_vkGetPhysicalDeviceProperties2)real;
        return (PFN_vkVoidFunction)properties2;
    }
    return real;
}
