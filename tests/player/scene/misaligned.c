/* SPDX-License-Identifier: Apache-2.0 */
/* Copying a scene to a place one byte behind what is aligned. */
#include "tests/player/scene/scene.h"

#include <string.h>

/* Makes a pointer that leads into the scene lead to the same place of its copy. */
static void redirect(const struct scene *scene, const char *copy, void *pointer)
{
    uintptr_t to;
    memcpy(&to, pointer, sizeof(to));
    if (to - (uintptr_t)scene >= sizeof(*scene))
        return;
    to += (uintptr_t)copy - (uintptr_t)scene;
    memcpy(pointer, &to, sizeof(to));
}

void scene_misalign(struct scene *scene)
{
    static _Thread_local _Alignas(struct scene) char room[sizeof(*scene) + 1];
    char *copy = room + 1;
    void *const arguments[] = {&scene->infos_argument,
                               &scene->ranges_argument,
                               &scene->counts_argument,
                               &scene->indirect_addresses_argument,
                               &scene->indirect_strides_argument,
                               &scene->nv.info_argument};
    memcpy(copy, scene, sizeof(*scene));
    for (size_t at = 0; at < sizeof(*scene); at += sizeof(void *))
        redirect(scene, copy, copy + at);
    for (size_t i = 0; i < sizeof(arguments) / sizeof(arguments[0]); i++)
        redirect(scene, copy, arguments[i]);
}
