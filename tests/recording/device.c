/* SPDX-License-Identifier: Apache-2.0 */
/* The device, what its commands go on to, and lists as text. */
#include "layer/postmortem/postmortem.h"

#include "tests/recording/device.h"

#include <stdio.h>

#include "layer/execution/hazards/host_writes.h"
#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"

struct layer_device device;
uint32_t forwarded;
static struct journal *host_journal;

/* ---- the rest of the layer */

struct layer_device *layer_find_device(const void *dispatchable)
{
    return &device;
}

struct layer_device *layer_find_recording_device(VkCommandBuffer command_buffer)
{
    return command_buffer ? &device : NULL;
}

struct layer_device *layer_find_build_device(VkCommandBuffer command_buffer)
{
    return layer_find_recording_device(command_buffer);
}

struct layer_device *layer_find_reporting_device(const void *dispatchable)
{
    return NULL;
}

bool layer_other_device_has(const struct layer_device *of, enum resource_kind kind, uint64_t object)
{
    return false;
}

const struct call_site *call_site_of_thread(void)
{
    return NULL;
}

struct command_buffer *layer_find_recording(const struct layer_device *of, VkCommandBuffer recorded)
{
    struct command_buffer *found = command_buffers_find(of->command_buffers, recorded);
    return found && found->journal ? found : NULL;
}

void nv_record_build(void *user, const struct nv_call_view *view) {}
void nv_record_input(void *user, uint32_t geometry, enum input_role role,
                     const struct buffer_facts *facts)
{
}

void host_work_set_journal(struct journal *journal)
{
    host_journal = journal;
}

struct host_work host_work_begin(struct layer_device *of)
{
    return (struct host_work){.device = of};
}

bool host_work_prepare(struct host_work *work, bool skip)
{
    return skip;
}

VkResult host_work_finish(struct host_work *work, VkDeferredOperationKHR operation, VkResult result)
{
    return result;
}

static VkResult nothing(void)
{
    forwarded++;
    return VK_SUCCESS;
}

/* Nothing is lost here. */
void postmortem_report_loss(struct layer_device *of) {}
void host_writes_look(struct host_writes *host_writes) {}
void host_writes_stop(struct host_writes *host_writes) {}
void host_writes_forget(struct host_writes *host_writes) {}

/* ---- the device */

static void have_addressed_buffer(unsigned n, VkDeviceSize offset)
{
    have_bound_buffer(device.resources, n, 0x1000, 0, 1, offset);
    resources_set_address(device.resources, buffer(n), BUFFERS + offset);
}

void device_open(void)
{
    device = (struct layer_device){.finds_hazards = true,
                                   .level = LEVEL_EXECUTION,
                                   .queue_family_count = 2,
                                   .hazard_objects = hazard_objects_create()};
    void **commands = (void **)&device.vk;
    for (size_t i = 0; i < sizeof(device.vk) / sizeof(*commands); i++)
        commands[i] = (void *)nothing;
    device.facts.extension.acceleration_structure = true;
    device.facts.extension.ray_tracing_nv = true;
    device.facts.limits.maxGeometryCount = device.facts.limits.maxPrimitiveCount =
        device.facts.limits.maxInstanceCount = 100;
    device.command_buffers = some_command_buffers();
    device.resources = no_resources();
    assert_int_equal(query_pools_create(&device.query_pools), VK_SUCCESS);
    have_memory(device.resources, 1);
    have_addressed_buffer(1, 0);
    have_addressed_buffer(2, 0x1000);
    have_buffer(device.resources, 3, 0x1000, 0);
    have_accel(device.resources, 1, 1, 0, 0x200);
    have_accel(device.resources, 2, 1, 0x200, 0x200);
    begin(device.command_buffers, 1);
}

static void forget_host_list(void)
{
    journal_release(host_journal);
    host_journal = NULL;
}

void device_close(void)
{
    command_buffers_destroy(device.command_buffers);
    resources_destroy(device.resources);
    query_pools_destroy(device.query_pools);
    hazard_objects_destroy(device.hazard_objects);
    forget_host_list();
}

/* ---- lists as text */

static char list_text[8192];
static size_t length;

__attribute__((format(printf, 1, 2))) static void print(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    length += (size_t)vsnprintf(list_text + length, sizeof(list_text) - length, format, arguments);
    va_end(arguments);
    assert_true(length < sizeof(list_text));
}

/* A letter for each member of a set, or "*" for all. */
static void print_set(uint32_t set, uint32_t all, const char *letters)
{
    if (set == all)
        print("*");
    for (int i = 0; set != all && letters[i]; i++)
        if (set & 1u << i)
            print("%c", letters[i]);
}

static void print_stages(stage_set stages)
{
    print_set(stages, ALL_SYNC_STAGES, "BACFMH");
}

static void print_kinds(kind_set kinds)
{
    print_set(kinds, (1u << ACCESS_KINDS) - 1, "abcdefghijklmnopqrs");
}

static void print_barrier(const struct hazard_entry *item)
{
    print("barrier ");
    if (item->count)
        print("%u ", item->count);
    print_stages(item->dependency.src);
    print(":");
    print_kinds(item->dependency.src_kinds);
    print(">");
    print_stages(item->dependency.dst);
    print(":");
    print_kinds(item->dependency.dst_kinds);
    if (item->is_global)
        print(" all");
    else if (item->bytes.memory)
        print(" %llx:%llx", (unsigned long long)item->bytes.begin,
              (unsigned long long)item->bytes.end);
    print(item->is_acquisition ? " acquire\n" : "\n");
}

/* The last digit of a handle is its number. */
static unsigned number_of(uint64_t object)
{
    return (unsigned)(object & 0xf);
}

static const char *type_name(VkObjectType type)
{
    return type == VK_OBJECT_TYPE_BUFFER                       ? "buffer"
           : type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR ? "accel"
           : type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV  ? "nv"
           : type == VK_OBJECT_TYPE_MICROMAP_EXT               ? "micromap"
                                                               : "memory";
}

static void print_access(const struct hazard_entry *item)
{
    static const char *const kinds[ACCESS_KINDS] = {
        "B<",         "B>",         "B<shader",   "B<indirect", "B<micromap", "A<",      "A>",
        "A<transfer", "A>transfer", "C<",         "C>",         "F>",         "marker>", "M<",
        "M>",         "M<shader",   "M<transfer", "M>transfer", "H<",         "H>",      "compute<",
        "rays<",      "compute>",   "rays>",      "draw>"};
    static const char *const roles[HAZARD_ROLES] = {
        "dst",       "dst",       "src",       "scratch",  "vertices", "indices",
        "transform", "boxes",     "instances", "pointers", "other",    "ranges",
        "micromap",  "reference", "memory",    "shader"};
    if (!item->bytes.memory) {
        print(" anywhere\n");
        return;
    }
    print(" %s %s %s%u %llx:%llx", kinds[item->access], roles[item->role],
          type_name(item->object_type), number_of(item->object),
          (unsigned long long)item->bytes.begin, (unsigned long long)item->bytes.end);
    if (item->kind == HAZARD_INDEXED)
        print(" of indices*%u+%u", item->count, item->origin);
    if (item->info || item->geometry)
        print(" %u.%u", item->info, item->geometry);
    print("\n");
}

static void print_item(const struct hazard_entry *item)
{
    switch (item->kind) {
    case HAZARD_COMMAND:
        print("%s", item->command);
        if (item->info)
            print("*%u+%u", item->info, item->geometry);
        print("%s%s\n", item->reads_references ? "!" : "", item->origin ? " labels" : "");
        break;
    case HAZARD_ACCESS:
    case HAZARD_INDEXED:
        print_access(item);
        break;
    case HAZARD_BARRIER:
        print_barrier(item);
        break;
    case HAZARD_SET_EVENT:
        print("set %u ", number_of(item->object));
        print_stages(item->dependency.src);
        print("\n");
        break;
    case HAZARD_WAIT_EVENT:
        print("wait %u*%u\n", number_of(item->object), item->count);
        break;
    }
}

void expect_journal(const struct journal *journal, const char *expected)
{
    length = 0;
    list_text[0] = '\0';
    if (journal) {
        struct journal_cursor cursor = journal_start(journal, JOURNAL_HAZARDS);
        for (const struct hazard_entry *item; (item = hazard_next(&cursor));)
            print_item(item);
    }
    assert_string_equal(list_text, expected);
}

void expect(const char *expected)
{
    struct command_buffer *command_buffer = command_buffers_find(device.command_buffers, handle(1));
    expect_journal(command_buffer->journal, expected);
    begin(device.command_buffers, 1);
}

void expect_host(const char *expected)
{
    expect_journal(host_journal, expected);
    forget_host_list();
}

/* ---- builds */

static bool found(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding)
{
    return true;
}

static void find_sizes(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR type,
                       struct size_facts *sizes)
{
    *sizes = (struct size_facts){true, 0x100, 0x40, 0x20};
}

static enum tristate is_supported(void *user, VkFormat format)
{
    return YES;
}

static bool of_another_device(void *user, enum resource_kind kind, uint64_t object)
{
    return false;
}

void build(const struct build_parameters_of_call *parameters)
{
    static const bool active[RULE_COUNT];
    static const struct check_hooks hooks = {.found = found,
                                             .find_sizes = find_sizes,
                                             .vertex_format_supported = is_supported,
                                             .radius_format_supported = is_supported,
                                             .of_another_device = of_another_device};
    struct readable_cache readable = {0};
    struct build_call call;
    struct check_context context = {.hooks = &hooks,
                                    .recorder = hazards_build_recorder(),
                                    .user = &call,
                                    .level = LEVEL_EXECUTION,
                                    .active = active,
                                    .readable = &readable,
                                    .resources = device.resources};
    build_call_start_recorded(&call, &device, COMMAND_DEVICE, handle(1));
    call.view.info_count = 1;
    call.view.infos = parameters->info;
    call.view.build_ranges = &parameters->ranges;
    check_builds(&context, &call.view);
    call.skip = parameters->skip;
    build_call_settle_journal(&call);
    if (!call.skip)
        build_call_count_builds(&call, 1);
}
