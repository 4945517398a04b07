/* The renderer on the device of a host of plain Vulkan: `render_boxes DEVICE`. Each frame is rendered twice, with
 * frustum culling only and with occlusion culling. The host copies both images, and their bits must be the same. */
#include "plain_vulkan.h"
#include <antumbra_vulkan.h>

enum { BOXES = 1001, FRAMES = 36, IMAGE = WIDTH * HEIGHT * 4, IMAGES_AT = 128 };
static AntumbraError error = ANTUMBRA_INIT(AntumbraError);

static void check(AntumbraResult result) {
    if (result == ANTUMBRA_RESULT_OK) return;
    fprintf(stderr, "antumbra: %s\n", error.message);
    exit(1);
}

/* Creates a renderer of a wall and a thousand boxes behind it. */
static AntumbraRenderer create_renderer(AntumbraContext *context, AntumbraDevice device) {
    static AntumbraMeshObject objects[BOXES];
    AntumbraVertex vertices[24] = {0};
    uint32_t indices[36];
    for (uint32_t n = 0; n < 24; n++) { /* Six faces of four corners. */
        const uint32_t axis = n / 8, side = n / 4 % 2, corner = n % 4;
        const float sides[3] = {(float)side, corner == 1 || corner == 2, corner > 1};
        for (uint32_t m = 0; m < 3; m++) vertices[n].position[(axis + m) % 3] = sides[m];
        vertices[n].normal[axis] = side ? 1 : -1;
        for (uint32_t m = 0; m < 4; m++) vertices[n].colour[m] = 1;
    }
    for (uint32_t n = 0; n < 36; n++) {
        static const uint32_t outwards[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
        indices[n] = n / 6 * 4 + outwards[n / 6 % 2][n % 6];
    }
    for (uint32_t n = 0; n < BOXES; n++) {
        const float x = (n % 20) * 0.7F - 7, y = (n / 20 % 10) * 0.7F - 3.5F, z = (n / 200) * -1.3F - 12, e = 0.45F;
        objects[n] = (AntumbraMeshObject){0, 0x404040 + n * 0x30507, {{e, 0, 0, 0, e, 0, 0, 0, e, x, y, z}}};
    }
    objects[0].transform = (AntumbraTransform){{8, 0, 0, 0, 6, 0, 0, 0, 0.5F, -4, -3, -6}};
    AntumbraMeshDesc mesh = {.struct_size = sizeof mesh, .vertices = vertices, .vertex_count = 24, .indices = indices,
        .index_count = 36};
    AntumbraShadowDesc shadows = {.struct_size = sizeof shadows, .method = ANTUMBRA_SHADOWS_MAPS, .map_side = 512,
        .cascades = 2, .distance = 40, .penumbra = 0.1F};
    /* In such a small scene tests may cost more than they save, so the costs are ignored here. */
    AntumbraRendererDesc desc = {.struct_size = sizeof desc, .device = device, .width = WIDTH,
        .height = HEIGHT, .meshes = (const AntumbraMeshDesc *[]){&mesh}, .mesh_count = 1, .objects = objects,
        .object_count = BOXES, .cost_model = ANTUMBRA_COST_MODEL_OFF, .shadows = &shadows};
    AntumbraRenderer renderer;
    check(antumbra_renderer_create(context, &desc, &renderer, &error));
    return renderer;
}

/* Copies a finished image, after the frame that draws it, and returns it to its state. */
static void copy_finished(VkCommandBuffer commands, const AntumbraFinishedImage *image, VkBuffer buffer,
                          VkDeviceSize at) {
    VkBufferImageCopy region = {at, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {0, 0, 0}, {WIDTH, HEIGHT, 1}};
    VkImageMemoryBarrier2 barrier = {TYPE(IMAGE_MEMORY_BARRIER_2), .srcStageMask = image->state.stages,
        .srcAccessMask = image->state.access, .dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
        .dstAccessMask = VK_ACCESS_2_TRANSFER_READ_BIT, .oldLayout = image->state.layout,
        .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, .image = image->image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    VkMemoryBarrier2 visible = {TYPE(MEMORY_BARRIER_2), .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT, .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo info = {TYPE(DEPENDENCY_INFO), .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &info);
    vkCmdCopyImageToBuffer(commands, image->image, barrier.newLayout, buffer, 1, &region);
    barrier = (VkImageMemoryBarrier2){TYPE(IMAGE_MEMORY_BARRIER_2), .srcStageMask = barrier.dstStageMask,
        .srcAccessMask = barrier.dstAccessMask, .dstStageMask = barrier.srcStageMask,
        .dstAccessMask = barrier.srcAccessMask, .oldLayout = barrier.newLayout, .newLayout = barrier.oldLayout,
        .image = image->image, .subresourceRange = barrier.subresourceRange};
    info.memoryBarrierCount = 1, info.pMemoryBarriers = &visible;
    vkCmdPipelineBarrier2(commands, &info);
}

int main(int argument_count, char **arguments) {
    VkApplicationInfo application = {TYPE(APPLICATION_INFO), .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance_info = {TYPE(INSTANCE_CREATE_INFO), .pApplicationInfo = &application};
    VkInstance instance;
    VkPhysicalDevice devices[8], physical = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties;
    uint32_t device_count = 8;
    VK(vkCreateInstance(&instance_info, NULL, &instance));
    VK(vkEnumeratePhysicalDevices(instance, &device_count, devices));
    for (uint32_t n = 0; n < device_count && !physical; n++) {
        vkGetPhysicalDeviceProperties(devices[n], &properties);
        if (strstr(properties.deviceName, argument_count > 1 ? arguments[1] : "")) physical = devices[n];
    }
    if (!physical) return fprintf(stderr, "there is no such device\n"), 1;

    /* First query the requirements: the library adds its features to those of the host. */
    AntumbraContextDesc context_desc = {.struct_size = sizeof context_desc, .abi_version = ANTUMBRA_ABI_VERSION};
    AntumbraContext *context;
    check(antumbra_context_create(&context_desc, &context, &error));
    AntumbraAdapterDesc adapter = {.struct_size = sizeof adapter, .instance_proc_addr = vkGetInstanceProcAddr,
        .instance = instance, .physical_device = physical};
    VkPhysicalDeviceVulkan13Features vulkan_13 = {TYPE(PHYSICAL_DEVICE_VULKAN_1_3_FEATURES)};
    VkPhysicalDeviceVulkan12Features vulkan_12 = {TYPE(PHYSICAL_DEVICE_VULKAN_1_2_FEATURES), .pNext = &vulkan_13};
    VkPhysicalDeviceFeatures2 all = {TYPE(PHYSICAL_DEVICE_FEATURES_2), .pNext = &vulkan_12};
    AntumbraFeatures features = {sizeof features, 0, &all.features, &vulkan_12, &vulkan_13, NULL};
    AntumbraRequirements needs = ANTUMBRA_INIT(AntumbraRequirements);
    check(antumbra_renderer_requirements(context, &adapter, &features, &needs, &error));
    VkDeviceQueueCreateInfo queue_info = {TYPE(DEVICE_QUEUE_CREATE_INFO), .queueFamilyIndex = needs.queue_family,
        .queueCount = 1, .pQueuePriorities = (float[]){1}};
    VkDeviceCreateInfo device_info = {TYPE(DEVICE_CREATE_INFO), .pNext = &all, .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue_info, .enabledExtensionCount = needs.extension_count,
        .ppEnabledExtensionNames = needs.extensions};
    VkDevice device;
    VK(vkCreateDevice(physical, &device_info, NULL, &device));

    /* Then let the library adopt the device. This program has one thread, so the queue needs no lock. */
    AntumbraQueueDesc queue = ANTUMBRA_INIT(AntumbraQueueDesc);
    vkGetDeviceQueue(device, needs.queue_family, 0, &queue.queue);
    AntumbraDeviceDesc adopted = {.struct_size = sizeof adopted, .queue_family = needs.queue_family,
        .adapter = &adapter, .device = device, .features = &features, .extensions = needs.extensions,
        .extension_count = needs.extension_count, .queue = &queue};
    AntumbraDevice ours;
    check(antumbra_device_adopt(context, &adopted, &ours, &error));
    AntumbraRenderer renderer = create_renderer(context, ours);

    Buffer buffer = create_buffer(physical, device, IMAGES_AT + 2 * IMAGE);
    const char *images = buffer.mapped + IMAGES_AT;
    Commands host = create_commands(device, needs.queue_family);
    for (int frame = 0; frame < FRAMES; frame++) {
        /* The eye jumps to another side of the wall, so that hidden boxes show at once. */
        const float eye = (float)(frame / 12 % 3) * 9 - 9 + (float)frame * 0.05F, x = 2.0F * HEIGHT / WIDTH;
        AntumbraCamera camera = {.struct_size = sizeof camera, .width = WIDTH, .height = HEIGHT,
            .clip_from_world = {x, 0, 0, 0, 0, -2, 0, 0, 0, 0, 0, -1, -x * eye, 0, 0.1F, 3}};
        const uint32_t strategies[2] = {ANTUMBRA_STRATEGY_FRUSTUM, ANTUMBRA_STRATEGY_ANTUMBRA};
        for (int n = 0; n < 2; n++) {
            AntumbraRenderDesc desc = {.struct_size = sizeof desc, .strategy = strategies[n], .camera = &camera};
            AntumbraFinishedImage image = ANTUMBRA_INIT(AntumbraFinishedImage);
            check(antumbra_renderer_render(context, renderer, &desc, &error));
            check(antumbra_renderer_image(context, renderer, &image, &error));
            begin(host.buffers[n]);
            copy_finished(host.buffers[n], &image, buffer.buffer, IMAGES_AT + (VkDeviceSize)n * IMAGE);
            submit(&host, n);
        }
        VK(vkWaitForFences(device, 2, host.fences, VK_TRUE, UINT64_MAX));
        VK(vkResetFences(device, 2, host.fences));
        if (memcmp(images, images + IMAGE, IMAGE)) return fprintf(stderr, "frame %d differs\n", frame), 1;
    }
    AntumbraRendererStats stats = ANTUMBRA_INIT(AntumbraRendererStats);
    check(antumbra_renderer_wait(context, renderer, &error));
    check(antumbra_renderer_stats(context, renderer, &stats, &error));
    AntumbraShadowStats shadows = ANTUMBRA_INIT(AntumbraShadowStats);
    check(antumbra_renderer_shadow_stats(context, renderer, &shadows, &error));
    if (shadows.lights != 1 || shadows.maps != 2) return fprintf(stderr, "no shadow maps\n"), 1;
    printf("%s: %d images equal to those with all drawn; the last has %d of %d boxes\n", properties.deviceName, FRAMES,
           (int)stats.drawn, (int)stats.total);
    check(antumbra_context_destroy(context, &error));
    destroy(device, (Image){0}, buffer, (Pipeline){0}, host);
    vkDestroyDevice(device, NULL);
    vkDestroyInstance(instance, NULL);
    return stats.drawn > BOXES / 2;
}
