/* SPDX-License-Identifier: Apache-2.0 */
/* json_writer [PROCESSES THREADS]: writes lines of JSON for schema_test.py, which sets log_format
 * and log_filename: objects, labels, modules, drivers and applications with names that break a
 * careless writer; or findings with these names by so many processes at the same time, each of so
 * many threads. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/report/reporter.h"
#include "src/state/commands/call_sites.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/object_names.h"
#include "tests/fixture/make.h"

enum { LONG_NAME = 10000, THREADS_MAX = 8, SENT_BY_THREAD = 200 };

static char long_name[LONG_NAME + 1], long_controls[LONG_NAME + 1], long_emoji[LONG_NAME + 1];

static const char *const nasty_names[] = {
    "",
    "\"",
    "\\",
    "\\\"}{][,:",
    "a\nb\r\tc",
    "\x01\x02\x1b[31m\x1f\x7f",
    "\xff\xfe",
    "\xc0\xaf",         /* an overlong / */
    "\xed\xa0\x80",     /* half of a surrogate pair */
    "\xf4\x90\x80\x80", /* beyond Unicode */
    "cut \xf0\x9f\x98",
    "\xf0\x9f\x98\x80 emoji \xf0\x9f\x91\xa9\xe2\x80\x8d\xf0\x9f\x92\xbb",
    "\xe2\x80\xa8 line, \xe2\x80\xae reversed",
    "</script><!--",
    "%s%n%p",
    "a::b > c",
    long_name,
    long_controls,
    long_emoji,
};

enum { NAMES = sizeof(nasty_names) / sizeof(nasty_names[0]) };

static void fill_long_names(void)
{
    memset(long_name, 'x', LONG_NAME);
    memset(long_controls, '\x01', LONG_NAME);
    for (int i = 0; i + 4 <= LONG_NAME; i += 4)
        memcpy(long_emoji + i, "\xf0\x9f\x98\x80", 4);
}

static struct reporter *begin(const char *application)
{
    const STRUCT(VkApplicationInfo, info, .pApplicationName = application,
                 .pEngineName = application, .apiVersion = VK_API_VERSION_1_3);
    const STRUCT(VkInstanceCreateInfo, create_info, .pApplicationInfo = &info);
    struct reporter *reporter;
    if (reporter_create(&create_info, &reporter) != VK_SUCCESS)
        exit(1);
    return reporter;
}

/* Sends a finding with three objects, as many labels as a message has, and two modules, all of this
 * name. */
static void send_named(struct reporter *reporter, const char *name)
{
    struct object_names *names;
    struct label_stack labels = {0};
    struct shared_labels queue_labels = {0};
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = name);
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    const struct call_site site = {3, {{name, UINT64_MAX}, {NULL, 0}, {name, 1}}};
    struct finding finding;
    finding_says(&finding, "scratchData.deviceAddress", "{} is wrong, and {} and {}",
                 object(VK_OBJECT_TYPE_BUFFER, 1), object(VK_OBJECT_TYPE_DEVICE_MEMORY, 1),
                 object(VK_OBJECT_TYPE_MICROMAP_EXT, 1));
    if (object_names_create(&names) != VK_SUCCESS)
        exit(1);
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 1, name);
    object_names_set(names, VK_OBJECT_TYPE_DEVICE_MEMORY, 1, name);
    object_names_set(names, VK_OBJECT_TYPE_MICROMAP_EXT, 1, name);
    for (int i = 0; i < 20; i++) {
        label_stack_push(&labels, &label);
        label_stack_push(&queue_labels.stack, &label);
    }
    reporter_send(
        reporter, RULE_scratch_address_is_aligned, &location,
        &(struct call_origin){
            .device = (VkDevice)(uintptr_t)0xd,
            .command_buffer = (VkCommandBuffer)(uintptr_t)0xc,
            .build_index = 3,
            .submission = {.queue = (VkQueue)(uintptr_t)0xe, .number = 7, .labels = &queue_labels},
            .names = names,
            .labels = &labels,
            .call_site = &site,
        },
        &finding);
    label_stack_clear(&labels);
    label_stack_clear(&queue_labels.stack);
    object_names_destroy(names);
}

static void write_names(void)
{
    for (int i = 0; i < NAMES; i++) {
        struct reporter *reporter = begin(nasty_names[i]);
        STRUCT(VkPhysicalDeviceDriverProperties, driver);
        snprintf(driver.driverName, sizeof(driver.driverName), "%s", nasty_names[i]);
        snprintf(driver.driverInfo, sizeof(driver.driverInfo), "%s", nasty_names[i]);
        reporter_add_device(reporter, (VkDevice)(uintptr_t)0xd, nasty_names[i], &driver);
        send_named(reporter, nasty_names[i]);
        reporter_warn(reporter, nasty_names[i]);
        reporter_add_unchecked(reporter, nasty_names[i], 1);
        reporter_destroy(reporter);
    }
}

static void *write_thread(void *reporter)
{
    for (int i = 0; i < SENT_BY_THREAD; i++)
        send_named(reporter, nasty_names[i % NAMES]);
    return NULL;
}

static void write_process(int thread_count)
{
    struct reporter *reporter = begin("one of many");
    pthread_t threads[THREADS_MAX];
    for (int i = 0; i < thread_count && i < THREADS_MAX; i++)
        if (pthread_create(&threads[i], NULL, write_thread, reporter) != 0)
            _exit(1);
    for (int i = 0; i < thread_count && i < THREADS_MAX; i++)
        pthread_join(threads[i], NULL);
    reporter_destroy(reporter);
}

int main(int count, char **arguments)
{
    const int processes = count == 3 ? atoi(arguments[1]) : 0;
    int status = 0;
    fill_long_names();
    if (!processes)
        write_names();
    for (int i = 0; i < processes; i++)
        if (fork() == 0) {
            write_process(atoi(arguments[2]));
            return 0;
        }
    for (int i = 0; i < processes && !status; i++)
        if (wait(&status) < 0)
            return 1;
    return status != 0;
}
