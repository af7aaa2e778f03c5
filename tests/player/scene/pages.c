/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for bad pointers. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "tests/player/scene/placing.h"

void *unreadable_page(void)
{
    static void *page;
    if (page == NULL)
        page = mmap(NULL, (size_t)sysconf(_SC_PAGESIZE), PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                    0);
    if (page == MAP_FAILED)
        abort();
    return page;
}

enum { RESERVED = 1 << 28 };

/* The unreadable pages never were anything else: for some milliseconds the layer believes that a
 * page is still readable which was (src/base/readable.h). */
void *bytes_before_unreadable_page(size_t size)
{
    static unsigned char *reserved;
    static size_t left;
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t readable = (size + page - 1) / page * page;
    if (left < readable + page) {
        left = RESERVED;
        reserved = mmap(NULL, left, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    }
    unsigned char *pages = reserved;
    if (reserved == MAP_FAILED || mprotect(pages, readable, PROT_READ | PROT_WRITE) != 0)
        abort();
    reserved += readable + page;
    left -= readable + page;
    return pages + readable - size;
}

void put_at_edge(struct scene *scene, void *pointer, size_t size)
{
    (void)scene;
    void *copy = bytes_before_unreadable_page(size);
    const void *from;
    memcpy(&from, pointer, sizeof(from));
    memcpy(copy, from, size);
    memcpy(pointer, &copy, sizeof(copy));
}
