/* SPDX-License-Identifier: Apache-2.0 */
/* The demo: builds and draws a scene in which the layer must find nothing, then plants mistakes
 * that it must find. */
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plants.h"
#include "scene.h"
#include "scripts/tools/measure.h"

#define WIDTH 960
#define HEIGHT 540

static const char usage[] =
    "Usage: assay_demo [OPTION]... [MESH]\n"
    "Build and draw a scene with ray queries under " GPU_LAYER
    ",\n"
    "then repeat its builds with planted mistakes. Exit status 0 only if the layer finds\n"
    "nothing in the scene and every mistake, and the pictures agree.\n"
    "\n"
    "  --mesh MESH      a file that assimp reads (default: the bunny of glmark2-data)\n"
    "  --backend cpu    build with the layer's own reference, which needs no ray tracing of the\n"
    "                   driver's; trace the picture with it (scene-cpu.png), and show how far it "
    "is\n"
    "                   from a scene.png that is there (scene-difference.png)\n"
    "  --out-dir DIR    where pictures go (default: build/demo)\n"
    "  --no-picture     don't draw, and do without ray queries\n"
    "  --execute        send the mistakes to the driver, too: for one that none can crash\n"
    "  --help           print this and exit\n";

struct options {
    const char *mesh;
    const char *out_dir;
    bool picture;
    bool by_layer; /* backend cpu */
    bool executes; /* mistakes go to the driver */
};

/* Whether it is the layer's own. */
static bool main_backend(const char *name)
{
    if (strcmp(name, "driver") != 0 && strcmp(name, "cpu") != 0)
        tool_fail("--backend is driver or cpu, not %s", name);
    setenv("VK_ASSAY_VALIDATION_BACKEND", name, 1);
    return strcmp(name, "cpu") == 0;
}

static struct options main_options(int argc, char **argv)
{
    static const struct option known[] = {
        {"backend", required_argument, NULL, 'b'},
        {"help", no_argument, NULL, 'h'},
        {"mesh", required_argument, NULL, 'm'},
        {"no-picture", no_argument, NULL, 'n'},
        {"out-dir", required_argument, NULL, 'o'},
        {"execute", no_argument, NULL, 'e'},
        {0},
    };
    struct options options = {"/usr/share/glmark2/models/bunny.obj", "build/demo", true, false,
                              false};
    for (int option; (option = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        switch (option) {
        case 'b':
            options.by_layer = main_backend(optarg);
            break;
        case 'e':
            options.executes = true;
            break;
        case 'h':
            fputs(usage, stdout);
            exit(EXIT_SUCCESS);
        case 'm':
            options.mesh = optarg;
            break;
        case 'n':
            options.picture = false;
            break;
        case 'o':
            options.out_dir = optarg;
            break;
        default:
            exit(EXIT_FAILURE); /* getopt_long has said why */
        }
    }
    if (optind < argc)
        options.mesh = argv[optind++];
    if (optind < argc)
        tool_fail("one mesh at a time: what is %s?", argv[optind]);
    if (!*options.out_dir)
        tool_fail("--out-dir needs a folder");
    return options;
}

/* Whether the picture is that of scene.png, if there is one. */
static bool main_compare(const uint32_t *pixels, const char *out_dir)
{
    bool is_close = true;
    uint32_t *other = tool_alloc((size_t)WIDTH * HEIGHT, sizeof(*other));
    if (picture_read(out_dir, "scene.png", WIDTH, HEIGHT, other)) {
        const struct comparison found = compare_pictures(pixels, other, other, WIDTH * HEIGHT);
        picture_write(out_dir, "scene-difference.png", WIDTH, HEIGHT, other);
        /* Rounding may tip a few rays that graze an edge. */
        is_close = found.visible <= WIDTH * HEIGHT / 1000;
        printf(
            "difference: %s/scene-difference.png (%u of %u pixels, by at most %u of 255; %u by "
            "more than %d%s)\n",
            out_dir, found.differing, WIDTH * HEIGHT, found.largest, found.visible, COMPARE_VISIBLE,
            is_close ? "" : ": too many");
    }
    free(other);
    return is_close;
}

static bool main_draw(struct gpu *gpu, const struct scene *scene, const struct options *options)
{
    const double start = read_clock(CLOCK_MONOTONIC);
    const char *name = options->by_layer ? "scene-cpu.png" : "scene.png";
    uint32_t *pixels = tool_alloc((size_t)WIDTH * HEIGHT, sizeof(*pixels));
    (options->by_layer ? trace_scene : render_scene)(gpu, scene, WIDTH, HEIGHT, pixels);
    picture_write(options->out_dir, name, WIDTH, HEIGHT, pixels);
    printf("picture: %s/%s (%d x %d, %.1f s)\n", options->out_dir, name, WIDTH, HEIGHT,
           (read_clock(CLOCK_MONOTONIC) - start) / 1e9);
    const bool is_good = !options->by_layer || main_compare(pixels, options->out_dir);
    free(pixels);
    return is_good;
}

static void main_build(struct scene *scene, struct gpu *gpu, const char *path)
{
    struct mesh mesh;
    mesh_load(&mesh, path);
    printf("mesh: %s (%u vertices, %u triangles)\n", path, mesh.vertex_count, mesh.triangle_count);

    const double start = read_clock(CLOCK_MONOTONIC);
    scene_create(scene, gpu, &mesh);
    printf(
        "built: BLAS of %u triangles, BLAS of %u boxes, an update, a compaction, "
        "TLAS of %u instances (%.1f s)\n",
        scene->triangle_count, scene->box_count, scene->instance_count,
        (read_clock(CLOCK_MONOTONIC) - start) / 1e9);
    mesh_free(&mesh);
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    const struct options options = main_options(argc, argv);

    struct findings findings = {.executes = options.executes};
    struct gpu gpu;
    struct scene scene;
    const VkDebugUtilsMessengerCreateInfoEXT messenger = findings_messenger(&findings);
    gpu_open(&gpu, NULL, &messenger, options.picture && !options.by_layer);
    findings_require_layer();
    printf("device: %s, under %s%s\n", gpu.properties.deviceName, GPU_LAYER,
           options.by_layer ? ", which builds" : "");
    main_build(&scene, &gpu, options.mesh);
    const bool is_good = !options.picture || main_draw(&gpu, &scene, &options);
    printf("findings: %u\n", findings.clean_count);

    const struct mistakes_score score = mistakes_run(&gpu, &scene, &findings);
    scene_destroy(&scene, &gpu);
    gpu_close(&gpu);

    printf("\nclean scene: %u findings; planted: %u of %u caught\n", findings.clean_count,
           score.caught, score.planted);
    if (fflush(stdout) || ferror(stdout))
        tool_fail("the output could not be written");
    const bool passed = is_good && findings.clean_count == 0 && score.caught == score.planted;
    return passed ? EXIT_SUCCESS : EXIT_FAILURE;
}
