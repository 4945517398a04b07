/* The scene of a file in an image, without Vulkan of its own: `show_file FILE OUT.ppm [DEVICE]`. All clips play, lights
 * have shadow maps, and the file's first camera sees it, or else the overview. The last frame is written. */
#include <antumbra_vulkan.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 640, HEIGHT = 360, FRAMES = 30, FRAMES_PER_S = 20 };
static AntumbraError error = ANTUMBRA_INIT(AntumbraError);

static void check(AntumbraResult result) {
    if (result == ANTUMBRA_RESULT_OK) return;
    fprintf(stderr, "antumbra: %s\n", error.message);
    exit(1);
}

/* Prints a warning, such as a note about a part of the file that is not shown. */
static void warn(void *user, uint32_t level, const char *message) {
    (void)user;
    fprintf(stderr, "antumbra, level %d: %s\n", (int)level, message);
}

int main(int argument_count, char **arguments) {
    if (argument_count < 3) return fprintf(stderr, "show_file FILE OUT.ppm [DEVICE]\n"), 2;
    AntumbraContextDesc context_desc = {.struct_size = sizeof context_desc, .abi_version = ANTUMBRA_ABI_VERSION,
        .log = warn};
    AntumbraContext *context;
    check(antumbra_context_create(&context_desc, &context, &error));
    AntumbraSceneFileDesc file_desc = {.struct_size = sizeof file_desc, .path = arguments[1]};
    AntumbraSceneFileInfo info = ANTUMBRA_INIT(AntumbraSceneFileInfo);
    AntumbraShadowDesc shadows = {.struct_size = sizeof shadows, .method = ANTUMBRA_SHADOWS_MAPS, .penumbra = 0.1F};
    AntumbraRendererDesc desc = {.struct_size = sizeof desc, .width = WIDTH, .height = HEIGHT, .shadows = &shadows};
    AntumbraDeviceOpenDesc device_desc = {.struct_size = sizeof device_desc, .name = arguments[3]};
    AntumbraRenderer renderer;
    check(antumbra_scene_file_load(context, &file_desc, &desc.scene_file, &error));
    check(antumbra_scene_file_info(context, desc.scene_file, &info, &error));
    check(antumbra_device_open(context, &device_desc, &desc.device, &error));
    check(antumbra_renderer_create(context, &desc, &renderer, &error));
    check(antumbra_renderer_play(context, renderer, NULL, ANTUMBRA_ALL_CLIPS, 0, 0, &error));
    for (int frame = 0; frame < FRAMES; frame++) {
        AntumbraCamera camera = ANTUMBRA_INIT(AntumbraCamera);
        AntumbraRenderDesc render = {.struct_size = sizeof render, .camera = &camera};
        const uint32_t eye = info.cameras ? 0 : ANTUMBRA_CAMERA_OVERVIEW;
        check(antumbra_renderer_advance(context, renderer, (double)frame / FRAMES_PER_S, &error));
        check(antumbra_renderer_camera(context, renderer, eye, &camera, &error));
        check(antumbra_renderer_render(context, renderer, &render, &error));
    }
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    check(antumbra_renderer_read_image(context, renderer, rgba, sizeof rgba, &error));
    FILE *out = fopen(arguments[2], "wb");
    if (!out) return perror(arguments[2]), 1;
    fprintf(out, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (size_t at = 0; at < sizeof rgba; at += 4) fwrite(rgba + at, 3, 1, out);
    if (ferror(out) | fclose(out)) return perror(arguments[2]), 1;
    printf("%s: %d frames of %d objects, with %d clips and %d lights\n", arguments[2], FRAMES, (int)info.objects,
           (int)info.clips, (int)info.lights);
    check(antumbra_context_destroy(context, &error));
    return 0;
}
