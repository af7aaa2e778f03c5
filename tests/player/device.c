/* SPDX-License-Identifier: Apache-2.0 */
/* The instance and the device of a program, as lines ask for them, wherever they stand:
 *
 *     setting NAME VALUE         of the layer; log_filename: a file of the process, unless VALUE
 *                                begins with a slash
 *     with EXTENSION             and its features; VK_NV_displacement_micromap: all micromaps
 *                                have displacements
 *     with group                 the device has all physical devices of its group, at least two
 *     without FEATURE            see device_wish_set()
 *     only null                  for programs that need the null driver
 *     only shaders               for programs that need a driver which executes shaders
 *     only driver                for programs that backend cpu plays otherwise
 *     only cpu                   for programs that need backend cpu
 *     only lavapipe              for programs about what a driver writes
 *     driver recycles [handles]  the null driver gives out handles and addresses again, or only
 *                                handles
 *     driver joins COUNT         its deferred operations complete at this join; 0: they aren't
 *                                deferred
 *     driver type cpu | discrete                  of its physical devices
 *     driver gaps                around mapped memory nothing can be read
 *
 *     alone                      a batch never executes: no other program has the device, and what
 *                                the last wait brings is not judged
 *     closes                     the program ends with `close`, unless it has that line itself
 *     unjudged                   the program does what no application may do: only a crash is a
 *                                failure, and lines that cannot be played are left out
 *
 * Programs that ask for the same share them. */
#include "tests/fixture/device_wish.h"
#include "tests/player/play.h"
#include "vuid-tables/registry.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Whether it is a line of this file. */
bool play_is_setup(const struct program_line *line)
{
    static const char *const words[] = {"setting", "with",  "without",  "only",  "driver",
                                        "about",   "alone", "unjudged", "closes"};
    bool found = false;
    for (size_t i = 0; i < ARRAY_COUNT(words); i++)
        found |= play_is(line->words[0], words[i]);
    return found;
}

/* ---- the instance */

enum { SETTINGS_MAX = 12 };

static void set_recycling(struct null_driver_config *config, bool has_addresses)
{
    config->recycle_handles = true;
    config->recycle_addresses = has_addresses;
}

static void configure_driver(const struct play *play)
{
    struct null_driver_config config = play->platform->null_driver.default_config();
    for (unsigned i = 0; i < play->program->line_count; i++) {
        char *const *words = play->program->lines[i].words;
        if (!play_is(words[0], "driver"))
            continue;
        if (play_is(words[1], "type"))
            config.properties.deviceType = play_is(words[2], "cpu")
                                               ? VK_PHYSICAL_DEVICE_TYPE_CPU
                                               : VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
        else if (play_is(words[1], "joins"))
            config.deferred_joins = (uint32_t)atoi(words[2]);
        else if (play_is(words[1], "recycles"))
            set_recycling(&config, !play_is(words[2], "handles"));
        else if (play_is(words[1], "gaps"))
            config.has_gaps = true;
        else
            program_fail(play->program->name, play->program->lines[i].number, "driver what?");
    }
    play->platform->null_driver.configure(&config);
}

static void open_khronos(struct play *play)
{
    static const VkBool32 yes = VK_TRUE, no = VK_FALSE;
    const char *name = "VK_LAYER_KHRONOS_validation";
    const VkLayerSettingEXT settings[] = {
        {name, "validate_sync", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &yes},
        {name, "syncval_full_validation", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &yes},
        {name, "enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &no},
    };
    const STRUCT(VkLayerSettingsCreateInfoEXT, chain, .settingCount = ARRAY_COUNT(settings),
                 .pSettings = settings);
    instance_fixture_create(&play->fixture, play->platform,
                            &(struct instance_settings){.layer = name, .chain = &chain});
}

/* The last line about a setting counts. */
static void add_setting(VkLayerSettingsCreateInfoEXT *chain, VkLayerSettingEXT *settings,
                        const char *name, const void *value)
{
    uint32_t i = 0;
    while (i < chain->settingCount && strcmp(settings[i].pSettingName, name) != 0)
        i++;
    settings[i] = (VkLayerSettingEXT){LAYER_NAME, name, VK_LAYER_SETTING_TYPE_STRING_EXT, 1, value};
    if (i == chain->settingCount && i < SETTINGS_MAX - 1)
        chain->settingCount++;
}

/* Each play has a file of its own. */
static void name_log(struct play *play)
{
    snprintf(play->log_name, sizeof(play->log_name), "/tmp/assay-records-%ld-%p", (long)getpid(),
             (void *)play);
    play->log_offset = 0;
}

static void open_instance(struct play *play)
{
    const char *log_name = play->log_name;
    const char *no_hazards =
        "false"; /* programs are about one thing each, and need no barriers for it */
    VkLayerSettingEXT settings[SETTINGS_MAX];
    STRUCT(VkLayerSettingsCreateInfoEXT, chain, .pSettings = settings);
    if (play->platform->is_null)
        configure_driver(play);
    if (!program_find(play->program, "setting", "preset"))
        add_setting(&chain, settings, "hazards", &no_hazards);
    if (play->level)
        add_setting(&chain, settings, "level", &play->level);
    for (unsigned i = 0; i < play->program->line_count; i++) {
        char *const *words = play->program->lines[i].words;
        if (!play_is(words[0], "setting"))
            continue;
        const bool is_log = play_is(words[1], "log_filename") && words[2] && words[2][0] != '/';
        if (is_log)
            name_log(play);
        add_setting(&chain, settings, words[1], is_log ? (const void *)&log_name : &words[2]);
    }
    if (play->is_khronos)
        open_khronos(play);
    else
        instance_fixture_create(&play->fixture, play->platform,
                                &(struct instance_settings){.chain = &chain});
    play->memory_type = instance_fixture_memory_type(&play->fixture);
}

/* What the program's last line about a setting says, or NULL. */
static const char *setting_of(const struct program *program, const char *name)
{
    const char *value = NULL;
    for (unsigned i = 0; i < program->line_count; i++) {
        char *const *words = program->lines[i].words;
        if (play_is(words[0], "setting") && play_is(words[1], name))
            value = words[2];
    }
    return value;
}

bool play_sees_executions(const struct play *play)
{
    const char *level = setting_of(play->program, "level");
    if (!level)
        level = play->level;
    return !level || level_named(level) >= LEVEL_EXECUTION;
}

/* ---- the device */

/* Whether the device of the program has an extension: those that every program has, and those that
 * it names. */
bool play_has(const struct play *play, const char *extension)
{
    static const char *const always[] = {"VK_KHR_ray_tracing_maintenance1",
                                         "VK_EXT_opacity_micromap", "VK_AMD_buffer_marker"};
    bool is_wanted = program_find(play->program, "with", extension);
    for (size_t i = 0; i < ARRAY_COUNT(always); i++)
        is_wanted |= strcmp(always[i], extension) == 0;
    return is_wanted && instance_fixture_count_extension(&play->fixture, extension) > 0;
}

/* Enables all features that the device has, and the program does not disable. */
static void find_features(struct play *play, struct device_wish *wish)
{
    const struct program *program = play->program;
    const struct instance_fixture *fixture = &play->fixture;
    device_wish_begin(wish);
    for (size_t i = 0; i < registry_extension_count; i++)
        if (play_has(play, registry_extensions[i]))
            device_wish_add(wish, registry_extensions[i]);
    /* Its micromaps are created by address. Backend cpu has the feature without the extension. */
    if (play_has(play, "VK_KHR_opacity_micromap")) {
        if (instance_fixture_count_extension(fixture, "VK_KHR_device_address_commands") > 0)
            device_wish_add(wish, "VK_KHR_device_address_commands");
        device_wish_features(wish, VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR_sType);
    }
    device_wish_features(wish, VkPhysicalDeviceVulkan12Features_sType);
    device_wish_features(wish, VkPhysicalDeviceVulkan13Features_sType);
    fixture->vk.GetPhysicalDeviceFeatures2(fixture->physical, &wish->features);
    device_wish_set(wish, "robustBufferAccess", VK_FALSE);
    device_wish_set(wish, "accelerationStructureCaptureReplay", VK_FALSE);
    for (unsigned i = 0; i < program->line_count; i++)
        if (play_is(program->lines[i].words[0], "without") &&
            !device_wish_set(wish, program->lines[i].words[1], VK_FALSE))
            program_fail(program->name, program->lines[i].number, "without what?");
    play->has_indirect = device_wish_has(wish, "accelerationStructureIndirectBuild");
    play->has_host = device_wish_has(wish, "accelerationStructureHostCommands");
}

/* Chooses the queues: two of family 0, one of family 1, as far as there are. */
static uint32_t choose_queues(struct play *play, VkDeviceQueueCreateInfo infos[2])
{
    static const float priorities[] = {1, 1};
    VkQueueFamilyProperties families[8];
    uint32_t count = ARRAY_COUNT(families);
    play->fixture.vk.GetPhysicalDeviceQueueFamilyProperties(play->fixture.physical, &count,
                                                            families);
    play->has_sparse = families[0].queueFlags & VK_QUEUE_SPARSE_BINDING_BIT;
    infos[0] = MAKE(VkDeviceQueueCreateInfo, .queueCount = families[0].queueCount > 1 ? 2 : 1,
                    .pQueuePriorities = priorities);
    infos[1] = MAKE(VkDeviceQueueCreateInfo, .queueFamilyIndex = 1, .queueCount = 1,
                    .pQueuePriorities = priorities);
    return count > 1 && families[1].queueFlags & VK_QUEUE_COMPUTE_BIT ? 2 : 1;
}

static void create_scratch(struct play *play)
{
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    const STRUCT(VkBufferCreateInfo, scratch, .size = play->is_unjudged ? 1 << 19 : 1 << 22,
                 .usage = usage);
    const STRUCT(VkBufferCreateInfo, instances, .size = PLAY_BUFFER_SIZE, .usage = usage);
    /* Not cleared: most programs use little of it. */
    play->scratch = buffer_create_uncleared(&play->vk, play->device, play->memory_type, &scratch);
    play->instances = buffer_create(&play->vk, play->device, play->memory_type, &instances);
}

/* Puts the group of the physical device before a chain if the program asks for it: behind another
 * structure the loader replaces it, and does not put it back if the device is not created. */
static void *chain_group(struct play *play, VkPhysicalDeviceGroupProperties *group,
                         VkDeviceGroupDeviceCreateInfo *info, void *chain)
{
    uint32_t count = 1;
    *group = MAKE(VkPhysicalDeviceGroupProperties);
    play->fixture.vk.EnumeratePhysicalDeviceGroups(play->fixture.instance, &count, group);
    play->has_group = count && group->physicalDeviceCount > 1 &&
                      group->physicalDevices[0] == play->fixture.physical;
    *info = MAKE(VkDeviceGroupDeviceCreateInfo, .pNext = chain,
                 .physicalDeviceCount = group->physicalDeviceCount,
                 .pPhysicalDevices = group->physicalDevices);
    return play->has_group && program_find(play->program, "with", "group") ? info : chain;
}

static void create_device(struct play *play)
{
    const struct instance_fixture *fixture = &play->fixture;
    struct device_wish wish;
    VkDeviceQueueCreateInfo queues[2];
    VkPhysicalDeviceGroupProperties group;
    VkDeviceGroupDeviceCreateInfo of_group;
    find_features(play, &wish);
    const STRUCT(
        VkDeviceCreateInfo, info, .pNext = chain_group(play, &group, &of_group, &wish.features),
        .queueCreateInfoCount = choose_queues(play, queues), .pQueueCreateInfos = queues,
        .enabledExtensionCount = wish.extension_count, .ppEnabledExtensionNames = wish.extensions);
    GET(fixture->vk.CreateDevice(fixture->physical, &info, NULL, &play->device));
    vkuInitDeviceDispatchTable(play->device, &play->vk, fixture->get_device_proc_addr);
    memset(play->queues, 0, sizeof(play->queues));
    for (uint32_t i = 0; i < info.queueCreateInfoCount; i++)
        for (uint32_t j = 0; j < queues[i].queueCount; j++)
            play->vk.GetDeviceQueue(play->device, i, j, &play->queues[2 * i + j]);
    create_scratch(play);
}

void play_close_device(struct play *play)
{
    if (play->device_key[0]) {
        buffer_destroy(&play->vk, play->device, &play->scratch);
        buffer_destroy(&play->vk, play->device, &play->instances);
        play->vk.DestroyDevice(play->device, NULL);
    }
    play->device_key[0] = '\0';
}

void play_close_instance(struct play *play)
{
    play_close_device(play);
    if (play->instance_key[0])
        instance_fixture_close(&play->fixture);
    play->instance_key[0] = '\0';
}

void play_close(struct play *play)
{
    play_close_instance(play);
    if (play->log_name[0])
        unlink(play->log_name);
    play->log_name[0] = '\0';
}

/* ---- what the program needs */

/* `length`: of the part that is compared. */
static bool has_part(const struct program *program, const char *word, size_t length)
{
    for (unsigned i = 0; i < program->line_count; i++)
        for (char *const *at = program->lines[i].words; *at; at++)
            if (strncmp(*at, word, length) == 0)
                return true;
    return false;
}

/* A word that begins so: stages and accesses stand in one word. */
static bool has_beginning(const struct program *program, const char *beginning)
{
    return has_part(program, beginning, strlen(beginning));
}

static bool has_word(const struct program *program, const char *word)
{
    return has_part(program, word, strlen(word) + 1);
}

/* Whether the host builds, copies or queries structures. */
static bool has_host_work(const struct program *program)
{
    static const char *const works[] = {"build", "top",       "clone",       "compact",
                                        "query", "serialize", "deserialize", "join"};
    for (unsigned i = 0; i < program->line_count; i++)
        for (char *const *word = program->lines[i].words; *word; word++)
            for (size_t j = 0; j < ARRAY_COUNT(works) && play_is(word[0], "host"); j++)
                if (play_is(word[1], works[j]))
                    return true;
    return false;
}

/* Whether it has commands without a counterpart. */
static bool lacks_nv(const struct program *program)
{
    static const char *const words[] = {"deserialize", "generic", "last-size", "fitting",
                                        "sparse",      "buffer",  "renew",     "host"};
    for (unsigned i = 0; i < program->line_count; i++)
        for (char *const *word = program->lines[i].words; *word; word++)
            for (size_t j = 0; j < ARRAY_COUNT(words); j++)
                if (play_is(*word, words[j]) &&
                    !(play_is(*word, "host") &&
                      (play_is(word[1], "wait") || play_is(word[1], "poll") ||
                       play_is(word[1], "signal") || play_is(word[1], "set") ||
                       play_is(word[1], "reset"))))
                    return true;
    return false;
}

static const char *missing_platform(const struct play *play)
{
    const struct program *program = play->program;
    const bool needs_null = program_find(program, "only", "null") ||
                            program_find(program, "driver", NULL) || has_word(program, "fail") ||
                            has_word(program, "lose") || has_word(program, "count") ||
                            has_word(program, "fault") || has_word(program, "below") ||
                            has_beginning(program, "timestamp");
    if (needs_null && !play->platform->is_null)
        return "the null driver";
    if (play->platform->is_null && program_find(program, "only", "shaders"))
        return "shaders that execute";
    /* Settings of the environment come before those of programs. */
    if (getenv("VK_ASSAY_VALIDATION_LIMITS") && play_is(setting_of(program, "limits"), "driver"))
        return "limits of the driver";
    if (play->platform->is_guarded && play_is(setting_of(program, "guard"), "off"))
        return "builds without a guard";
    if (program_find(program, "only", "lavapipe") && strcmp(play->platform->name, "lavapipe") != 0)
        return "lavapipe";
    if (has_beginning(program, "allocation") && !play->platform->fail_allocations)
        return "allocations that fail";
    if (play->platform->is_cpu && program_find(program, "only", "driver"))
        return "builds by the driver";
    if (!play->platform->is_cpu && program_find(program, "only", "cpu"))
        return "backend cpu";
    if (getenv("VK_ASSAY_VALIDATION_CAPTURE") && program_find(program, "costs", "bytes"))
        return "copies that no capture needs";
    if (program_find(program, "setting", "log_filename") &&
        getenv("VK_ASSAY_VALIDATION_LOG_FILENAME"))
        return "a log file of its own";
    return NULL;
}

const char *play_unknown_extension(const struct program *program)
{
    for (unsigned i = 0; i < program->line_count; i++) {
        char *const *words = program->lines[i].words;
        if (play_is(words[0], "with") && !play_is(words[1], "group") &&
            !(words[1] && registry_knows_extension(words[1])))
            return words[1] ? words[1] : "nothing";
    }
    return NULL;
}

/* Whether it is about a command of VK_NV_ray_tracing which builds nothing. */
static bool is_about_nv(const struct program *program)
{
    enum vuid vuid;
    enum build_command command;
    if (!program_subject(program, &vuid, &command) || vuid == VUID_NONE || command == COMMAND_NV)
        return false;
    const char *name = build_command_name(command);
    return strcmp(name + strlen(name) - 2, "NV") == 0;
}

/* Returns what the program needs and the device lacks. */
static const char *missing(const struct play *play)
{
    const struct program *program = play->program;
    const struct {
        const char *word, *what;
        bool is_there;
    } needs[] = {
        {"q1", "a second queue", play->queues[1]},
        {"q2", "a second queue family", play->queues[2]},
        {"indirect", "indirect builds", play->has_indirect},
        {"ranges", "indirect builds", play->has_indirect},
        {"micromap", "micromaps", play_has(play, "VK_EXT_opacity_micromap")},
        {"marker", "VK_AMD_buffer_marker", play_has(play, "VK_AMD_buffer_marker")},
        {"accel_copy", "VK_KHR_ray_tracing_maintenance1",
         play_has(play, "VK_KHR_ray_tracing_maintenance1")},
        {"sparse", "sparse buffers", play->has_sparse},
        {"group", "a device group", play->has_group},
        {"records", "level execution", play_sees_executions(play)},
        {"when", "level execution", play_sees_executions(play)},
    };
    for (unsigned i = 0; i < program->line_count; i++) {
        char *const *words = program->lines[i].words;
        if (play_is(words[0], "with") && !play_is(words[1], "group") && !play_has(play, words[1]))
            return words[1];
    }
    for (size_t i = 0; i < ARRAY_COUNT(needs); i++)
        if (!needs[i].is_there && has_beginning(program, needs[i].word))
            return needs[i].what;
    /* Backend cpu has one kind of structures, which the commands of KHR take, too. */
    if (!play->is_unjudged && !program_find(program, "only", "cpu") &&
        program_find(program, "structures", "nv") && !program_find(program, "structures", "khr") &&
        lacks_nv(program) && !is_about_nv(program))
        return "a command that VK_NV_ray_tracing lacks";
    return has_host_work(program) && !play->has_host ? "builds on the host" : NULL;
}

/* The lines that begin with one of these words. */
static void make_key(const struct program *program, const char *first, const char *second,
                     char key[512])
{
    size_t length = (size_t)snprintf(key, 512, ";");
    for (unsigned i = 0; i < program->line_count && length < 512; i++)
        if (play_is(program->lines[i].words[0], first) ||
            play_is(program->lines[i].words[0], second))
            length += (size_t)snprintf(key + length, 512 - length, "%s;", program->lines[i].text);
}

bool play_suits(const struct play *play, const struct program *program)
{
    char key[512];
    make_key(program, "setting", "driver", key);
    return strcmp(key, play->instance_key) == 0;
}

const char *play_open_device(struct play *play)
{
    char key[512];
    const char *what = missing_platform(play);
    if (what)
        return what;
    make_key(play->program, "setting", "driver", key);
    if (strcmp(key, play->instance_key) != 0) {
        play_close(play);
        open_instance(play);
        memcpy(play->instance_key, key, sizeof(key));
    }
    make_key(play->program, "with", "without", key);
    if (strcmp(key, play->device_key) != 0) {
        play_close_device(play);
        create_device(play);
        memcpy(play->device_key, key, sizeof(key));
    }
    return missing(play);
}
