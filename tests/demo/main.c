/* SPDX-License-Identifier: Apache-2.0 */
/* The demo: builds and draws a scene in which the layer must find nothing, then plants mistakes
 * that it must find. */
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fail.h"
#include "findings.h"
#include "gpu.h"
#include "mesh.h"
#include "mistakes.h"
#include "picture.h"
#include "render.h"
#include "scene.h"

#define WIDTH 960
#define HEIGHT 540

static const char usage[] =
    "Usage: assay_demo [OPTION]... [MESH]\n"
    "Build and draw a scene with ray queries under " GPU_LAYER
    ",\n"
    "then repeat its builds with planted mistakes. Exit status 0 only if the layer finds\n"
    "nothing in the scene and every mistake.\n"
    "\n"
    "  --mesh MESH      a file that assimp reads (default: the bunny of glmark2-data)\n"
    "  --out-dir DIR    where scene.png goes (default: build/demo)\n"
    "  --no-picture     don't draw, and do without ray queries\n"
    "  --help           print this and exit\n";

struct options {
    const char *mesh;
    const char *out_dir;
    bool picture;
};

static struct options main_options(int argc, char **argv)
{
    static const struct option known[] = {
        {"help", no_argument, NULL, 'h'},
        {"mesh", required_argument, NULL, 'm'},
        {"no-picture", no_argument, NULL, 'n'},
        {"out-dir", required_argument, NULL, 'o'},
        {0},
    };
    struct options options = {"/usr/share/glmark2/models/bunny.obj", "build/demo", true};
    for (int option; (option = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        switch (option) {
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
        demo_fail("one mesh at a time: what is %s?", argv[optind]);
    if (!*options.out_dir)
        demo_fail("--out-dir needs a folder");
    return options;
}

static double main_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void main_draw(struct gpu *gpu, const struct scene *scene, const char *out_dir)
{
    const double start = main_seconds();
    uint32_t *pixels = demo_alloc((size_t)WIDTH * HEIGHT, sizeof(*pixels));
    render_scene(gpu, scene, WIDTH, HEIGHT, pixels);
    picture_write(out_dir, "scene.png", WIDTH, HEIGHT, pixels);
    free(pixels);
    printf("picture: %s/scene.png (%d x %d, %.1f s)\n", out_dir, WIDTH, HEIGHT,
           main_seconds() - start);
}

static void main_build(struct scene *scene, struct gpu *gpu, const char *path)
{
    struct mesh mesh;
    mesh_load(&mesh, path);
    printf("mesh: %s (%u vertices, %u triangles)\n", path, mesh.vertex_count, mesh.triangle_count);

    const double start = main_seconds();
    scene_create(scene, gpu, &mesh);
    printf(
        "built: BLAS of %u triangles, BLAS of %u boxes, an update, a compaction, "
        "TLAS of %u instances (%.1f s)\n",
        scene->triangle_count, scene->box_count, scene->instance_count, main_seconds() - start);
    mesh_free(&mesh);
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    const struct options options = main_options(argc, argv);

    struct findings findings = {0};
    struct gpu gpu;
    struct scene scene;
    gpu_open(&gpu, &findings, options.picture);
    printf("device: %s, under %s\n", gpu.properties.deviceName, GPU_LAYER);
    main_build(&scene, &gpu, options.mesh);
    if (options.picture)
        main_draw(&gpu, &scene, options.out_dir);
    printf("findings: %u\n", findings.clean_count);

    const struct mistakes_score score = mistakes_run(&gpu, &scene, &findings);
    scene_destroy(&scene, &gpu);
    gpu_close(&gpu);

    printf("\nclean scene: %u findings; planted: %u of %u caught\n", findings.clean_count,
           score.caught, score.planted);
    if (fflush(stdout) || ferror(stdout))
        demo_fail("the output could not be written");
    const bool passed = findings.clean_count == 0 && score.caught == score.planted;
    return passed ? EXIT_SUCCESS : EXIT_FAILURE;
}
