/* SPDX-License-Identifier: Apache-2.0 */
/* What is reported when a signal ends the process. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#define COPIED ": its inputs had been copied, and it had not finished"

static const struct row {
    const char *test;
    struct crash crash;
    struct ending ending;
    const char *setting, *value; /* NULL: none */
} rows[] = {
    {"test_inputs_were_copied",
     {.in_thread = true},
     {SIGSEGV,
      "[ ASSAY-crash ]...The process received SIGSEGV for address 0x10. 1 build was submitted to "
      "..." COPIED "...minX...read when the process crashed"}},
    {"test_call_sites",
     {.in_thread = true},
     {SIGSEGV, "and it had not finished. Called from /.../postmortem_crash_test+0x"},
     "VK_ASSAY_VALIDATION_CALL_SITES",
     "frames"},
    {"test_inputs_were_not_copied",
     {.in_thread = true, .skips_copies = true},
     {SIGSEGV, ": the device had not reached it.", "minX"}},
    /* The call that submits has not returned, so the order has not run the batch yet. */
    {"test_in_the_submitting_call", {.level = NULL}, {SIGSEGV, COPIED}},
    {"test_level_execution",
     {.level = "execution"},
     {SIGSEGV, "1 build was submitted to ", "copied"}},
    {"test_level_state", {.level = "state"}, {SIGSEGV, .lacks = "ASSAY-crash"}},
    {"test_off",
     {.in_thread = true},
     {SIGSEGV, .lacks = "ASSAY-crash"},
     "VK_ASSAY_VALIDATION_CRASH_REPORT",
     "false"},
    {"test_SIGSEGV", {.in_thread = true, .signal = SIGSEGV}, {SIGSEGV, "received SIGSEGV...minX"}},
    {"test_SIGBUS",
     {.in_thread = true, .signal = SIGBUS},
     {SIGBUS, "received SIGBUS. 1 build...minX"}},
    {"test_SIGFPE",
     {.in_thread = true, .signal = SIGFPE},
     {SIGFPE, "received SIGFPE. 1 build...minX"}},
    {"test_SIGABRT",
     {.in_thread = true, .signal = SIGABRT},
     {SIGABRT, "received SIGABRT. 1 build...minX"}},
};

static struct crash played;

static void play_crash(void)
{
    open_at(played.level);
    play_stranger(&play); /* a device that goes leaves the handlers to this one */
    crash(&played);
}

TEST_OF_ROWS(test_crashes, rows, const struct row *row, unit_test_nothing)
{
    played = row->crash;
    run(play_crash, row->setting, row->value);
    expect_ending(&row->ending);
}

static void crash_at_25_builds(void)
{
    open_at(NULL);
    plan_crash(&(struct crash){.number = 24});
    execute_line("begin c0");
    execute_line("repeat 25 " BUILD_BOX);
    execute_line("end; submit c0");
}

TEST(test_twenty_builds_are_listed)
{
    run(crash_at_25_builds, NULL, NULL);
    EXPECT_ENDING(
        SIGSEGV,
        "25 builds were submitted...1. build of ...build 23, as submitted...2. build of ..."
        "build 24, as submitted...\n20. build of ...\nand 5 more.",
        "\n21. build of ");
}

static void crash_without_builds(void)
{
    open_at(NULL);
    raise(SIGSEGV);
}

TEST(test_nothing_to_say)
{
    run(crash_without_builds, NULL, NULL);
    EXPECT_ENDING(SIGSEGV);
    assert_string_equal(output, "");
}

TEST(test_json)
{
    char path[] = "/tmp/assay-crash-XXXXXX", record[OUTPUT_SIZE];
    const int file = mkstemp(path);
    assert_true(file >= 0);
    setenv("VK_ASSAY_VALIDATION_LOG_FORMAT", "json", 1);
    played = (struct crash){.in_thread = true};
    run(play_crash, "VK_ASSAY_VALIDATION_LOG_FILENAME", path);
    unsetenv("VK_ASSAY_VALIDATION_LOG_FORMAT");
    const ssize_t size = read(file, record, sizeof(record) - 1);
    assert_true(size > 0);
    record[size] = '\0';
    close(file);
    unlink(path);
    EXPECT_ENDING(SIGSEGV, "ASSAY-crash"); /* as text, too */
    assert_has(record,
               "\"Severity\":\"Warning\",\"VUID\":\"ASSAY-crash\",\"MessageID\":\"0x22cd1989\","
               "\"Objects\":[],\"MainMessage\":\"The process received SIGSEGV for address 0x10. "
               "1 build was submitted to VkDevice ");
    assert_has(record, "complete:\\n1. build of ");
    assert_has(record, "\"when\":\"read when the process crashed\"");
}
