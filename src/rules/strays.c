/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the sType of structures that extensions chain. A structure in a chain is identified
 * by its sType alone, so an invalid sType is a guess at the structure that was meant: one of the
 * same extension, or the motion data that a build with motion lacks. */
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

enum { CHAIN_BOUND = 64 };

static const struct device_facts *device_of(const struct geometry_view *geometry)
{
    return geometry->build->call->device;
}

static int extension_of(VkStructureType type)
{
    return (int)type / 1000;
}

static bool is_of_extension(const struct chain_facts *chain, bool is_enabled,
                            VkStructureType expected)
{
    return is_enabled && chain->has_stray && chain->stray != expected &&
           extension_of(chain->stray) == extension_of(expected);
}

static bool names_chain(const struct geometry_view *geometry, struct finding *finding,
                        enum rule rule)
{
    return !device_of(geometry)->newer_than_registry && also_violates(finding, rule);
}

/* ---- structures of micromaps */

static const struct {
    enum rule rule;
    VkStructureType type;
} of_triangles[] = {
    {RULE_opacity_has_its_stype,
     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR},
    {RULE_ext_opacity_has_its_stype,
     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT},
    {RULE_displacement_has_its_stype,
     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV},
};

static bool extension_is_enabled(const struct geometry_view *geometry, enum rule rule)
{
    const struct device_facts *device = device_of(geometry);
    switch ((int)rule) {
    case RULE_ext_opacity_has_its_stype:
        return device->extension.opacity_micromap_ext;
    case RULE_displacement_has_its_stype:
        return device->extension.displacement_micromap_nv;
    default:
        return device->extension.opacity_micromap_khr;
    }
}

static bool stray_is_not(const struct chain_facts *chain, struct finding *finding,
                         const char *field, VkStructureType expected)
{
    return violated(finding, field,
                    "has a structure of type {}, but the only type of its extension that is valid "
                    "in this chain is {}",
                    structure_type(chain->stray), structure_type(expected));
}

static bool has_its_stype(const struct micromap_geometry_view *view, struct finding *finding,
                          size_t kind)
{
    const struct geometry_view *geometry = view->geometry;
    const struct chain_facts *chain = &geometry->triangles_chain;
    return !is_of_extension(chain, extension_is_enabled(geometry, of_triangles[kind].rule),
                            of_triangles[kind].type) ||
           stray_is_not(chain, finding, "geometry.triangles.pNext", of_triangles[kind].type) ||
           names_chain(geometry, finding, RULE_triangles_chain_is_known);
}

bool opacity_has_its_stype(const struct micromap_geometry_view *micromap_geometry,
                           struct finding *finding)
{
    return has_its_stype(micromap_geometry, finding, 0);
}

bool ext_opacity_has_its_stype(const struct micromap_geometry_view *micromap_geometry,
                               struct finding *finding)
{
    return has_its_stype(micromap_geometry, finding, 1);
}

bool displacement_has_its_stype(const struct micromap_geometry_view *micromap_geometry,
                                struct finding *finding)
{
    return has_its_stype(micromap_geometry, finding, 2);
}

enum rule rule_of_stray(const struct geometry_view *geometry)
{
    return is_of_extension(&geometry->chain,
                           extension_is_enabled(geometry, RULE_micromap_data_has_its_stype),
                           VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR)
               ? RULE_micromap_data_has_its_stype
               : RULE_COUNT;
}

/* The geometry lacks the data if the stray takes its place. */
static bool names_missing_data(const struct micromap_geometry_view *view, struct finding *finding)
{
    return type_is_micromap(view->geometry->geometry->geometryType) && !view->has_data &&
           !view->geometry->chain.unreadable && !view->geometry->chain.has_duplicate &&
           also_violates(finding, RULE_micromap_geometry_has_micromap_data);
}

bool micromap_data_has_its_stype(const struct micromap_geometry_view *micromap_geometry,
                                 struct finding *finding)
{
    const struct geometry_view *geometry = micromap_geometry->geometry;
    return rule_of_stray(geometry) == RULE_COUNT ||
           stray_is_not(&geometry->chain, finding, "pNext",
                        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR) ||
           names_chain(geometry, finding, RULE_geometry_chain_is_known) ||
           names_missing_data(micromap_geometry, finding);
}

/* ---- motion */

static bool has_motion_data(const struct geometry_view *geometry)
{
    const VkBaseInStructure *s = triangles_in(geometry->geometry)->pNext;
    for (int i = 0; s && i < CHAIN_BOUND; s = s->pNext, i++)
        if (s->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV)
            return true;
    return false;
}

/* If a build with motion lacks motion data and the chain has exactly one unexpected structure, that
 * structure is motion data with a wrong sType. */
static bool is_motion_data(const struct geometry_view *geometry)
{
    const struct chain_facts *chain = &geometry->triangles_chain;
    return device_of(geometry)->extension.motion_blur_nv && triangles_in(geometry->geometry) &&
           geometry->build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV &&
           !chain->unreadable && !chain->has_duplicate && chain->has_stray &&
           !device_of(geometry)->newer_than_registry && !has_motion_data(geometry);
}

bool motion_triangles_have_their_stype(const struct motion_triangles_view *motion_triangles,
                                       struct finding *finding)
{
    const struct geometry_view *geometry = motion_triangles->geometry;
    return !is_motion_data(geometry) ||
           violated(finding, "geometry.triangles.pNext",
                    "has a structure of type {}, but a build with motion requires "
                    "VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV",
                    structure_type(geometry->triangles_chain.stray)) ||
           names_chain(geometry, finding, RULE_triangles_chain_is_known);
}

enum rule rule_of_triangles_stray(const struct geometry_view *geometry)
{
    for (size_t i = 0; i < sizeof(of_triangles) / sizeof(of_triangles[0]); i++)
        if (is_of_extension(&geometry->triangles_chain,
                            extension_is_enabled(geometry, of_triangles[i].rule),
                            of_triangles[i].type))
            return of_triangles[i].rule;
    return is_motion_data(geometry) ? RULE_motion_triangles_have_their_stype : RULE_COUNT;
}
