/* SPDX-License-Identifier: Apache-2.0 */
/* Listening, capturing, sending. */
#define _GNU_SOURCE
#include "hearing.h"

#include <ftw.h>

static void copy(char *to, size_t size, const char *text)
{
    snprintf(to, size, "%s", text ? text : "(null)");
}

MESSENGER_CALLBACK(hear)
{
    struct hearing *hearing = user;
    hearing->count++;
    hearing->severity = severity;
    hearing->types = types;
    copy(hearing->id, sizeof(hearing->id), data->pMessageIdName);
    copy(hearing->text, sizeof(hearing->text), data->pMessage);
    hearing->number = data->messageIdNumber;
    hearing->queue_label_count = data->queueLabelCount;
    hearing->label_count = data->cmdBufLabelCount;
    for (uint32_t i = 0; i < data->cmdBufLabelCount && i < HEARD_LABELS; i++)
        copy(hearing->labels[i], sizeof(hearing->labels[i]), data->pCmdBufLabels[i].pLabelName);
    hearing->object_count = data->objectCount;
    for (uint32_t i = 0; i < data->objectCount && i < HEARD_OBJECTS; i++) {
        hearing->types_of_objects[i] = data->pObjects[i].objectType;
        hearing->objects[i] = data->pObjects[i].objectHandle;
        copy(hearing->names[i], sizeof(hearing->names[i]), data->pObjects[i].pObjectName);
    }
    return hearing->answer;
}

VkDebugUtilsMessengerCreateInfoEXT hearing_messenger(struct hearing *hearing)
{
    return MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                                   VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                .pfnUserCallback = hear, .pUserData = hearing);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL hear_report(VkDebugReportFlagsEXT flags,
                                                  VkDebugReportObjectTypeEXT object_type,
                                                  uint64_t object, size_t location,
                                                  int32_t message_code, const char *layer_prefix,
                                                  const char *message, void *user)
{
    struct hearing *hearing = user;
    hearing->count++;
    hearing->report_flags = flags;
    hearing->object_type = object_type;
    hearing->object = object;
    hearing->number = message_code;
    copy(hearing->prefix, sizeof(hearing->prefix), layer_prefix);
    copy(hearing->text, sizeof(hearing->text), message);
    return hearing->answer;
}

VkDebugReportCallbackCreateInfoEXT hearing_report_callback(struct hearing *hearing)
{
    return MAKE(VkDebugReportCallbackCreateInfoEXT,
                .flags = VK_DEBUG_REPORT_ERROR_BIT_EXT | VK_DEBUG_REPORT_WARNING_BIT_EXT,
                .pfnCallback = hear_report, .pUserData = hearing);
}

/* ---- streams */

static struct {
    int descriptor, saved;
    FILE *file;
    char text[20000];
} captured;

void capture_begin(int descriptor)
{
    fflush(NULL);
    captured.descriptor = descriptor;
    captured.saved = dup(descriptor);
    captured.file = tmpfile();
    assert_non_null(captured.file);
    dup2(fileno(captured.file), descriptor);
}

const char *capture_end(void)
{
    fflush(NULL);
    dup2(captured.saved, captured.descriptor);
    close(captured.saved);
    rewind(captured.file);
    size_t length = fread(captured.text, 1, sizeof(captured.text) - 1, captured.file);
    captured.text[length] = '\0';
    fclose(captured.file);
    return captured.text;
}

const char *capture_message(const struct message *message)
{
    capture_begin(STDERR_FILENO);
    message_write(message, stderr);
    return capture_end();
}

static char file_text[64 * 1024];

const char *file_read(const char *name)
{
    FILE *file = fopen(name, "r");
    assert_non_null(file);
    file_text[fread(file_text, 1, sizeof(file_text) - 1, file)] = '\0';
    fclose(file);
    return file_text;
}

void file_fill(const char *name, const char *text)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

const char *file_line(unsigned n)
{
    static char line[16384];
    const char *at = file_text;
    for (; n; n--)
        assert_non_null(at = strchr(at, '\n') + 1);
    snprintf(line, sizeof(line), "%.*s", (int)strcspn(at, "\n"), at);
    return line;
}

unsigned count_lines(const char *text)
{
    unsigned count = 0;
    for (; *text; text++)
        count += *text == '\n';
    return count;
}

/* ---- surrounding */

static char folder[] = "/tmp/assay_report_XXXXXX";
static bool has_folder;

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *level)
{
    return remove(path);
}

void unit_test_close(void)
{
    if (has_folder)
        nftw(folder, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
}

void surrounding_clear(const char *settings_text)
{
    static const char prefix[] = "VK_ASSAY_VALIDATION_";
    for (char **at = environ; *at;) {
        char name[128];
        snprintf(name, sizeof(name), "%.*s", (int)strcspn(*at, "="), *at);
        const bool is_setting = strncmp(name, prefix, strlen(prefix)) == 0;
        if (is_setting)
            unsetenv(name);
        at = is_setting ? environ : at + 1;
    }
    unsetenv("VK_LAYER_SETTINGS_PATH");
    unsetenv("XDG_DATA_HOME");

    if (!has_folder)
        assert_non_null(mkdtemp(folder));
    has_folder = true;
    assert_int_equal(chdir(folder), 0);
    setenv("HOME", folder, 1);
    nftw(".local", remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    remove("vk_layer_settings.txt");
    if (settings_text)
        file_fill("vk_layer_settings.txt", settings_text);
}

void surrounding_set_up(void)
{
    surrounding_clear(NULL);
}

void environment_set(const char *settings)
{
    char name[64] = "VK_ASSAY_VALIDATION_", value[256];
    const size_t prefix = strlen(name);
    for (int length = 0; sscanf(settings, " %40[^=]=%255s%n", name + prefix, value, &length) == 2;
         settings += length)
        setenv(name, value, 1);
}

void surrounding_json(const char *filename)
{
    surrounding_clear(NULL);
    remove("a.jsonl");
    environment_set("LOG_FORMAT=json");
    if (filename)
        setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", filename, 1);
}

struct reporter *reporter_of(const void *chain)
{
    struct reporter *reporter = NULL;
    const STRUCT(VkInstanceCreateInfo, create_info, .pNext = chain);
    assert_int_equal(reporter_create(&create_info, &reporter), VK_SUCCESS);
    return reporter;
}

void reporter_add(struct reporter *reporter, VkDebugUtilsMessengerEXT handle,
                  const VkDebugUtilsMessengerCreateInfoEXT *info)
{
    assert_int_equal(reporter_add_messenger(reporter, handle, info), VK_SUCCESS);
}

void reporter_add_hearing(struct reporter *reporter, unsigned n, struct hearing *hearing)
{
    const VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(hearing);
    reporter_add(reporter, MESSENGER(n), &info);
}

struct reporter *reporter_heard_by(struct hearing *hearing)
{
    struct reporter *reporter = reporter_of(NULL);
    reporter_set_instance_alive(reporter, true);
    reporter_add_hearing(reporter, 0, hearing);
    return reporter;
}

void heard_test_run(const char *settings,
                    void (*test)(struct reporter *reporter, struct hearing *hearing))
{
    struct hearing hearing = {0};
    surrounding_clear(NULL);
    environment_set(settings);
    struct reporter *reporter = reporter_heard_by(&hearing);
    test(reporter, &hearing);
    reporter_destroy(reporter);
}

bool send_one(struct reporter *reporter)
{
    struct finding finding;
    finding_says(&finding, "scratchData.deviceAddress", "{} is not a multiple of {} ({})",
                 hex(0x1010), phrase("minAccelerationStructureScratchOffsetAlignment"),
                 number(256));
    const struct location location = {
        .command = COMMAND_DEVICE, .subject = SUBJECT_BUILD, .build = 1};
    return reporter_send(reporter, SENT_RULE, &location, &(struct call_origin){0}, &finding);
}

bool send_wrong(struct reporter *reporter, enum rule rule, enum build_command command,
                const char *field)
{
    const struct location location = {.command = command, .subject = SUBJECT_BUILD};
    struct finding finding;
    violated_plainly(&finding, field, "is wrong");
    return reporter_send(reporter, rule, &location, &(struct call_origin){0}, &finding);
}

struct object_names *names_create(void)
{
    struct object_names *names;
    assert_int_equal(object_names_create(&names), VK_SUCCESS);
    return names;
}

void label_push(struct label_stack *stack, const char *name)
{
    label_stack_push(stack, &MAKE(VkDebugUtilsLabelEXT, .pLabelName = name));
}
