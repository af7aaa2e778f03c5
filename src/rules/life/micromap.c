/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about builds of micromaps of VK_EXT_opacity_micromap, except for host memory and the data
 * of triangles (micromap_inputs.c). */
#include "src/rules/micromap/shared.h"
#include "src/rules/predicates.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

/* ---- usages */

static bool is_of_opacity(const struct micromap_info_view *view)
{
    return view->info->type == VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT;
}

static bool is_of_displacement(const struct micromap_info_view *view)
{
    return view->info->type == VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV;
}

bool built_micromap_has_one_usage_array(const struct micromap_info_view *micromap_info,
                                        struct finding *finding)
{
    return usages_are_given_once(&micromap_info->usages, finding);
}

bool built_opacity_usage_format_is_valid(const struct micromap_info_view *micromap_info,
                                         struct finding *finding)
{
    return !is_of_opacity(micromap_info) || micromap_info->call->device->newer_than_registry ||
           usage_formats_are_valid(&micromap_info->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
                                   "VkOpacityMicromapFormatEXT", finding);
}

bool built_displacement_usage_format_is_valid(const struct micromap_info_view *micromap_info,
                                              struct finding *finding)
{
    return !is_of_displacement(micromap_info) || micromap_info->call->device->newer_than_registry ||
           usage_formats_are_valid(&micromap_info->usages,
                                   VK_DISPLACEMENT_MICROMAP_FORMAT_1024_TRIANGLES_128_BYTES_NV,
                                   "VkDisplacementMicromapFormatNV", finding);
}

bool built_2_state_usage_level_is_within_limit(const struct micromap_info_view *micromap_info,
                                               struct finding *finding)
{
    return !is_of_opacity(micromap_info) ||
           usage_levels_are_within(
               &micromap_info->usages, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT,
               micromap_info->call->device->micromap.ext_limits.opacity_2_state_level,
               "maxOpacity2StateSubdivisionLevel", finding);
}

bool built_4_state_usage_level_is_within_limit(const struct micromap_info_view *micromap_info,
                                               struct finding *finding)
{
    return !is_of_opacity(micromap_info) ||
           usage_levels_are_within(
               &micromap_info->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
               micromap_info->call->device->micromap.ext_limits.opacity_4_state_level,
               "maxOpacity4StateSubdivisionLevel", finding);
}

bool built_displacement_usage_level_is_within_limit(const struct micromap_info_view *micromap_info,
                                                    struct finding *finding)
{
    return !is_of_displacement(micromap_info) ||
           usage_levels_are_within(&micromap_info->usages, ANY_FORMAT,
                                   micromap_info->call->device->micromap.displacement_level,
                                   "maxDisplacementMicromapSubdivisionLevel", finding);
}

bool built_micromap_mode_is_valid(const struct built_micromap_view *built_micromap,
                                  struct finding *finding)
{
    const VkBuildMicromapModeEXT mode = built_micromap->info->mode;
    return mode == VK_BUILD_MICROMAP_MODE_BUILD_EXT ||
           built_micromap->call->device->newer_than_registry ||
           violated(finding, "mode", "{} is not a VkBuildMicromapModeEXT", number(mode));
}

/* ---- the micromap */

bool built_micromap_is_valid(const struct built_micromap_view *built_micromap,
                             struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    return (dst->handle && dst->alive != NO) || dst->of_another_device ||
           violated_by_handle(finding, "dstMicromap", life_object_value(dst),
                              "a micromap of this device");
}

static struct value type_of(uint32_t type)
{
    return phrase(type == VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT
                      ? "VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT"
                      : "VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV");
}

/* Types that do not exist have an id of their own. */
bool built_micromap_has_the_type_it_was_created_with(
    const struct built_micromap_view *built_micromap, struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    const uint32_t type = built_micromap->info->type;
    return !dst->details_known || type == dst->type ||
           violated(finding, "type", "is {}, but {} was created with type {}", type_of(type),
                    life_object_value(dst), type_of(dst->type));
}

bool built_micromap_is_large_enough(const struct built_micromap_view *built_micromap,
                                    struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    const struct micromap_size_facts *sizes = &built_micromap->sizes;
    return !sizes->known || !dst->details_known || dst->size >= sizes->micromap ||
           violated(finding, "dstMicromap",
                    "{} was created with size {}, less than micromapSize "
                    "({})",
                    life_object_value(dst), number(dst->size), number(sizes->micromap));
}

static struct value buffer_of(const struct life_object *dst)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(dst->buffer));
}

bool built_micromap_is_backed(const struct built_micromap_view *built_micromap,
                              struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    return dst->backed != NO || violated_by_buffer_of(dst, finding, "dstMicromap");
}

bool built_micromap_is_host_visible(const struct built_micromap_view *built_micromap,
                                    struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    if (dst->host_visible == NO)
        return violated(finding, "dstMicromap",
                        "{} lies in {}, which is bound to memory without "
                        "VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT",
                        life_object_value(dst), buffer_of(dst));
    return built_micromap_is_backed(built_micromap, finding);
}

bool built_micromap_has_one_memory_instance(const struct built_micromap_view *built_micromap,
                                            struct finding *finding)
{
    const struct life_object *dst = &built_micromap->dst;
    return dst->multi_instance != YES ||
           violated(finding, "dstMicromap",
                    "{} lies in {}, which is bound to memory that was allocated with multiple "
                    "instances",
                    life_object_value(dst), buffer_of(dst));
}

/* ---- scratch in device memory */

#define SCRATCH "scratchData.deviceAddress"

static struct value buffer_at(const struct address_facts *facts)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer));
}

/* Returns 0 if it is unknown. */
static VkDeviceSize scratch_size(const struct built_micromap_view *built)
{
    return built->sizes.known ? built->sizes.build_scratch : 0;
}

static bool is_in_no_buffer(const struct address_facts *facts)
{
    return facts->status == ADDRESS_NULL || facts->status == ADDRESS_NOWHERE;
}

bool built_micromap_scratch_is_aligned(const struct built_micromap_view *built_micromap,
                                       struct finding *finding)
{
    const VkDeviceAddress address = built_micromap->info->scratchData.deviceAddress;
    const uint32_t alignment =
        built_micromap->call->device->limits.minAccelerationStructureScratchOffsetAlignment;
    return !alignment || address % alignment == 0 ||
           violated(finding, SCRATCH,
                    "{} is not a multiple of minAccelerationStructureScratchOffsetAlignment ({})",
                    hex(address), number(alignment));
}

static bool scratch_leads_somewhere(const struct built_micromap_view *built,
                                    struct finding *finding)
{
    return !scratch_size(built) || !is_in_no_buffer(&built->scratch) ||
           violated(finding, SCRATCH, "{} is in no buffer, but buildScratchSize is {}",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, built->scratch.address),
                    number(scratch_size(built)));
}

static bool is_in_build_mode(const struct built_micromap_view *built)
{
    return built->info->mode == VK_BUILD_MICROMAP_MODE_BUILD_EXT;
}

bool built_micromap_scratch_is_valid(const struct built_micromap_view *built_micromap,
                                     struct finding *finding)
{
    return scratch_leads_somewhere(built_micromap, finding) ||
           (is_in_build_mode(built_micromap) &&
            also_violates(finding, RULE_built_micromap_scratch_is_in_one_buffer));
}

bool built_micromap_scratch_is_in_one_buffer(const struct built_micromap_view *built_micromap,
                                             struct finding *finding)
{
    const struct address_facts *scratch = &built_micromap->scratch;
    const VkDeviceSize needed = scratch_size(built_micromap);
    if (!is_in_build_mode(built_micromap))
        return true;
    if (!scratch_leads_somewhere(built_micromap, finding))
        return is_reported_with(finding, RULE_built_micromap_scratch_is_valid);
    return scratch->status != ADDRESS_IN_BUFFER || scratch->bytes_left >= needed ||
           violated(finding, SCRATCH,
                    "{} leaves {} to the end of {}, less than buildScratchSize "
                    "({})",
                    hex(scratch->address), count_of(scratch->bytes_left, "byte"),
                    buffer_at(scratch), number(needed));
}

bool built_micromap_scratch_has_storage_usage(const struct built_micromap_view *built_micromap,
                                              struct finding *finding)
{
    const struct address_facts *scratch = &built_micromap->scratch;
    return !scratch_size(built_micromap) || scratch->status != ADDRESS_IN_BUFFER ||
           (scratch->usage & VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT) ||
           violated(finding, SCRATCH,
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_STORAGE_BUFFER_BIT",
                    hex(scratch->address), buffer_at(scratch), buffer_usage(scratch->usage));
}

/* ---- data and triangles in device memory */

#define DATA "data.deviceAddress"
#define TRIANGLES "triangleArray.deviceAddress"
enum { INPUT_ALIGNMENT = 256 };

bool built_micromap_inputs_are_aligned(const struct built_micromap_view *built_micromap,
                                       struct finding *finding)
{
    const VkDeviceAddress data = built_micromap->info->data.deviceAddress,
                          triangles = built_micromap->info->triangleArray.deviceAddress;
    if (data % INPUT_ALIGNMENT && triangles % INPUT_ALIGNMENT)
        return violated(finding, DATA, "{} and " TRIANGLES " {} are not aligned to {}", hex(data),
                        hex(triangles), count_of(INPUT_ALIGNMENT, "byte"));
    return address_is_aligned(finding, DATA, data, INPUT_ALIGNMENT) &&
           address_is_aligned(finding, TRIANGLES, triangles, INPUT_ALIGNMENT);
}

static bool leads_to_a_buffer(const struct address_facts *facts, struct finding *finding,
                              const char *field)
{
    if (facts->status == ADDRESS_NULL)
        return violated_plainly(finding, field, "is 0");
    return facts->status != ADDRESS_NOWHERE ||
           violated(finding, field, "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, facts->address));
}

bool built_micromap_data_is_valid(const struct built_micromap_view *built_micromap,
                                  struct finding *finding)
{
    return leads_to_a_buffer(&built_micromap->data, finding, DATA);
}

bool built_micromap_triangles_are_valid(const struct built_micromap_view *built_micromap,
                                        struct finding *finding)
{
    return leads_to_a_buffer(&built_micromap->triangles, finding, TRIANGLES);
}

static bool has_input_usage(const struct address_facts *facts, struct finding *finding,
                            const char *field)
{
    return facts->status != ADDRESS_IN_BUFFER ||
           (facts->usage & VK_BUFFER_USAGE_2_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT) ||
           violated(finding, field,
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT",
                    hex(facts->address), buffer_at(facts), buffer_usage(facts->usage));
}

bool built_micromap_inputs_have_build_input_usage(const struct built_micromap_view *built_micromap,
                                                  struct finding *finding)
{
    return has_input_usage(&built_micromap->data, finding, DATA) &&
           has_input_usage(&built_micromap->triangles, finding, TRIANGLES);
}
