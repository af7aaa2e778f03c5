/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of log_format = json, of names in message_id_filter, and of log files: those that cannot be
 * written, and the words in log_filename. schema_test.py validates lines, and scenes_test.c has
 * where they go. */
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "hearing.h"
#include "src/report/log/lines.h"

/* ---- one finding, with all that a line may have */

static struct object_names *names;
static struct label_stack labels;
static struct shared_labels queue_labels;

static void set_up_names(void)
{
    names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0xb, "rock, \"large\"");
    label_push(&queue_labels.stack, "frame 7");
    label_push(&labels, "scene");
    label_push(&labels, "rocks");
}

static void free_names(void)
{
    object_names_destroy(names);
    label_stack_clear(&labels);
    label_stack_clear(&queue_labels.stack);
}

static bool send_full(struct reporter *reporter)
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct finding finding;
    finding_says(&finding, "scratchData.deviceAddress", "is in {}",
                 object(VK_OBJECT_TYPE_BUFFER, 0xb));
    also_violates(&finding, RULE_build_flags_are_valid);
    return reporter_send(
        reporter, SENT_RULE, &location,
        &(struct call_origin){
            .device = (VkDevice)(uintptr_t)0xd,
            .command_buffer = (VkCommandBuffer)(uintptr_t)0xc,
            .build_index = 3,
            .submission = {.queue = (VkQueue)(uintptr_t)0xe, .number = 7, .labels = &queue_labels},
            .names = names,
            .labels = &labels,
        },
        &finding);
}

TEST(test_lines_of_an_instance)
{
    surrounding_json("a.jsonl");
    environment_set("DUPLICATE_MESSAGE_LIMIT=1");
    set_up_names();
    struct hearing hearing = {0};
    struct reporter *reporter = reporter_heard_by(&hearing);
    send_full(reporter);
    send_full(reporter);
    reporter_warn(reporter, "Something is odd.");
    reporter_add_unchecked(reporter, "odd builds", 3);
    assert_int_equal(hearing.count, 2); /* messengers get the text */
    assert_has(hearing.text, "Something is odd.");
    reporter_destroy(reporter);
    free_names();
    assert_int_equal(count_lines(file_read("a.jsonl")), 4);
    assert_parts(file_line(0),
                 "{\"Type\":\"Header\",\"pid\":...\"Executable\":\"/...\"level\":\"execution\"..."
                 "\"duplicate_message_limit\":\"1\"");
    assert_parts(
        file_line(1),
        "\"Severity\":\"Error\",\"VUID\":\"" SENT_ID
        "\",\"MessageID\":\"0x..."
        "{\"type\":\"VkCommandBuffer\",\"handle\":\"0xc\"}..."
        "{\"type\":\"VkBuffer\",\"handle\":\"0xb\",\"name\":\"rock, \\\"large\\\"\"}..."
        "\"Function\":\"vkCmdBuildAccelerationStructuresKHR\"..."
        "\"Location\":\"pInfos[0].scratchData.deviceAddress\"..."
        "\"MainMessage\":\"pInfos[0].scratchData.deviceAddress is in VkBuffer 0xb["
        "\\\"rock, \\\\\\\"large\\\\\\\"\\\"]. Round the address up to that alignment, and create "
        "the "
        "scratch VkBuffer with as many bytes more.\"..."
        "\"DebugRegion\":\"frame 7::scene::rocks\"...\"SpecText\":\"For each element of pInfos..."
        "#" SENT_ID
        "\"...\"level\":\"state\",\"also\":["
        "\"VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-parameter\"],"
        "\"device\":\"0xd\",\"build\":3,\"queue\":\"0xe\",\"submission\":7}");
    assert_parts(file_line(2),
                 "\"Severity\":\"Warning\",\"VUID\":\"ASSAY-warning\"..."
                 "\"Objects\":[],\"MainMessage\":\"Something is odd.\"}");
    assert_parts(file_line(3), "\"Type\":\"Summary\"...\"Findings\":{\"" SENT_ID
                               "\":2},\"HeldBack\":{\"" SENT_ID "\":1}...\"odd builds (3)\"");
}

TEST(test_longest_text)
{
    static struct json json;
    static char text[JSON_TEXT_MAX + 2];
    for (size_t size = JSON_TEXT_MAX - 1; size < sizeof(text); size++) {
        memset(text, 'x', size);
        json_begin(&json);
        json_text(&json, "a", text);
        assert_true(json_end(&json));
        assert_int_equal(json.text.length,
                         strlen("{\"a\":\"\"}\n") + (size < JSON_TEXT_MAX ? size : JSON_TEXT_MAX));
    }
}

/* Control characters, and bytes that are not UTF-8. */
TEST(test_escapes_of_json)
{
    static struct json json;
    json_begin(&json);
    json_text(&json, "a\"", "\"\\/\b\f\n\r\t\x01\x1f \x7f\xff\xc3\xa9");
    json_begin_array(&json, "b");
    json_number(&json, NULL, UINT64_MAX);
    json_hex(&json, NULL, 0x1f);
    json_text(&json, NULL, NULL);
    json_end_array(&json);
    assert_true(json_end(&json));
    assert_string_equal(
        json.line,
        "{\"a\\\"\":\"\\\"\\\\/\\b\\f\\n\\r\\t\\u0001\\u001F \x7f\xef\xbf\xbd\xc3\xa9\","
        "\"b\":[18446744073709551615,\"0x1f\",\"\"]}\n");
    json_begin(&json);
    json_begin_array(&json, "b");
    assert_false(json_end(&json)); /* is not one object */
}

/* The label is cut as in findings, so that the two can be compared. */
TEST(test_expectation)
{
    char label[400];
    snprintf(label, sizeof(label), EXPECTATION_PREFIX " %0380d", 0);
    surrounding_json("a.jsonl");
    struct reporter *reporter = reporter_of(NULL);
    reporter_record(reporter, &(struct log_record){
                                  .kind = RECORD_EXPECTATION,
                                  .device = (VkDevice)(uintptr_t)0xd,
                                  .label = label,
                              });
    set_up_names();
    label_push(&labels, label);
    send_full(reporter);
    reporter_destroy(reporter);
    free_names();
    file_read("a.jsonl");
    assert_parts(
        file_line(1),
        "{\"Type\":\"Expectation\",\"pid\":...\"device\":\"0xd\",\"label\":\"" EXPECTATION_PREFIX
        " 000");
    label[MESSAGE_NAME_SIZE - 1] = '\0';
    assert_has(file_line(1), label);
    assert_has(file_line(2), label);
}

/* Fails before the reporter exists, or not at all. */
TEST(test_scarce_memory)
{
    surrounding_json("a.jsonl");
    for (int count = 0; memory_is_scarce(count); count++) {
        struct reporter *reporter = NULL;
        const VkInstanceCreateInfo create_info = {0};
        VkResult result = reporter_create(&create_info, &reporter);
        memory_fail_no_more();
        if (result == VK_SUCCESS)
            reporter_destroy(reporter);
        else
            assert_int_equal(result, VK_ERROR_OUT_OF_HOST_MEMORY);
    }
}

/* ---- message_id_filter = ID@GLOB */

/* Returns whether a finding about "rock, "large"" with labels frame 7, scene and rocks is sent. */
static bool is_sent_with(const char *filter)
{
    struct hearing hearing = {0};
    surrounding_clear(NULL);
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", filter, 1);
    environment_set("DEBUG_ACTION=callback,fail");
    struct reporter *reporter = reporter_heard_by(&hearing);
    bool is_failed = send_full(reporter);
    assert_int_equal(is_failed, hearing.count); /* a muted finding does not skip the call */
    reporter_destroy(reporter);
    return hearing.count;
}

TEST(test_filters_with_names)
{
    static const struct {
        const char *filter;
        bool is_sent;
    } cases[] = {
        {SENT_ID "@rock*", false},
        {SENT_ID "@*large*", false},
        {SENT_ID "@ROCK*", true}, /* names have cases */
        {SENT_ID "@rock", true},  /* the whole name */
        {SENT_ID "@scene", false},
        {SENT_ID "@rocks", false},
        {SENT_ID "@frame ?", false},
        {SENT_ID "@frame [0-6]", true},
        {SENT_ID "@scene::rocks,", true},
        {"03710@sc*", false},
        {"vuid-vkcmdbuildaccelerationstructureskhr-pinfos-03710@scene", false},
        {"03711@scene", true},
        {"03711@scene, " SENT_ID "@tree*, " SENT_ID "@scene", false},
        {SENT_ID "@*", false},
    };
    set_up_names();
    for (size_t i = 0; i < LENGTH(cases); i++)
        if (is_sent_with(cases[i].filter) != cases[i].is_sent)
            fail_msg("%s", cases[i].filter);
    free_names();
}

/* Findings that are muted take nothing from the limit, and are not counted. */
TEST(test_muted_findings_are_not_counted)
{
    surrounding_json("a.jsonl");
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", SENT_ID "@scene", 1);
    environment_set("DUPLICATE_MESSAGE_LIMIT=1");
    set_up_names();
    struct reporter *reporter = reporter_of(NULL);
    for (int i = 0; i < 30; i++)
        send_full(reporter);
    send_one(reporter);
    reporter_destroy(reporter);
    free_names();
    assert_int_equal(count_lines(file_read("a.jsonl")), 3);
    assert_has(file_line(2), "\"Findings\":{\"" SENT_ID "\":1},\"HeldBack\":{}");
}

/* ---- files that cannot be written */

/* Returns how often stderr has the warning. */
static unsigned warnings_of(const char *reason)
{
    struct hearing hearing = {0};
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_heard_by(&hearing);
    send_one(reporter);
    send_one(reporter);
    reporter_destroy(reporter);
    unsigned count = 0;
    for (const char *text = capture_end(); (text = strstr(text, "cannot be written")); text++)
        count += strstr(text, reason) == text + strlen("cannot be written (");
    assert_in_range(hearing.count, 2, 3);
    return count;
}

TEST(test_full_disk)
{
    surrounding_json("/dev/full");
    assert_int_equal(warnings_of("No space left on device"), 1);
    environment_set("LOG_FORMAT=text");
    assert_int_equal(warnings_of("No space left on device"), 1);
}

/* Returns the limit before. The parent process may have ignored the signal of this limit. */
static struct rlimit limit_files(size_t size)
{
    struct rlimit before;
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    const struct rlimit limit = {size, before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    return before;
}

/* The kernel sends SIGXFSZ, which must not end the application. The lines that fit stay. */
TEST(test_limit_of_file_sizes)
{
    surrounding_json("a.jsonl");
    struct rlimit before = limit_files(1500);
    unsigned warnings = warnings_of("File too large");
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(warnings, 1);
    assert_has(file_read("a.jsonl"), "\"Type\":\"Header\"");
    remove("a.jsonl");
    environment_set("LOG_FORMAT=text");
    before = limit_files(500);
    warnings = warnings_of("File too large");
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(warnings, 1);
}

/* The kernel sends SIGPIPE, which must not end the application. */
TEST(test_closed_pipe)
{
    int ends[2];
    char path[32];
    assert_int_equal(pipe(ends), 0);
    snprintf(path, sizeof(path), "/dev/fd/%d", ends[1]);
    surrounding_json(path);
    signal(SIGPIPE, SIG_DFL);
    struct reporter *reporter = reporter_of(NULL);
    close(ends[0]);
    capture_begin(STDERR_FILENO);
    send_one(reporter);
    reporter_destroy(reporter);
    assert_has(capture_end(), "cannot be written (Broken pipe)");
    close(ends[1]);
}

/* After a line that was cut by a full disk, a new one begins on its own line. */
static void expect_new_line_after(size_t part)
{
    surrounding_json("a.jsonl");
    struct hearing hearing = {0};
    struct reporter *reporter = reporter_heard_by(&hearing);
    size_t length = strlen(file_read("a.jsonl"));
    struct rlimit before = limit_files(length + part);
    capture_begin(STDERR_FILENO);
    send_one(reporter);
    capture_end();
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    send_one(reporter);
    reporter_destroy(reporter);
    assert_int_equal(count_lines(file_read("a.jsonl")), 4);
    assert_int_equal(strlen(file_line(1)), part);
    assert_has(file_line(2), "{\"Type\":\"Finding\",");
    assert_has(file_line(3), "{\"Type\":\"Summary\",");
    remove("a.jsonl");
}

TEST(test_after_a_cut_line)
{
    expect_new_line_after(100);
    expect_new_line_after(1);
}

/* ---- names of files */

TEST(test_words_in_the_file_name)
{
    char path[LOG_PATH_SIZE], expected[256], pattern[LOG_PATH_SIZE + 1];
    assert_true(log_filename_expand("a-%p_%e%%%%p%x%", path));
    snprintf(expected, sizeof(expected), "a-%d_report_log_test%%%%p%%x%%", (int)getpid());
    assert_string_equal(path, expected);
    memset(pattern, 'x', sizeof(pattern));
    pattern[LOG_PATH_SIZE] = '\0';
    assert_false(log_filename_expand(pattern, path));
    surrounding_clear(NULL);
    setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", "100%%.txt", 1);
    struct reporter *reporter = reporter_of(NULL);
    send_one(reporter);
    reporter_destroy(reporter);
    assert_has(file_read("100%.txt"), SENT_ID);
    remove("100%.txt");
}

/* After a fork the child has a file of its own. */
TEST(test_child)
{
    surrounding_json("%p.jsonl");
    struct reporter *reporter = reporter_of(NULL);
    pid_t child = fork();
    if (child == 0) {
        struct reporter *own = reporter_of(NULL);
        send_one(own);
        reporter_destroy(own);
        _exit(0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    reporter_destroy(reporter);
    char name[64], pid[64];
    snprintf(name, sizeof(name), "%d.jsonl", (int)child);
    snprintf(pid, sizeof(pid), "\"pid\":%d,", (int)child);
    assert_int_equal(count_lines(file_read(name)), 3);
    for (unsigned i = 0; i < 3; i++)
        assert_has(file_line(i), pid);
    remove(name);
    snprintf(name, sizeof(name), "%d.jsonl", (int)getpid());
    assert_int_equal(count_lines(file_read(name)), 2);
    remove(name);
}
