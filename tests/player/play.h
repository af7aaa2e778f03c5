/* SPDX-License-Identifier: Apache-2.0 */
/* Plays programs: creates a device and the objects that the program names, executes its lines, and
 * judges each by what the layer reports meanwhile.
 *
 * An object exists from its first use on. The first letter of its name says what it is:
 * B and T bottom- and top-level structures, M micromaps, E events, F images (FC: of blocks of 4 * 4
 * texels), P query pools (PM, PC, PN, PO: see play_create_queries()),
 * c command buffers, d deferred operations, s binary semaphores, t timelines, q queues, all other
 * capital letters buffers, which the host has mapped but for U; D has serialized data of the null
 * driver, no command writes H, and W is large. NAME+OFFSET is a place in a buffer, and where a
 * command takes an address, @NUMBER is one. Each object has memory of its own, unless the program
 * says otherwise. */
#ifndef ASSAY_TESTS_PLAYER_PLAY_H
#define ASSAY_TESTS_PLAYER_PLAY_H

#include <setjmp.h>

#include "layer/assay.h"
#include "tests/fixture/batches.h"
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/player/program.h"
#include "tests/player/tally.h"

enum {
    PLAY_OBJECTS = 128,
    PLAY_QUEUES = 3,          /* two of family 0, one of family 1 */
    PLAY_ITEMS = BATCH_ITEMS, /* of anything that a line or a submission lists */
    PLAY_BUFFER_SIZE = 128 * 1024,
    PLAY_LARGE_SIZE = 2 * 1024 * 1024,
    PLAY_NAMELESS = 1500,
    PLAY_PAGES = 4, /* of sparse buffers; each takes a structure */
    PLAY_PAGE_SIZE = 64 * 1024,
    PLAY_STRUCTURE_SIZE = 32 * 1024, /* serialized, it fits into a buffer */
};

struct play_object {
    char name[8];
    struct device_buffer buffer; /* of structures and micromaps, too; memory is null if another
                                    object owns it */
    union {
        VkAccelerationStructureKHR structure;
        VkMicromapEXT micromap;
        VkSemaphore semaphore;
        VkEvent event;
        VkQueryPool queries;
        VkImage image;
        VkDeferredOperationKHR operation;
        VkCommandBuffer commands;
        VkAccelerationStructureNV nv;
    };
    VkCommandPool pool; /* of a command buffer alone */
    unsigned queue;     /* that a command buffer is for */
    bool is_secondary;
    bool is_nv;    /* a structure of VK_NV_ray_tracing; its buffer has the size that it needs */
    bool is_ghost; /* the handle is that of an object that is destroyed, or was never there */
    bool is_freed; /* the memory is, so that the host must not write there */
};

/* A copy of an array that a call gets. */
struct play_block {
    struct play_block *next;
    _Alignas(16) unsigned char bytes[];
};

/* Pipelines of programs, which they create at the first use. */
enum {
    PLAY_SHADE,
    PLAY_SHADE_SET,
    PLAY_TRACE,
    PLAY_TRACE_SET,
    PLAY_TRACE_IF,
    PLAY_TRACE_DISABLED,
    PLAY_TRACE_PUSHED,
    PLAY_RAYS,
    PLAY_SHADERS
};
struct play_shader {
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkDescriptorSetLayout set; /* of those that access what a set holds */
    VkDescriptorPool pool;
    VkDescriptorSet last_set;
};

struct play {
    const struct platform *platform;
    bool is_khronos;   /* the Khronos layer instead of Assay */
    const char *level; /* that programs without a level of their own are played at, or NULL */
    bool is_scarce;    /* memory runs out: the layer may report less, but nothing else */
    bool may_warn;     /* the layer may report what it leaves unchecked */
    bool repeats;      /* calls that fail for lack of memory, once */
    jmp_buf gives_up;  /* where play_give_up_if_scarce() goes on */
    bool is_unjudged;  /* only a crash is a failure, and lines that cannot be played are left out */
    jmp_buf next_line; /* where such a program goes on */
    VkBool32 answer;   /* of its messenger */
    struct play_block *blocks;
    bool keeps_blocks; /* until the program ends, for a deferred operation */
    struct instance_fixture fixture;
    char instance_key[512], device_key[512]; /* what they were created for; "": there is none */
    const struct program *program;
    unsigned at;       /* index of the line that is executed */
    VkResult result;   /* the first of the line's calls that isn't VK_SUCCESS */
    char log_name[64]; /* of setting log_filename, or "" */
    long log_offset;   /* up to which it was read */
    bool was_lost;     /* the device, by the program */
    struct report report;

    VkDevice device;
    VkuDeviceDispatchTable vk;
    uint32_t memory_type;
    VkQueue queues[PLAY_QUEUES]; /* null: the device has none */
    VkCommandPool pools[2];      /* of the families */
    bool has_indirect, has_host, has_sparse, has_group;

    struct play_object objects[PLAY_OBJECTS];
    unsigned object_count;
    struct device_buffer scratch, instances; /* parts are used once */
    VkDeviceSize scratch_used, instances_used;
    VkAccelerationStructureTypeKHR bottom_type; /* of B structures */
    bool is_nv;                                 /* new structures are those of VK_NV_ray_tracing */
    VkGeometryTypeKHR nv_type;                  /* that they are built of */
    uint32_t nv_geometries;                     /* of each of them, all alike */
    VkAccelerationStructureKHR nameless[PLAY_NAMELESS];
    unsigned nameless_count;
    VkDeviceMemory pages;   /* of sparse buffers, or null */
    VkDeviceSize last_size; /* the size that the host got last */

    const struct play_object *recording; /* a command buffer with a name, or NULL */
    VkCommandBuffer primary, secondary;  /* others that record, or null */
    VkCommandBuffer executed;            /* the last secondary */
    VkCommandBuffer ended[PLAY_ITEMS];   /* for the next batch */
    uint32_t ended_count;
    struct batch batches[BATCHES_MAX];
    uint32_t batch_count;
    VkFence fence;
    VkRenderPass render_pass; /* null: none was begun */
    VkFramebuffer framebuffer;
    struct play_shader shaders[PLAY_SHADERS];

    bool is_closed;                    /* the program has no objects and no device any more */
    VkDebugUtilsMessengerEXT listener; /* of `when`, or null */
    const char *awaited;               /* the end of a message's id */
    char *const *reaction;             /* what is done then; NULL: nothing */
    const char *counted;               /* calls of the null driver, with | between them */
    uint64_t count_before;
    AssayCounters counters; /* of the last `costs` */

    /* What the last call was lent, which it must not modify: play_lend(). */
    const void *lent, *lent_before;
    size_t lent_size;
};

/* Ends the process, because a line is wrong. */
_Noreturn void play_fail(const struct play *play, const char *what);
#define PLAY_REQUIRE(play, condition)                                                              \
    do {                                                                                           \
        if (!(condition))                                                                          \
            play_fail(play, #condition);                                                           \
    } while (0)

/* Ends a command buffer. If memory ran out while it was recorded, the program ends. */
void play_end_recording(struct play *play, VkCommandBuffer commands);

/* Executes a program; the outcome is in the play. The play is zero-initialized but for its first
 * members, and is kept for the programs to come, which often share its instance and device. */
void play_program(struct play *play, const struct program *program);
void play_close(struct play *play);
/* The steps of play_program(), for programs that are made while they are played: play_begin()
 * returns false if the program is skipped; play_line() returns false if the line failed. */
bool play_begin(struct play *play, const struct program *program);
bool play_line(struct play *play, unsigned line);
void play_end(struct play *play);
/* Plays a line, which replaces the lines of the program. */
__attribute__((format(printf, 3, 4))) void play_text(struct play *play, struct program *program,
                                                     const char *format, ...);

/* Returns what a call gets as its array, a copy in a block of its own: a sanitizer reports who
 * reads past its end, or after the line. */
const void *play_copy_for_call(struct play *play, const void *array, size_t size);
/* Takes a block of zeros that lasts for the line, or to the end of the program if it keeps_blocks.
 */
void *play_block(struct play *play, size_t size);
/* Notes an array that the next call gets; and fails the program if the call has modified it. The
 * array lasts for the line. */
void play_lend(struct play *play, const void *array, size_t size);
void play_expect_unmodified(struct play *play);
/* Frees these blocks. play_end() calls it; whoever copies a play calls it for the copy. */
void play_free_blocks(struct play *play);

/* Notes the result of a call that lines can expect to fail. Positive results are successes. */
void play_note_result(struct play *play, VkResult result);
/* Ends a program that repeats calls, if memory ran out for what no further call can repeat. */
void play_give_up_if_scarce(struct play *play, VkResult result);
/* Makes a call. If memory ran out and the play repeats calls, as GET() does, it makes the call
 * again. play_note() also notes the result. */
#define play_call(play, call)                                                                      \
    ({                                                                                             \
        VkResult call_result = (call);                                                             \
        if (call_result == VK_ERROR_OUT_OF_HOST_MEMORY && (play)->repeats)                         \
            call_result = (call);                                                                  \
        call_result;                                                                               \
    })
#define play_note(play, call) play_note_result(play, play_call(play, call))

/* Executes commands with ";" between them. */
void play_words(struct play *play, char *const *words);

/* ---- what is there (device.c) */

/* Opens the instance and the device that the program needs. Returns NULL, or what is missing. */
const char *play_open_device(struct play *play);
/* The word behind `with` that names no extension which programs know; NULL: there is none. */
const char *play_unknown_extension(const struct program *program);
void play_close_device(struct play *play);
void play_close_instance(struct play *play);

/* Whether the instance that is open is the one that the program needs. */
bool play_suits(const struct play *play, const struct program *program);
/* Whether the level is at least execution: below, nothing is said of what is executed. */
bool play_sees_executions(const struct play *play);
bool play_is_setup(const struct program_line *line);
bool play_has(const struct play *play, const char *extension);
VkMicromapTypeEXT play_micromap_type(const struct play *play);

/* ---- what is expected (judge.c) */

/* The rule of that name, or NULL; and the command whose name begins a text. */
const struct rule_info *play_rule(const char *name);
enum build_command play_command_of(const char *text);
/* about RULE of COMMAND, or the first mistake that is expected of a command: what the program
 * breaks, or does not break. Returns false if the command has no such rule: then the program is
 * left out. VUID_NONE: it is about no rule. */
bool program_subject(const struct program *program, enum vuid *vuid, enum build_command *command);

/* Compares the messages so far with what a line has to report, or with -1 the whole program. */
void play_judge(struct play *play, int line);
/* Whether the program expects messages of no line. */
bool play_judges_whole(const struct play *play);
/* Whether a line expects a mistake: the messenger asks to skip the call. */
bool play_expects_mistake(const struct play *play, int line);
/* The word `size` stands for the size that the host got last. */
uint64_t play_number(const struct play *play, const char *word);
/* A word for a number. */
struct play_word {
    const char *name;
    uint64_t value;
};
/* The numbers of names with | between them, up to the end or a colon. */
uint64_t play_words_value(const struct play *play, const char *names, const struct play_word *words,
                          size_t count);
/* A member of a structure, and the word for it. */
struct play_member {
    const char *name;
    size_t offset, size;
};
#define PLAY_MEMBER(name, type, member)                                                            \
    {                                                                                              \
        name, offsetof(type, member), sizeof(((type *)NULL)->member)                               \
    }
/* Sets the member of that name to a number. Returns false if there is none. */
bool play_set_member(void *structure, const struct play_member *members, size_t count,
                     const char *name, uint64_t value);
/* Fails the program if the numbers differ. */
void play_expect_number(struct play *play, const char *name, uint64_t found, uint64_t wanted);

/* ---- objects (objects.c) */

/* Finds or creates an object. */
struct play_object *play_object(struct play *play, const char *name);
/* Finds an object and the offset behind its name. */
struct play_object *play_place(struct play *play, const char *word, VkDeviceSize *offset);
VkDeviceAddress play_address(struct play *play, const char *word);
/* An address of a buffer, for the device or the host. */
VkDeviceOrHostAddressKHR play_address_in(const struct device_buffer *buffer, VkDeviceSize offset,
                                         bool is_host);
VkDeviceOrHostAddressKHR play_address_for(struct play *play, const char *word, bool is_host);
/* Where the host writes to a place. */
unsigned char *play_bytes(struct play *play, const char *word);
/* Those that all programs have; and all. */
void play_create_objects(struct play *play);
void play_destroy_objects(struct play *play);
/* Whether it is a buffer and nothing else. */
bool play_is_buffer(const struct play_object *object);
/* Destroys an object, which can be created again; and the parts of the creation. */
void play_destroy_object(struct play *play, struct play_object *object);
void play_create_buffer(struct play *play, struct play_object *object);
/* A pool of three queries, which nothing has reset; of micromaps if the name begins with PM, of
 * structures of VK_NV_ray_tracing with PN, and of occlusion with PO. */
VkQueryPool play_create_queries(const struct play *play, const char *name);
void play_create_structure(struct play *play, struct play_object *object, VkBuffer buffer,
                           VkDeviceSize offset, VkDeviceSize size,
                           VkAccelerationStructureTypeKHR type);
VkBufferCreateInfo play_buffer_info(const struct play *play, VkDeviceSize size);
/* Writes to a place by the host. */
void play_write(struct play *play, const char *place, const void *bytes, size_t size);
/* lives.c */
void play_destroy_nameless(struct play *play);
bool play_life(struct play *play, char **words);
/* alias NAME PLACE [SIZE] [KIND]: a buffer in the memory of another one. KIND: `protected`,
 * `imported`, `replayed`; `described`: whose descriptor can be captured and replayed; `for-nv`:
 * with VK_BUFFER_USAGE_RAY_TRACING_BIT_NV alone; `plain`: without the usage for addresses;
 * `sparse BYTES`, with residency, and `aliased BYTES`: memory is bound to the first BYTES;
 * `unbound`: to none, until `back NAME PLACE`.
 * place NAME PLACE: a structure in a buffer.
 */
void play_alias(struct play *play, char **words);
void play_back(struct play *play, char **words);
void play_put(struct play *play, char **words);
/* init PLACE transform | ranges | box (upside down) | triangles (of a micromap) | triangle FORMAT
 * LEVEL (the first of these) | instances NAME...: the host writes, before all submissions */
void play_init(struct play *play, char **words);
/* references.c: has the null driver note what builds read, if the program asks for it. */
void play_note_references(struct play *play);
bool play_reference(struct play *play, char **words);
uint64_t play_stranger(struct play *play);
/* What an instance has as its reference to a structure. */
uint64_t play_reference_to(const struct play *play, const struct play_object *object);
/* inputs.c: other inputs of builds. Returns false if the words are others. */
bool play_init_input(struct play *play, char **words);
/* The references of a host build are handles. */
void play_write_instances(struct play *play, void *to, char **names, bool is_host);

/* ---- commands (each returns false if the line is another command) */

/* The command buffer that commands are recorded to. */
VkCommandBuffer play_commands(struct play *play);

/* The sizes that the words of a build need. */
VkAccelerationStructureBuildSizesInfoKHR play_build_sizes(struct play *play, char **words,
                                                          VkAccelerationStructureBuildTypeKHR type);
VkBuildAccelerationStructureFlagsKHR play_flags(const struct play *play, const char *word);
/* nv.c */
/* For the builds of the program, or of that size for a compact copy if that is not 0. */
void play_create_nv(struct play *play, struct play_object *object, VkDeviceSize compacted);
void play_query_nv(struct play *play, char **words);
void play_build_nv(struct play *play, char **words);
void play_copy_nv(struct play *play, char **words);
/* builds.c */
bool play_build(struct play *play, char **words);
/* records.c */
bool play_records(struct play *play, char **words);
void play_skip_records(struct play *play);
VkDeviceOrHostAddressKHR play_unused_scratch(struct play *play, bool is_host);
/* micromaps.c */
/* The usages of `mixed` micromaps: three triangles with opacities, or two with displacements. */
enum { PLAY_MIXED_USAGES = 2 };
const VkMicromapUsageEXT *play_mixed_usages(const struct play *play);
void play_build_micromap(struct play *play, char **words, bool is_host);
void play_copy_micromap(struct play *play, char **words, bool is_host);
/* clusters.c */
bool play_build_addressed(struct play *play, char **words);
/* copies.c */
bool play_copy(struct play *play, char **words);
/* transfers.c */
bool play_transfer(struct play *play, char **words);
/* sync.c */
bool play_sync(struct play *play, char **words);
VkPipelineStageFlags2 play_stages(struct play *play, const char *names);
/* shaders.c */
bool play_shader(struct play *play, char **words);
void play_destroy_shaders(struct play *play);
/* commands.c */
bool play_command_buffer(struct play *play, char **words);
/* cpu.c */
bool play_cpu(struct play *play, char **words);
/* rays.c */
void play_probe(struct play *play, char **words);
/* foreign.c */
bool play_foreign(struct play *play, char **words);
void play_floats(struct play *play, char *const *words);
/* faults.c */
bool play_fault(struct play *play, char **words);
VkResult play_result_named(const struct play *play, const char *name);
const char *play_name_of(VkResult result);
unsigned play_queue_of(const struct play *play, const char *word);
/* messengers.c */
bool play_messenger(struct play *play, char **words);
/* When ID COMMAND; COMMAND... */
void play_await(struct play *play);
void play_destroy_messenger(struct play *play);
/* labels.c */
bool play_label(struct play *play, char **words);
/* wild.c */
bool play_wild(struct play *play, char **words);
/* host.c */
bool play_host(struct play *play, char **words);
/* submit.c */
/* Reads NAME[=VALUE][@STAGES]. */
void play_read_semaphore(struct play *play, const char *word, VkSemaphoreSubmitInfo *to);
bool play_submit(struct play *play, char **words);
/* Adds the command buffers that the program has not named to the next batch. */
void play_end_unnamed(struct play *play);
/* Submits what was not submitted, and waits. */
void play_finish(struct play *play);

static inline bool play_is(const char *word, const char *name)
{
    return word && !__builtin_strcmp(word, name);
}

#endif
