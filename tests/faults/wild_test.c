/* SPDX-License-Identifier: Apache-2.0 */
/* Every intercepted command with invalid pointers, one at a time, above a driver that reads nothing
 * of that call: the layer must not crash. The commands and their arguments come from the registry
 * (wild_calls.py). */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>

#include "tests/fixture/linked.h"
#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

/* ---- what wild_calls.h needs */

struct wild_command {
    const char *name;
    void *(*fill)(void); /* returns the arguments */
    void (*call)(PFN_vkVoidFunction function, void *arguments);
    PFN_vkVoidFunction inert; /* the driver's command, which reads nothing if it is `current` */
};

enum { ARENA = 1 << 17, POINTERS_MAX = 512, PATH_MAX_LENGTH = 160, PAGE = 4096 };

static _Alignas(16) unsigned char arena[ARENA];
static size_t arena_used;
static struct {
    const void **place;
    const char *path;
} pointers[POINTERS_MAX];
static uint32_t pointer_count;

static struct platform platform;
static struct program program;
static struct play play;
static VkAccelerationStructureNV nv;
static const struct wild_command *current;

static void *wild_take(size_t size)
{
    void *taken = arena + arena_used;
    arena_used += (size + 15) / 16 * 16;
    assert_true(arena_used <= ARENA);
    memset(taken, 0, size);
    return taken;
}

static void wild_note(const void **place, const char *path)
{
    assert_true(pointer_count < POINTERS_MAX);
    pointers[pointer_count].place = place;
    pointers[pointer_count++].path = path;
}

static uint64_t wild_handle(VkObjectType type)
{
    const struct {
        VkObjectType type;
        uint64_t handle;
    } handles[] = {
        {VK_OBJECT_TYPE_INSTANCE, (uintptr_t)play.fixture.instance},
        {VK_OBJECT_TYPE_PHYSICAL_DEVICE, (uintptr_t)play.fixture.physical},
        {VK_OBJECT_TYPE_DEVICE, (uintptr_t)play.device},
        {VK_OBJECT_TYPE_QUEUE, (uintptr_t)play.queues[0]},
        {VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)play_object(&play, "V0")->buffer.memory},
        {VK_OBJECT_TYPE_BUFFER, (uint64_t)play_object(&play, "V0")->buffer.handle},
        {VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)play_object(&play, "B0")->structure},
        {VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, (uint64_t)nv},
        {VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)play_object(&play, "M0")->micromap},
        {VK_OBJECT_TYPE_COMMAND_POOL, (uint64_t)play_object(&play, "c0")->pool},
        {VK_OBJECT_TYPE_COMMAND_BUFFER, (uintptr_t)play_object(&play, "c0")->commands},
        {VK_OBJECT_TYPE_FENCE, (uint64_t)play.fence},
        {VK_OBJECT_TYPE_SEMAPHORE, (uint64_t)play_object(&play, "s0")->semaphore},
        {VK_OBJECT_TYPE_EVENT, (uint64_t)play_object(&play, "E0")->event},
        {VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)play_object(&play, "P0")->queries},
        {VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR, (uint64_t)play_object(&play, "d0")->operation},
    };
    for (size_t i = 0; i < ARRAY_COUNT(handles); i++)
        if (type == handles[i].type)
            return handles[i].handle;
    return 0x1000;
}

/* The loader's structures, before a chain. */
static const void *wild_link_instance(const void *chain)
{
    VkLayerInstanceLink *below = wild_take(sizeof(*below));
    VkLayerInstanceCreateInfo *link = wild_take(sizeof(*link));
    below->pfnNextGetInstanceProcAddr = linked_driver_proc_addr;
    link->sType = VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO;
    link->pNext = chain;
    link->function = VK_LAYER_LINK_INFO;
    link->u.pLayerInfo = below;
    return link;
}

static const void *wild_link_device(const void *chain)
{
    VkLayerDeviceLink *below = wild_take(sizeof(*below));
    VkLayerDeviceCreateInfo *link = wild_take(sizeof(*link));
    below->pfnNextGetInstanceProcAddr = linked_driver_proc_addr;
    below->pfnNextGetDeviceProcAddr = linked_driver_device_proc_addr;
    link->sType = VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO;
    link->pNext = chain;
    link->function = VK_LAYER_LINK_INFO;
    link->u.pLayerInfo = below;
    return link;
}

/* The driver's own command. Returns NULL for the call with an invalid pointer, and if the driver
 * has none. */
static PFN_vkVoidFunction wild_driver_command(const struct wild_command *command);

#include "wild_calls.h"

/* ---- the driver below the layer */

static PFN_vkVoidFunction driver_commands[WILD_COMMANDS];

static PFN_vkVoidFunction wild_driver_command(const struct wild_command *command)
{
    return command == current ? NULL : driver_commands[command - wild_commands];
}

/* The driver seems to have all commands, so that the layer has them. */
static PFN_vkVoidFunction cover_named(const char *name, PFN_vkVoidFunction own)
{
    for (int i = 0; i < WILD_COMMANDS; i++)
        if (strcmp(wild_commands[i].name, name) == 0) {
            driver_commands[i] = own ? own : driver_commands[i];
            return wild_commands[i].inert;
        }
    return own;
}

/* An extension's command that has become part of Vulkan is the core command. */
static PFN_vkVoidFunction cover(VkDevice device, const char *name, PFN_vkVoidFunction own)
{
    const size_t length = strlen(name);
    for (int i = 0; i < WILD_COMMANDS && device && !own; i++)
        if (strlen(wild_commands[i].name) + strlen("KHR") == length &&
            strncmp(wild_commands[i].name, name, length - strlen("KHR")) == 0)
            own = linked_driver_own(device, wild_commands[i].name);
    return cover_named(name, own);
}

/* ---- the application */

VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *pVersionStruct);

static VkNegotiateLayerInterface layer = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                          .loaderLayerInterfaceVersion = 2};

struct run {
    const char *level;
    bool is_cpu, has_settings; /* hazards and guard */
};

/* How far a child has come. */
struct progress {
    uint32_t command, pointer, value;
    uint32_t calls;
    char path[PATH_MAX_LENGTH];
};
static struct progress *progress;

static unsigned char *edge; /* the last bytes that can be read before others that cannot */

enum { VALUES = 3, NOT_FOUND = 3 };
static const void *value_at(uint32_t i)
{
    const void *const values[VALUES] = {NULL, edge + 8, edge};
    return values[i];
}

static PFN_vkVoidFunction find(const char *name)
{
    const PFN_vkVoidFunction found = layer.pfnGetDeviceProcAddr(play.device, name);
    return found ? found : layer.pfnGetInstanceProcAddr(play.fixture.instance, name);
}

/* The command buffer records, whatever was done to it before. */
static void begin_commands(void)
{
    const STRUCT(VkCommandBufferBeginInfo, begin);
    const VkCommandBuffer commands =
        (VkCommandBuffer)(uintptr_t)wild_handle(VK_OBJECT_TYPE_COMMAND_BUFFER);
    play.vk.BeginCommandBuffer(commands, &begin);
}

/* Returns false if the command has no such pointer. */
static bool call_with(const struct wild_command *command, uint32_t pointer, uint32_t value)
{
    arena_used = pointer_count = 0;
    begin_commands();
    void *arguments = command->fill();
    if (pointer >= pointer_count)
        return false;
    snprintf(progress->path, sizeof(progress->path), "%s", pointers[pointer].path);
    *pointers[pointer].place = value_at(value);
    const PFN_vkVoidFunction function = find(command->name);
    if (!function)
        _exit(NOT_FOUND);
    current = command;
    command->call(function, arguments);
    current = NULL;
    progress->calls++;
    return true;
}

static void open_layer(const struct run *run)
{
    static const char *const lines[] = {"driver joins 1",
                                        "with VK_NV_ray_tracing",
                                        "with VK_NV_ray_tracing_motion_blur",
                                        "with VK_NV_ray_tracing_linear_swept_spheres",
                                        "with VK_KHR_opacity_micromap",
                                        "with VK_KHR_maintenance5",
                                        "with VK_AMDX_dense_geometry_format"};
    char level[32];
    snprintf(level, sizeof(level), "setting level %s", run->level);
    program.line_count = 0;
    program.used = 0;
    program_add(&program, level, 1);
    program_add(&program, run->has_settings ? "setting hazards true" : "setting hazards false", 1);
    program_add(&program, run->has_settings ? "setting guard references" : "setting guard off", 1);
    for (size_t i = 0; i < ARRAY_COUNT(lines); i++)
        program_add(&program, lines[i], 1);
    linked_cover = cover;
    linked_open(&platform, run->is_cpu);
    play.platform = &platform;
    assert_true(play_begin(&play, &program));
    play.is_nv = true;
    nv = play_object(&play, "B1")->nv;
    play.is_nv = false;
    wild_handle(VK_OBJECT_TYPE_UNKNOWN); /* creates all objects */
    play_text(&play, &program, "begin c0");
    vkNegotiateLoaderLayerInterfaceVersion(&layer);
}

/* Goes on behind the call that `progress` is about. */
static void run_all(const struct run *run)
{
    open_layer(run);
    for (; progress->command < WILD_COMMANDS; progress->command++, progress->pointer = 0)
        for (;; progress->pointer++, progress->value = 0) {
            bool has_pointer = true;
            for (; has_pointer && progress->value < VALUES; progress->value++)
                has_pointer = call_with(&wild_commands[progress->command], progress->pointer,
                                        progress->value);
            if (!has_pointer)
                break;
        }
    _exit(0);
}

/* Returns whether all calls returned; if not, `progress` is about the one that did not. */
static bool run_child(const struct run *run)
{
    int status = 0;
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        signal(SIGSEGV, SIG_DFL); /* cmocka handles it */
        alarm(120);
        run_all(run);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return true;
    print_error("level %s, backend %s%s: %s, %s, value %u: status %d\n", run->level,
                run->is_cpu ? "cpu" : "driver", run->has_settings ? ", hazards and guard" : "",
                wild_commands[progress->command].name, progress->path, progress->value, status);
    return false;
}

static uint32_t crashes_in(const struct run *run)
{
    uint32_t crashes = 0;
    *progress = (struct progress){0};
    while (crashes < 1000 && !run_child(run)) {
        crashes++;
        progress->value++;
    }
    print_message("level %s, backend %s%s: %u calls\n", run->level, run->is_cpu ? "cpu" : "driver",
                  run->has_settings ? ", hazards and guard" : "", progress->calls);
    return crashes;
}

static void map(void)
{
    progress =
        mmap(NULL, sizeof(*progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    unsigned char *pages =
        mmap(NULL, 2 * PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(progress != MAP_FAILED && pages != MAP_FAILED);
    memset(pages, 'x', PAGE);
    assert_int_equal(mprotect(pages + PAGE, PAGE, PROT_NONE), 0);
    edge = pages + PAGE - 8;
}

static bool is_listed(const char *name)
{
    bool is_found = false;
    for (int i = 0; i < WILD_COMMANDS; i++)
        is_found |= strcmp(wild_commands[i].name, name) == 0;
    return is_found;
}

/* What the layer returns for other commands is the driver's own function. What it returns for an
 * instance has to serve each device. */
TEST(every_intercepted_command_is_listed)
{
    open_layer(&(struct run){"content", true, true});
    for (size_t i = 0; i < sizeof(wild_names) / sizeof(wild_names[0]); i++) {
        const PFN_vkVoidFunction found = layer.pfnGetDeviceProcAddr(play.device, wild_names[i]);
        if (!is_listed(wild_names[i]) && found != linked_driver_own(play.device, wild_names[i]))
            fail_msg("%s is intercepted and not listed", wild_names[i]);
        if (found != linked_driver_device_proc_addr(play.device, wild_names[i]) &&
            found != layer.pfnGetInstanceProcAddr(play.fixture.instance, wild_names[i]))
            fail_msg("%s is not what an instance returns", wild_names[i]);
    }
    play_end(&play);
    play_close(&play);
}

TEST(the_layer_survives_invalid_pointers)
{
    static const char *const levels[] = {"parameters", "state", "execution", "content"};
    uint32_t crashes = 0;
    map();
    for (int i = 0; i < 16; i++) {
        const struct run run = {levels[i / 4], i & 1, i & 2};
        crashes += crashes_in(&run);
    }
    assert_int_equal(crashes, 0);
}

bool unit_test_keeps_memory(void)
{
    return true;
}
