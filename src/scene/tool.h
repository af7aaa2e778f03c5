/* SPDX-License-Identifier: Apache-2.0 */
/* The commands of assay-scene. Each returns false, with an error, if it cannot do its work. */
#ifndef ASSAY_SCENE_TOOL_H
#define ASSAY_SCENE_TOOL_H

#include <jansson.h>

#include "src/scene/capture.h"

/* Prints what a capture has: as tables, in which `lists_all` also has what is more than a screen
 * holds, or as JSON. */
bool info_print(struct capture *capture, bool is_json, bool lists_all, struct capture_error *error);

/* Returns the same as JSON, which the caller releases, or NULL with an error. */
json_t *info_make(struct capture *capture, struct capture_error *error);

struct export_options {
    const char *at;       /* of capture_find_point(); NULL: the end */
    const char *tlas;     /* name or id; NULL: the last that was built */
    bool colors_flags;    /* of geometries; otherwise structures have colors */
    bool has_plain_nodes; /* each instance is a node, however many there are */
};

/* Writes a top-level structure and all that its instances refer to as glTF 2.0, in binary form. */
bool export_gltf(struct capture *capture, const char *path, const struct export_options *options,
                 struct capture_error *error);

/* Writes what the 3D view on the page of assay-run shows, as JSON with at most about `limit` bytes
 * of data before their encoding. */
bool export_view(struct capture *capture, const char *path, uint64_t limit,
                 struct capture_error *error);

struct replay_options {
    bool uses_layer; /* the layer of this project checks what is replayed */
    bool compares;   /* it also compares hits with the reference builder */
    bool shows_times;
    uint32_t repeat;  /* how often each call is replayed; 0: once */
    const char *dump; /* folder for the serialized structures at the end; NULL: none */
};

/* Builds all of a capture again on the first device that can, and prints what it does. Returns
 * false, with an error, unless all builds and copies succeed. */
bool replay_capture(struct capture *capture, const struct replay_options *options,
                    struct capture_error *error);

/* Writes a new folder with the smallest part of the capture that still gives the finding when it is
 * replayed under the layer: builds, geometries and primitives are left out. Each try is a process
 * of its own. Returns false, with an error, if the whole capture does not give it. */
bool minimize_capture(struct capture *capture, const char *finding, const char *folder,
                      struct capture_error *error);

struct report_options {
    const char *at, *tlas;   /* as those of export_options */
    const char *html, *json; /* files; NULL: none */
    const char *device;      /* NULL: the first that traces; "none" */
    bool has_camera;
    double camera[6]; /* where it is, and a point that it looks at */
    uint32_t rays;    /* of a set; 0: the default */
    bool shows_progress;
};

/* Measures the scene of a capture with the reference builder, and on a device if there is one:
 * what accuracy costs, what is fragile, which effects it has and what it wastes. Writes a page and
 * JSON. */
bool report_capture(struct capture *capture, const struct report_options *options,
                    struct capture_error *error);

#endif
