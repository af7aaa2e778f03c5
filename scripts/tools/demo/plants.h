/* SPDX-License-Identifier: Apache-2.0 */
/* The mistakes: what each changes in a valid build, in words, and the VUID that must come. */
#ifndef DEMO_PLANTS_H
#define DEMO_PLANTS_H

#include <stdbool.h>

#include "scene.h"

/* ---- what the layer says in the debug callback, kept to be counted and compared (findings.c) */

#define FINDINGS_KEPT                                                                              \
    32 /* a planted mistake yields one or two; beyond this they are only counted */

struct finding {
    char *id; /* the VUID */
    char *text;
};

/* Written by the callback, on the thread that makes the call; the demo has one thread. */
struct findings {
    uint32_t clean_count; /* arrived while nothing was planted; printed on arrival, not kept */
    /* While this is set, what arrives is kept, and the callback asks for the call to be skipped, so
     * that the driver never sees the mistake. */
    bool planted;
    bool executes; /* the callback asks for nothing, and the mistakes are submitted */
    uint32_t count;
    struct finding kept[FINDINGS_KEPT];
};

/* Forget what is kept. */
void findings_clear(struct findings *findings);
bool findings_have(const struct findings *findings, const char *vuid);

/* A messenger for validation warnings and errors, to chain to VkInstanceCreateInfo as well. */
VkDebugUtilsMessengerCreateInfoEXT findings_messenger(struct findings *findings);

/* Ends the process if the layer that should find mistakes is not loaded. */
void findings_require_layer(void);

/* Print a text of several lines, each behind `margin`. */
void findings_print(const char *text, const char *margin);

/* ---- mistakes */

/* Objects that only mistakes use. */
struct plant_objects {
    struct gpu_buffer shared;         /* for structures and scratch that get in each other's way */
    struct gpu_structure shared_low;  /* in `shared` at offset 0, large enough for the mesh */
    struct gpu_structure shared_next; /* in `shared` 256 bytes on, large enough for the boxes */
    struct gpu_structure small;       /* half the size that the mesh needs */
    struct gpu_structure of_top_type; /* large enough for the mesh, but a TLAS */
    struct gpu_structure unbacked;    /* large enough for the mesh, its memory freed */
    struct gpu_buffer no_input;       /* vertices in a buffer that isn't for build inputs */
    struct gpu_buffer no_storage;     /* scratch in a buffer that isn't a storage buffer */
    VkRenderPass pass;                /* these two null where the queue can't draw */
    VkFramebuffer framebuffer;
};

/* One mistake being planted: a valid call and the command buffer that it is about to go to. */
struct plant_site {
    struct gpu *gpu;
    const struct scene *scene;
    const struct plant_objects *objects;
    VkCommandBuffer commands;
    struct build_call call;
    bool is_possible; /* set before the mistake is made; false if this device can't express it */
};

/* The call that a mistake starts from. */
enum plant_base {
    PLANT_BASE_BOTTOM, /* build 0 the mesh, build 1 the boxes */
    PLANT_BASE_UPDATE,
    PLANT_BASE_TOP,
};

struct plant {
    const char *what; /* planted, in plain words */
    const char *vuid;
    void (*make)(struct plant_site *site);
    enum plant_base base;
    void (*unmake)(struct plant_site *site); /* afterwards, or null */
};

extern const struct plant plants[];
extern const uint32_t plant_count;

/* Repeats the scene's builds with planted mistakes and prints what the layer says about each. */
struct mistakes_score {
    uint32_t planted;
    uint32_t caught;
};

struct mistakes_score mistakes_run(struct gpu *gpu, const struct scene *scene,
                                   struct findings *findings);

#endif
