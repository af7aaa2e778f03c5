/* SPDX-License-Identifier: Apache-2.0 */
/* Repeats the scene's builds with planted mistakes. What they record is dropped, never submitted.
 */
#include <stdio.h>
#include <string.h>

#include "plants.h"

/* Record the valid call that `base` names, changed by `plant` unless that is null. */
static bool mistakes_record(struct plant_site *site, enum plant_base base,
                            const struct plant *plant, struct findings *findings)
{
    static void (*const describe[])(const struct scene *, const struct gpu *,
                                    struct build_call *) = {
        [PLANT_BASE_BOTTOM] = scene_describe_bottom,
        [PLANT_BASE_UPDATE] = scene_describe_update,
        [PLANT_BASE_TOP] = scene_describe_top,
    };
    describe[base](site->scene, site->gpu, &site->call);
    site->commands = gpu_begin(site->gpu);
    site->is_possible = true;
    if (plant)
        plant->make(site);
    if (site->is_possible) {
        findings->planted = plant != NULL;
        build_call_record(site->gpu, site->commands, &site->call);
        findings->planted = false;
        if (plant && plant->unmake)
            plant->unmake(site);
    }
    gpu_drop(site->gpu, site->commands);
    return site->is_possible;
}

static void mistakes_print(const struct plant *plant, const struct findings *findings)
{
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i)
        findings_print(findings->kept[i].text, "    ");
    if (findings_have(findings, plant->vuid))
        printf("  caught: %s\n", plant->vuid);
    else
        printf("  MISSED: %s\n", plant->vuid);
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i)
        if (strcmp(findings->kept[i].id, plant->vuid) != 0)
            printf("  and also: %s\n", findings->kept[i].id);
}

struct mistakes_score mistakes_run(struct gpu *gpu, const struct scene *scene,
                                   struct findings *findings)
{
    struct plant_objects objects;
    plant_objects_create(&objects, gpu, scene);
    struct plant_site site = {.gpu = gpu, .scene = scene, .objects = &objects};

    /* The calls that mistakes start from, unchanged: whatever comes now counts for the scene. */
    mistakes_record(&site, PLANT_BASE_BOTTOM, NULL, findings);
    mistakes_record(&site, PLANT_BASE_UPDATE, NULL, findings);
    mistakes_record(&site, PLANT_BASE_TOP, NULL, findings);

    struct mistakes_score score = {0};
    for (uint32_t i = 0; i < plant_count; ++i) {
        const struct plant *plant = &plants[i];
        findings_clear(findings);
        printf("\nplanted %u of %u: %s\n", i + 1, plant_count, plant->what);
        if (!mistakes_record(&site, plant->base, plant, findings)) {
            printf("  left out: this device can't express it\n");
            continue;
        }
        mistakes_print(plant, findings);
        ++score.planted;
        score.caught += findings_have(findings, plant->vuid);
    }
    findings_clear(findings);
    plant_objects_destroy(&objects, gpu);
    return score;
}
