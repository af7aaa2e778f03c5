/* SPDX-License-Identifier: Apache-2.0 */
/* What is reported when a signal ends the process. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* ---- what is reported */

static void crash_in_call(void)
{
    open_at(NULL);
    crash(0, false, false);
}

static void crash_in_thread(void)
{
    open_at(NULL);
    crash(0, true, false);
}

static void crash_before_copies(void)
{
    open_at(NULL);
    crash(0, true, true);
}

static void crash_at_execution(void)
{
    open_at("execution");
    crash(0, false, false);
}

static void crash_at_state(void)
{
    open_at("state");
    crash(0, false, false);
}

TEST(test_inputs_were_copied)
{
    run(crash_in_thread, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output("[ ASSAY-crash ]");
    expect_output("The process received SIGSEGV for address 0x10. 1 build was submitted to ");
    expect_output(": its inputs had been copied, and it had not finished.");
    expect_output("minX");
    expect_output("read when the process crashed");
}

TEST(test_inputs_were_not_copied)
{
    run(crash_before_copies, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output(": the device had not reached it.");
    expect_no_output("minX");
}

/* The call that submits has not returned, so the order has not run the batch yet. */
TEST(test_in_the_submitting_call)
{
    run(crash_in_call, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output(": its inputs had been copied, and it had not finished.");
}

TEST(test_levels)
{
    run(crash_at_execution, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output("1 build was submitted to ");
    expect_no_output("copied");
    run(crash_at_state, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_no_output("ASSAY-crash");
}

TEST(test_off)
{
    run(crash_in_thread, "VK_ASSAY_VALIDATION_CRASH_REPORT", "false");
    expect_signal(SIGSEGV);
    expect_no_output("ASSAY-crash");
}

/* ---- other signals */

static int played_signal;

static void crash_by_signal(void)
{
    open_at(NULL);
    crash(played_signal, true, false);
}

TEST(test_signals)
{
    static const struct {
        int number;
        const char *text;
    } rows[] = {{SIGSEGV, "received SIGSEGV"},
                {SIGBUS, "received SIGBUS. 1 build"},
                {SIGFPE, "received SIGFPE. 1 build"},
                {SIGABRT, "received SIGABRT. 1 build"}};
    for (size_t i = 0; i < ARRAY_COUNT(rows); i++) {
        played_signal = rows[i].number;
        run(crash_by_signal, NULL, NULL);
        expect_signal(rows[i].number);
        expect_output(rows[i].text);
        expect_output("minX");
    }
}

static void crash_at_25_builds(void)
{
    open_at(NULL);
    platform.null_driver.plan_fault(&(struct null_driver_fault){
        .kind = NULL_DRIVER_CRASH, .at = NULL_DRIVER_AT_BUILD, .number = 24});
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    for (uint32_t i = 0; i < 25; i++)
        scene_build_boxes(commands, 1 + i);
    scene_submit(commands);
}

TEST(test_twenty_builds_are_listed)
{
    run(crash_at_25_builds, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output("25 builds were submitted");
    expect_output("1. build of ");
    expect_output("build 23, as submitted");
    expect_output("2. build of ");
    expect_output("build 24, as submitted");
    expect_output("\n20. build of ");
    expect_no_output("\n21. build of ");
    expect_output("\nand 5 more.");
}

static void crash_without_builds(void)
{
    open_at(NULL);
    raise(SIGSEGV);
}

TEST(test_nothing_to_say)
{
    run(crash_without_builds, NULL, NULL);
    expect_signal(SIGSEGV);
    assert_string_equal(output, "");
}

/* ---- the record */

TEST(test_json)
{
    char path[] = "/tmp/assay-crash-XXXXXX", record[OUTPUT_SIZE];
    const int file = mkstemp(path);
    assert_true(file >= 0);
    setenv("VK_ASSAY_VALIDATION_LOG_FORMAT", "json", 1);
    run(crash_in_thread, "VK_ASSAY_VALIDATION_LOG_FILENAME", path);
    unsetenv("VK_ASSAY_VALIDATION_LOG_FORMAT");
    const ssize_t size = read(file, record, sizeof(record) - 1);
    assert_true(size > 0);
    record[size] = '\0';
    close(file);
    unlink(path);
    expect_signal(SIGSEGV);
    expect_output("ASSAY-crash"); /* as text, too */
    snprintf(output, sizeof(output), "%s", record);
    expect_output(
        "\"Severity\":\"Warning\",\"VUID\":\"ASSAY-crash\",\"MessageID\":\"0x22cd1989\","
        "\"Objects\":[],\"MainMessage\":\"The process received SIGSEGV for address 0x10. "
        "1 build was submitted to VkDevice ");
    expect_output("complete:\\n1. build of ");
    expect_output("\"when\":\"read when the process crashed\"");
}
