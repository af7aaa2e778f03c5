/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for bad pointers. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "case.h"

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

void *bytes_before_unreadable_page(size_t size)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t readable = (size + page - 1) / page * page;
    unsigned char *pages =
        mmap(NULL, readable + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED || mprotect(pages + readable, page, PROT_NONE) != 0)
        abort();
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
