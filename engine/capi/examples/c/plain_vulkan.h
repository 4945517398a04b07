/* Vulkan code that every renderer has in some form: memory, a buffer, a pipeline for boxes, copies. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>
#include "boxes_vert.h"

enum { WIDTH = 160, HEIGHT = 90, INDICES = 36, IN_FLIGHT = 2 };
#define FORMAT VK_FORMAT_D32_SFLOAT
#define TYPE(name) .sType = VK_STRUCTURE_TYPE_##name
#define IMAGE_USAGE (VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT)

/* The constants of the vertex shader. */
typedef struct Constants {
    float clip_from_world[16], snap_steps[2];
} Constants;

/* A pipeline with its layout. */
typedef struct Pipeline {
    VkPipeline pipeline;
    VkPipelineLayout layout;
} Pipeline;

/* An image with its view and memory. */
typedef struct Image {
    VkImage image;
    VkImageView view;
    VkDeviceMemory memory;
} Image;

/* A buffer that begins with the indices of a box, in memory that the CPU reads and writes. */
typedef struct Buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    char *mapped;
} Buffer;

/* A queue, and a command buffer with a fence for each frame in flight. */
typedef struct Commands {
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer buffers[IN_FLIGHT];
    VkFence fences[IN_FLIGHT];
} Commands;

/* Ends the program if a call of Vulkan failed. */
#define VK(call) ((call) < 0 ? (fprintf(stderr, "%s failed\n", #call), exit(1)) : (void)0)

static inline VkDeviceMemory allocate(VkPhysicalDevice physical, VkDevice device, VkMemoryRequirements needs,
                                      VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties there;
    VkMemoryAllocateInfo info = {TYPE(MEMORY_ALLOCATE_INFO), .allocationSize = needs.size};
    VkDeviceMemory memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &there);
    while (!(needs.memoryTypeBits >> info.memoryTypeIndex & 1) ||
           (there.memoryTypes[info.memoryTypeIndex].propertyFlags & flags) != flags)
        info.memoryTypeIndex++;
    VK(vkAllocateMemory(device, &info, NULL, &memory));
    return memory;
}

static inline Buffer create_buffer(VkPhysicalDevice physical, VkDevice device, VkDeviceSize size) {
    static const uint16_t indices[INDICES] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                              2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    VkBufferCreateInfo info = {TYPE(BUFFER_CREATE_INFO), .size = size,
        .usage = VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkMemoryRequirements needs;
    Buffer new;
    VK(vkCreateBuffer(device, &info, NULL, &new.buffer));
    vkGetBufferMemoryRequirements(device, new.buffer, &needs);
    new.memory = allocate(physical, device, needs,
                          VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(device, new.buffer, new.memory, 0));
    VK(vkMapMemory(device, new.memory, 0, VK_WHOLE_SIZE, 0, (void **)&new.mapped));
    memcpy(new.mapped, indices, sizeof indices);
    return new;
}

static inline Pipeline create_pipeline(VkDevice device) {
    Pipeline new;
    VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Constants)};
    VkPipelineLayoutCreateInfo of_layout = {TYPE(PIPELINE_LAYOUT_CREATE_INFO), .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range};
    VkShaderModuleCreateInfo code = {TYPE(SHADER_MODULE_CREATE_INFO), .codeSize = sizeof boxes_vert,
        .pCode = boxes_vert};
    VkPipelineShaderStageCreateInfo stage = {TYPE(PIPELINE_SHADER_STAGE_CREATE_INFO), .pName = "main",
        .stage = VK_SHADER_STAGE_VERTEX_BIT};
    VK(vkCreatePipelineLayout(device, &of_layout, NULL, &new.layout));
    VK(vkCreateShaderModule(device, &code, NULL, &stage.module));
    VkPipelineVertexInputStateCreateInfo input = {TYPE(PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO)};
    VkPipelineInputAssemblyStateCreateInfo assembly = {TYPE(PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO),
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    VkPipelineViewportStateCreateInfo area = {TYPE(PIPELINE_VIEWPORT_STATE_CREATE_INFO), .viewportCount = 1,
        .scissorCount = 1};
    VkPipelineRasterizationStateCreateInfo raster = {TYPE(PIPELINE_RASTERIZATION_STATE_CREATE_INFO), .lineWidth = 1};
    VkPipelineMultisampleStateCreateInfo samples = {TYPE(PIPELINE_MULTISAMPLE_STATE_CREATE_INFO),
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    VkPipelineDepthStencilStateCreateInfo depth = {TYPE(PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO),
        .depthTestEnable = VK_TRUE, .depthWriteEnable = VK_TRUE, .depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL};
    VkDynamicState states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic = {TYPE(PIPELINE_DYNAMIC_STATE_CREATE_INFO), .dynamicStateCount = 2,
        .pDynamicStates = states};
    VkPipelineRenderingCreateInfo rendering = {TYPE(PIPELINE_RENDERING_CREATE_INFO), .depthAttachmentFormat = FORMAT};
    VkGraphicsPipelineCreateInfo info = {TYPE(GRAPHICS_PIPELINE_CREATE_INFO), .pNext = &rendering, .stageCount = 1,
        .pStages = &stage, .pVertexInputState = &input, .pInputAssemblyState = &assembly, .pViewportState = &area,
        .pRasterizationState = &raster, .pMultisampleState = &samples, .pDepthStencilState = &depth,
        .pDynamicState = &dynamic, .layout = new.layout};
    VK(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &new.pipeline));
    vkDestroyShaderModule(device, stage.module, NULL);
    return new;
}

/* Creates the depth image. */
static inline Image create_image(VkPhysicalDevice physical, VkDevice device) {
    VkImageCreateInfo info = {TYPE(IMAGE_CREATE_INFO), .imageType = VK_IMAGE_TYPE_2D, .format = FORMAT,
        .extent = {WIDTH, HEIGHT, 1}, .mipLevels = 1, .arrayLayers = 1, .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = IMAGE_USAGE};
    VkMemoryRequirements needs;
    Image new;
    VK(vkCreateImage(device, &info, NULL, &new.image));
    vkGetImageMemoryRequirements(device, new.image, &needs);
    new.memory = allocate(physical, device, needs, 0);
    VK(vkBindImageMemory(device, new.image, new.memory, 0));
    VkImageViewCreateInfo of_image = {TYPE(IMAGE_VIEW_CREATE_INFO), .image = new.image, .format = FORMAT,
        .viewType = VK_IMAGE_VIEW_TYPE_2D, .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1}};
    VK(vkCreateImageView(device, &of_image, NULL, &new.view));
    return new;
}

static inline Commands create_commands(VkDevice device, uint32_t queue_family) {
    VkCommandPoolCreateInfo pool = {TYPE(COMMAND_POOL_CREATE_INFO), .queueFamilyIndex = queue_family,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
    VkFenceCreateInfo fence = {TYPE(FENCE_CREATE_INFO)};
    Commands new;
    vkGetDeviceQueue(device, queue_family, 0, &new.queue);
    VK(vkCreateCommandPool(device, &pool, NULL, &new.pool));
    VkCommandBufferAllocateInfo buffers = {TYPE(COMMAND_BUFFER_ALLOCATE_INFO), .commandPool = new.pool,
        .commandBufferCount = IN_FLIGHT};
    VK(vkAllocateCommandBuffers(device, &buffers, new.buffers));
    for (int n = 0; n < IN_FLIGHT; n++)
        VK(vkCreateFence(device, &fence, NULL, &new.fences[n]));
    return new;
}

static inline void begin(VkCommandBuffer commands) {
    VkCommandBufferBeginInfo info = {TYPE(COMMAND_BUFFER_BEGIN_INFO)};
    VK(vkBeginCommandBuffer(commands, &info));
}

static inline void submit(const Commands *commands, int slot) {
    VkSubmitInfo info = {TYPE(SUBMIT_INFO), .commandBufferCount = 1, .pCommandBuffers = &commands->buffers[slot]};
    VK(vkEndCommandBuffer(commands->buffers[slot]));
    VK(vkQueueSubmit(commands->queue, 1, &info, commands->fences[slot]));
}

/* Orders all commands before against all commands after; changes the layout of the depth image. */
static inline void change(VkCommandBuffer commands, Image image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier = {TYPE(IMAGE_MEMORY_BARRIER_2), .image = image.image,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
        .oldLayout = from, .newLayout = to, .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1}};
    VkDependencyInfo info = {TYPE(DEPENDENCY_INFO), .imageMemoryBarrierCount = 1,
        .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &info);
}

/* Begins a rendering of the host, which clears the depth image. */
static inline void begin_rendering(VkCommandBuffer commands, Image image) {
    VkRect2D area = {{0, 0}, {WIDTH, HEIGHT}};
    VkViewport viewport = {0, 0, WIDTH, HEIGHT, 0, 1};
    VkRenderingAttachmentInfo depth = {TYPE(RENDERING_ATTACHMENT_INFO), .imageView = image.view,
        .imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR, .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    VkRenderingInfo info = {TYPE(RENDERING_INFO), .renderArea = area, .layerCount = 1,
        .pDepthAttachment = &depth};
    change(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, depth.imageLayout);
    vkCmdBeginRendering(commands, &info);
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &area);
}

static inline void end_rendering(VkCommandBuffer commands, Image image) {
    vkCmdEndRendering(commands);
    change(commands, image, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

/* Copies the depth image, which is in the layout of a transfer source, to an offset in a buffer. */
static inline void copy(VkCommandBuffer commands, Image image, VkBuffer buffer, VkDeviceSize at) {
    VkBufferImageCopy region = {.bufferOffset = at, .imageExtent = {WIDTH, HEIGHT, 1},
        .imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1}};
    VkMemoryBarrier2 barrier = {TYPE(MEMORY_BARRIER_2), .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT, .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo to_host = {TYPE(DEPENDENCY_INFO), .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
    vkCmdPipelineBarrier2(commands, &to_host);
}

static inline void destroy(VkDevice device, Image image, Buffer buffer, Pipeline pipeline, Commands commands) {
    for (int n = 0; n < IN_FLIGHT; n++)
        vkDestroyFence(device, commands.fences[n], NULL);
    vkDestroyCommandPool(device, commands.pool, NULL);
    vkDestroyImageView(device, image.view, NULL);
    vkDestroyImage(device, image.image, NULL);
    vkFreeMemory(device, image.memory, NULL);
    vkDestroyBuffer(device, buffer.buffer, NULL);
    vkFreeMemory(device, buffer.memory, NULL);
    vkDestroyPipeline(device, pipeline.pipeline, NULL);
    vkDestroyPipelineLayout(device, pipeline.layout, NULL);
}
