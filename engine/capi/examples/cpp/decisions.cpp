// Decisions alone, with a ray caster in place of a GPU. The ray caster draws what the plans say,
// tests boxes by counting pixels, and returns the counts two frames late. Each image must equal the
// image by brute force.
#include <antumbra.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <vector>

namespace {

constexpr uint32_t WIDTH = 64, HEIGHT = 36, FRAMES = 24, COUNT = 1000;
constexpr float NEAR = 0.1F, TAN_Y = 0.5F, TAN_X = TAN_Y * WIDTH / HEIGHT;
AntumbraError error = ANTUMBRA_INIT(AntumbraError);

void check(AntumbraResult result) {
    if (result != ANTUMBRA_RESULT_OK) {
        std::fprintf(stderr, "antumbra: %s\n", error.message);
        std::exit(1);
    }
}

// The depths and the objects of an image, seen from an eye that looks along -z.
struct Image {
    float eye[3];
    std::vector<float> depths = std::vector<float>(WIDTH * HEIGHT, INFINITY);
    std::vector<uint32_t> objects = std::vector<uint32_t>(WIDTH * HEIGHT, ANTUMBRA_NO_OBJECT);

    // Returns the depth at which a pixel's ray enters a box; infinity if it misses.
    float depth(const AntumbraAabb &box, uint32_t pixel) const {
        const float x = (static_cast<float>(pixel % WIDTH) + 0.5F) / WIDTH;
        const float y = (static_cast<float>(pixel / WIDTH) + 0.5F) / HEIGHT;
        const float ray[3] = {(2.0F * x - 1.0F) * TAN_X, (1.0F - 2.0F * y) * TAN_Y, -1.0F};
        float first = NEAR, last = INFINITY;
        for (int axis = 0; axis < 3; axis++) {
            const float a = (box.min[axis] - eye[axis]) / ray[axis];
            const float b = (box.max[axis] - eye[axis]) / ray[axis];
            first = std::fmax(first, std::fmin(a, b));
            last = std::fmin(last, std::fmax(a, b));
        }
        return first <= last ? first : INFINITY;
    }

    // Draws an object or, if `writes` is null, tests a box. Returns the pixels that pass.
    uint32_t draw(const AntumbraAabb &box, const uint32_t *writes) {
        uint32_t samples = 0;
        for (uint32_t pixel = 0; pixel < WIDTH * HEIGHT; pixel++) {
            const float here = depth(box, pixel);
            if (here == INFINITY || here > depths[pixel])
                continue;
            samples++;
            // Of two objects at the same depth, the lower number wins in any order.
            if (writes && (here < depths[pixel] || *writes < objects[pixel])) {
                depths[pixel] = here;
                objects[pixel] = *writes;
            }
        }
        return samples;
    }
};

// Returns a wall, and a thousand boxes behind it. The boxes at the edge of the wall show.
std::vector<AntumbraAabb> boxes() {
    std::vector<AntumbraAabb> boxes = {{{-4, -3, -6}, {4, 3, -5.5F}}};
    for (uint32_t number = 0; number < COUNT; number++) {
        const float x = static_cast<float>(number % 20) * 0.7F - 7.0F;
        const float y = static_cast<float>(number / 20 % 10) * 0.7F - 3.5F;
        const float z = -12.0F - static_cast<float>(number / 200) * 1.3F;
        boxes.push_back({{x, y, z}, {x + 0.45F, y + 0.45F, z + 0.45F}});
    }
    return boxes;
}

AntumbraCamera view_from(const float (&eye)[3]) {
    AntumbraCamera view = ANTUMBRA_INIT(AntumbraCamera);
    view.sub_pixel_bits = 16; // A ray caster of 64 pixels in floats moves no corner to a grid.
    view.width = WIDTH;
    view.height = HEIGHT;
    const float x = 1.0F / TAN_X, y = -1.0F / TAN_Y;
    const float matrix[16] = {x, 0, 0, 0,  0, y, 0, 0,  0, 0, 0, -1,
                              -x * eye[0], -y * eye[1], NEAR, eye[2]};
    for (int at = 0; at < 16; at++)
        view.clip_from_world[at] = matrix[at];
    return view;
}

} // namespace

int main() {
    AntumbraContextDesc context_desc = ANTUMBRA_INIT(AntumbraContextDesc);
    context_desc.abi_version = ANTUMBRA_ABI_VERSION;
    AntumbraContext *context = nullptr;
    check(antumbra_context_create(&context_desc, &context, &error));

    const std::vector<AntumbraAabb> all = boxes();
    AntumbraHierarchyDesc hierarchy_desc = ANTUMBRA_INIT(AntumbraHierarchyDesc);
    hierarchy_desc.boxes = all.data();
    hierarchy_desc.box_count = all.size();
    AntumbraHierarchy hierarchy = {};
    check(antumbra_hierarchy_create(context, &hierarchy_desc, &hierarchy, &error));
    AntumbraCullerDesc culler_desc = ANTUMBRA_INIT(AntumbraCullerDesc);
    AntumbraCuller culler = {};
    check(antumbra_culler_create(context, &culler_desc, &culler, &error));
    AntumbraLeaves leaves = ANTUMBRA_INIT(AntumbraLeaves);
    check(antumbra_hierarchy_leaves(context, hierarchy, &leaves, &error));

    std::deque<std::vector<AntumbraAnswer>> late(2);
    size_t drawn = 0;
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        const auto &known = late.front();
        check(antumbra_culler_ingest(context, culler, hierarchy, known.data(), known.size(),
                                     &error));
        late.pop_front();

        // The eye jumps to another side of the wall, so that hidden boxes show at once.
        const float side = static_cast<float>(frame / 8 % 3) - 1.0F;
        Image image = {{side * 9.0F + static_cast<float>(frame) * 0.04F, 0, 3}};
        const AntumbraCamera view = view_from(image.eye);
        AntumbraPlanDesc plan_desc = ANTUMBRA_INIT(AntumbraPlanDesc);
        plan_desc.camera = &view;
        AntumbraFramePlan plan = ANTUMBRA_INIT(AntumbraFramePlan);
        check(antumbra_culler_plan(context, culler, hierarchy, &plan_desc, &plan, &error));

        std::vector<AntumbraAnswer> answers;
        drawn = plan.draw_count;
        for (size_t at = 0; at < plan.draw_count; at++) {
            const AntumbraDraw &draw = plan.draws[at];
            const uint32_t samples = image.draw(all[draw.object], &draw.object);
            if (draw.query != ANTUMBRA_NO_QUERY)
                answers.push_back({plan.queries[draw.query], samples, 0});
        }
        for (size_t round = 0; round < plan.round_count; round++) {
            const AntumbraTest *tests = plan.tests + plan.rounds[round].first_test;
            const size_t before = answers.size();
            for (uint32_t at = 0; at < plan.rounds[round].test_count; at++)
                answers.push_back({tests[at].tag, image.draw(tests[at].bounds, nullptr), 0});
            for (uint32_t at = 0; at < plan.rounds[round].test_count; at++) {
                const uint32_t *objects = leaves.objects + tests[at].first_leaf;
                const uint32_t count = answers[before + at].samples > 0 ? tests[at].leaf_count : 0;
                for (uint32_t leaf = 0; leaf < count; leaf++)
                    image.draw(all[objects[leaf]], &objects[leaf]);
                drawn += count;
            }
        }
        late.push_back(answers);

        Image brute = {{image.eye[0], image.eye[1], image.eye[2]}};
        for (uint32_t object = 0; object < all.size(); object++)
            brute.draw(all[object], &object);
        if (brute.objects != image.objects) {
            std::fprintf(stderr, "frame %u differs from brute force\n", frame);
            return 1;
        }
    }
    std::printf("%u frames equal to brute force; the last drew %zu of %zu boxes\n", FRAMES, drawn,
                all.size());
    check(antumbra_context_destroy(context, &error));
    return drawn < all.size() / 2 ? 0 : 1;
}
