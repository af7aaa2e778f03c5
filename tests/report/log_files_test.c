/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of log files: files that cannot be written, and the words in log_filename. */
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "hearing.h"
#include "src/report/log/lines.h"

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
    snprintf(expected, sizeof(expected), "a-%d_report_log_files_test%%%%p%%x%%", (int)getpid());
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
