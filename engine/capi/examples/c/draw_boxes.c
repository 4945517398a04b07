/* The executor in a host of plain Vulkan, which has its own instance, device, depth image and command
 * buffers: `draw_boxes DEVICE`. Each frame is drawn with the executor's culling, and again by brute
 * force. The bits of both depth images must be the same. */
#include "plain_vulkan.h"
#include <antumbra_vulkan.h>

enum { BOXES = 1001, FRAMES = 36, IMAGE = WIDTH * HEIGHT * 4, IMAGES_AT = 128 };
static const float NEAR = 0.1F, TAN_Y = 0.5F;

static AntumbraError error = ANTUMBRA_INIT(AntumbraError);
static Pipeline pipeline;
static Buffer buffer;
static Constants constants;

static void check(AntumbraResult result) {
    if (result == ANTUMBRA_RESULT_OK) return;
    fprintf(stderr, "antumbra: %s\n", error.message);
    exit(1);
}

/* Binds the pipeline and the index buffer for draws of boxes. */
static void bind(void *user, const AntumbraBinding *binding) {
    (void)user;
    vkCmdBindPipeline(binding->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.pipeline);
    vkCmdBindIndexBuffer(binding->commands, buffer.buffer, 0, VK_INDEX_TYPE_UINT16);
    vkCmdPushConstants(binding->commands, pipeline.layout, VK_SHADER_STAGE_VERTEX_BIT, 0,
                       sizeof constants, &constants);
}

/* Adds the boxes that the shader draws: a wall, and a thousand boxes behind it. */
static void add_boxes(AntumbraContext *context, AntumbraScene scene) {
    static AntumbraObject objects[BOXES];
    static AntumbraObjectDraw draws[BOXES];
    static uint32_t ids[BOXES];
    for (uint32_t n = 0; n < BOXES; n++) {
        /* A box may be larger than the object in it, and must never be smaller. */
        float x = (n % 20) * 0.7F - 7.01F, y = (n / 20 % 10) * 0.7F - 3.51F, z = (n / 200) * -1.3F - 12.01F;
        objects[n] = (AntumbraObject){{{x, y, z}, {x + 0.47F, y + 0.47F, z + 0.47F}}, n, 1};
        draws[n] = (AntumbraObjectDraw){0, INDICES, 1, 0, 0, n};
    }
    objects[0].bounds = (AntumbraAabb){{-4, -3, -6}, {4, 3, -5.5F}};
    check(antumbra_scene_add(context, scene, objects, BOXES, draws, BOXES, ids, &error));
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

    /* First query the requirements: the executor adds its features to those of the host, which are two here. */
    AntumbraContextDesc context_desc = {.struct_size = sizeof context_desc, .abi_version = ANTUMBRA_ABI_VERSION};
    AntumbraContext *context;
    check(antumbra_context_create(&context_desc, &context, &error));
    AntumbraAdapterDesc adapter = {.struct_size = sizeof adapter, .instance_proc_addr = vkGetInstanceProcAddr,
        .instance = instance, .physical_device = physical};
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditional = {
        TYPE(PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT)};
    VkPhysicalDeviceVulkan13Features vulkan_13 = {TYPE(PHYSICAL_DEVICE_VULKAN_1_3_FEATURES),
        .dynamicRendering = VK_TRUE, .synchronization2 = VK_TRUE};
    VkPhysicalDeviceVulkan12Features vulkan_12 = {TYPE(PHYSICAL_DEVICE_VULKAN_1_2_FEATURES), .pNext = &vulkan_13};
    VkPhysicalDeviceFeatures2 all = {TYPE(PHYSICAL_DEVICE_FEATURES_2), .pNext = &vulkan_12};
    AntumbraFeatures features = {sizeof features, 0, &all.features, &vulkan_12, &vulkan_13, &conditional};
    AntumbraRequirements needs = ANTUMBRA_INIT(AntumbraRequirements);
    check(antumbra_requirements(context, &adapter, &features, &needs, &error));
    if (conditional.conditionalRendering) vulkan_13.pNext = &conditional;
    VkDeviceQueueCreateInfo queue_info = {TYPE(DEVICE_QUEUE_CREATE_INFO), .queueFamilyIndex = needs.queue_family,
        .queueCount = 1, .pQueuePriorities = (float[]){1}};
    VkDeviceCreateInfo device_info = {TYPE(DEVICE_CREATE_INFO), .pNext = &all, .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue_info, .enabledExtensionCount = needs.extension_count,
        .ppEnabledExtensionNames = needs.extensions};
    VkDevice device;
    VK(vkCreateDevice(physical, &device_info, NULL, &device));

    /* Then let the library adopt the device. */
    AntumbraDeviceDesc adopted = {.struct_size = sizeof adopted, .queue_family = needs.queue_family,
        .adapter = &adapter, .device = device, .features = &features, .extensions = needs.extensions,
        .extension_count = needs.extension_count};
    AntumbraAttachments attachments = {.struct_size = sizeof attachments, .depth_format = FORMAT};
    AntumbraSceneDesc scene_desc = {.struct_size = sizeof scene_desc, .frames_in_flight = IN_FLIGHT,
        .attachments = &attachments, .object_capacity = BOXES};
    AntumbraScene scene;
    AntumbraView view;
    check(antumbra_device_adopt(context, &adopted, &scene_desc.device, &error));
    check(antumbra_scene_create(context, &scene_desc, &scene, &error));
    check(antumbra_view_create(context, scene, &view, &error));
    add_boxes(context, scene);

    Image image = create_image(physical, device);
    buffer = create_buffer(physical, device, IMAGES_AT + IN_FLIGHT * 2 * IMAGE);
    pipeline = create_pipeline(device);
    Commands host = create_commands(device, needs.queue_family);
    const uint32_t bits = properties.limits.subPixelPrecisionBits;
    for (uint64_t frame = 1; frame <= FRAMES + IN_FLIGHT; frame++) {
        const int slot = frame % IN_FLIGHT;
        const char *images = buffer.mapped + IMAGES_AT + slot * 2 * IMAGE;
        VkCommandBuffer commands = host.buffers[slot];
        if (frame > IN_FLIGHT) {
            VK(vkWaitForFences(device, 1, &host.fences[slot], VK_TRUE, UINT64_MAX));
            VK(vkResetFences(device, 1, &host.fences[slot]));
            if (memcmp(images, images + IMAGE, IMAGE)) return fprintf(stderr, "a frame differs\n"), 1;
        }
        if (frame > FRAMES) continue;
        /* The eye jumps to another side of the wall, so that hidden boxes show at once. */
        const float eye = (float)(frame / 12 % 3) * 9 - 9 + (float)frame * 0.05F;
        const float x = 1 / TAN_Y * HEIGHT / WIDTH, y = -1 / TAN_Y;
        constants = (Constants){{x, 0, 0, 0, 0, y, 0, 0, 0, 0, 0, -1, -x * eye, 0, NEAR, 3},
            {WIDTH / 2 * (float)(1 << bits), HEIGHT / 2 * (float)(1 << bits)}};
        AntumbraCamera camera = {.struct_size = sizeof camera, .sub_pixel_bits = bits, .width = WIDTH,
            .height = HEIGHT};
        memcpy(camera.clip_from_world, constants.clip_from_world, sizeof camera.clip_from_world);
        AntumbraTargetDesc target = {.struct_size = sizeof target, .width = WIDTH, .height = HEIGHT, .depth = {
            image.image, image.view, FORMAT, IMAGE_USAGE, {.stages = VK_PIPELINE_STAGE_2_COPY_BIT},
            {VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT}}};
        AntumbraViewFrame view_frame = {.struct_size = sizeof view_frame, .view = view, .camera = &camera,
            .target = &target};
        AntumbraFrameDesc desc = {.struct_size = sizeof desc, .view_count = 1, .bind = bind, .commands = commands,
            .views = (const AntumbraViewFrame *[]){&view_frame}, .current = frame,
            .safe = frame > IN_FLIGHT ? frame - IN_FLIGHT : 0};
        begin(commands);
        check(antumbra_scene_record(context, scene, &desc, &error));
        copy(commands, image, buffer.buffer, (VkDeviceSize)(images - buffer.mapped));
        begin_rendering(commands, image);
        bind(NULL, &(AntumbraBinding){.commands = commands});
        vkCmdDrawIndexed(commands, INDICES, BOXES, 0, 0, 0);
        end_rendering(commands, image);
        copy(commands, image, buffer.buffer, (VkDeviceSize)(images - buffer.mapped) + IMAGE);
        submit(&host, slot);
    }
    AntumbraViewStats stats = ANTUMBRA_INIT(AntumbraViewStats);
    check(antumbra_view_stats(context, scene, view, &stats, &error));
    printf("%s: %d frames equal to brute force; frame %d drew %d of %d boxes\n", properties.deviceName, FRAMES,
           (int)stats.frame, (int)stats.objects, BOXES);

    check(antumbra_device_finished(context, scene_desc.device, &error));
    check(antumbra_context_destroy(context, &error));
    destroy(device, image, buffer, pipeline, host);
    vkDestroyDevice(device, NULL);
    vkDestroyInstance(instance, NULL);
    return stats.objects > BOXES / 2;
}
