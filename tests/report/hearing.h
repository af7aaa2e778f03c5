/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of messages share: a messenger that keeps what it hears, files that keep what is
 * written, a surrounding without settings, and one finding to send. */
#ifndef REPORT_HEARING_H
#define REPORT_HEARING_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/report/message.h"
#include "src/report/reporter.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/object_names.h"
#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))

enum { HEARD_TEXT = 10000, HEARD_OBJECTS = 8, HEARD_LABELS = 20 };

/* The last message, copied. Not for several threads. */
struct hearing {
    unsigned count;
    VkBool32 answer;
    VkDebugUtilsMessageSeverityFlagBitsEXT severity;
    VkDebugUtilsMessageTypeFlagsEXT types;
    VkDebugReportFlagsEXT report_flags;
    VkDebugReportObjectTypeEXT object_type;
    uint64_t object;
    char id[256], prefix[32], text[HEARD_TEXT];
    int32_t number;
    uint32_t object_count, label_count, queue_label_count;
    VkObjectType types_of_objects[HEARD_OBJECTS];
    uint64_t objects[HEARD_OBJECTS];
    char names[HEARD_OBJECTS][256];
    char labels[HEARD_LABELS][64];
};

VkDebugUtilsMessengerCreateInfoEXT hearing_messenger(struct hearing *hearing);
VkDebugReportCallbackCreateInfoEXT hearing_report_callback(struct hearing *hearing);

/* Sends stderr (or another stream) to a file until the end, which gives the text; one at a time. */
void capture_begin(int descriptor);
const char *capture_end(void);
/* What message_write() writes. */
const char *capture_message(const struct message *message);

/* Writes a file with this text. */
void file_fill(const char *name, const char *text);
/* The text of a file, until the next call; fails the test if there is no file. */
const char *file_read(const char *name);
/* The n-th line of that text. */
const char *file_line(unsigned n);
unsigned count_lines(const char *text);

/* An empty folder becomes the current one and HOME, and no setting is in the environment. The text
 * is that of vk_layer_settings.txt there, or NULL for none. The folder goes after the tests. */
void surrounding_clear(const char *settings_text);

/* A setup: the same without a file. */
void surrounding_set_up(void);
/* Puts settings into the environment: "LEVEL=state LOG_FORMAT=json". */
void environment_set(const char *settings);
/* Clears the surroundings, removes a.jsonl, and sets log_format = json and log_filename; NULL:
 * stderr. */
void surrounding_json(const char *filename);

/* A reporter for VkInstanceCreateInfo with this chain; fails the test if there is none. */
struct reporter *reporter_of(const void *chain);

/* Handles of the n-th messenger and callback. */
#define MESSENGER(n) ((VkDebugUtilsMessengerEXT)(uintptr_t)(0x11 + (n)))
#define CALLBACK(n) ((VkDebugReportCallbackEXT)(uintptr_t)(0x11 + (n)))

/* Adds a messenger, or fails the test. */
void reporter_add(struct reporter *reporter, VkDebugUtilsMessengerEXT handle,
                  const VkDebugUtilsMessengerCreateInfoEXT *info);
/* Adds MESSENGER(n). */
void reporter_add_hearing(struct reporter *reporter, unsigned n, struct hearing *hearing);

/* A reporter of a living instance, with MESSENGER(0). */
struct reporter *reporter_heard_by(struct hearing *hearing);

/* A test with such a reporter, which is created with the settings that environment_set() takes:
 * HEARD_TEST(name, "LEVEL=state") { ... }. It has `reporter` and `hearing`. */
#define HEARD_TEST(name, settings)                                                                 \
    static void heard_##name(struct reporter *reporter, struct hearing *hearing);                  \
    TEST(name)                                                                                     \
    {                                                                                              \
        heard_test_run(settings, heard_##name);                                                    \
    }                                                                                              \
    static void heard_##name(struct reporter *reporter, struct hearing *hearing)
void heard_test_run(const char *settings,
                    void (*test)(struct reporter *reporter, struct hearing *hearing));

/* Sends one finding of pInfos[1] of vkCmdBuildAccelerationStructuresKHR, of a rule with an id that
 * is SENT_ID. */
#define SENT_RULE RULE_scratch_address_is_aligned
#define SENT_VUID VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_03710
#define SENT_ID "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03710"
bool send_one(struct reporter *reporter);
/* Sends that a member, or "" for all of it, is wrong, of the first build of a call. */
bool send_wrong(struct reporter *reporter, enum rule rule, enum build_command command,
                const char *field);

/* Fail the test if there is no memory. */
struct object_names *names_create(void);
void label_push(struct label_stack *stack, const char *name);

#endif
