/* SPDX-License-Identifier: Apache-2.0 */
/* Finds modules in the list of the dynamic linker. */
#define _GNU_SOURCE /* dl_iterate_phdr */
#include "src/platform/modules.h"

#include <elf.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/platform/call_instruction.h"

/* ---- symbols */

/* The dynamic symbols of a module. */
struct symbols {
    const ElfW(Sym) * symbols;
    const char *names;
    const uint32_t *hash; /* DT_GNU_HASH */
};

/* The dynamic linker adds the load address to these pointers, except in sections that are
 * read-only. */
static const void *dynamic_pointer(const struct dl_phdr_info *info, const ElfW(Dyn) * entry)
{
    uintptr_t address = entry->d_un.d_ptr;
    return (const void *)(address < info->dlpi_addr ? address + info->dlpi_addr : address);
}

static bool find_symbols(const struct dl_phdr_info *info, struct symbols *found)
{
    const ElfW(Dyn) *entry = NULL;
    *found = (struct symbols){NULL, NULL, NULL};
    for (unsigned i = 0; i < info->dlpi_phnum; i++)
        if (info->dlpi_phdr[i].p_type == PT_DYNAMIC)
            entry = (const ElfW(Dyn) *)(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr);
    for (; entry && entry->d_tag != DT_NULL; entry++) {
        if (entry->d_tag == DT_SYMTAB)
            found->symbols = dynamic_pointer(info, entry);
        else if (entry->d_tag == DT_STRTAB)
            found->names = dynamic_pointer(info, entry);
        else if (entry->d_tag == DT_GNU_HASH)
            found->hash = dynamic_pointer(info, entry);
    }
    return found->symbols && found->names && found->hash;
}

static uint32_t hash_of(const char *name)
{
    uint32_t hash = 5381;
    for (; *name; name++)
        hash = hash * 33 + (unsigned char)*name;
    return hash;
}

/* Whether a module defines a function of that name. The table is laid out as: the number of
 * buckets, the first symbol in it, the words of its filter, a shift; the filter; the buckets; the
 * hashes of the symbols. The last hash of a bucket is odd. */
static bool defines_function(const struct symbols *symbols, const char *name)
{
    uint32_t bucket_count = symbols->hash[0], first = symbols->hash[1];
    const uint32_t *buckets = symbols->hash + 4 + symbols->hash[2] * (sizeof(ElfW(Addr)) / 4);
    const uint32_t *hashes = buckets + bucket_count;
    uint32_t hash = hash_of(name);
    uint32_t i = bucket_count ? buckets[hash % bucket_count] : 0;
    if (i < first || i == 0)
        return false;
    for (;; i++) {
        const ElfW(Sym) *symbol = &symbols->symbols[i];
        if ((hashes[i - first] | 1) == (hash | 1) &&
            strcmp(symbols->names + symbol->st_name, name) == 0)
            return (symbol->st_info & 0xf) == STT_FUNC && symbol->st_shndx != SHN_UNDEF;
        if (hashes[i - first] & 1)
            return false;
    }
}

static bool defines(const struct dl_phdr_info *info, const char *function)
{
    struct symbols symbols;
    return find_symbols(info, &symbols) && defines_function(&symbols, function);
}

/* ---- modules */

struct search {
    uintptr_t address;
    struct module_place *place;
    unsigned modules; /* seen before */
};

/* Returns the segment with code at an address, or NULL. */
static const ElfW(Phdr) * find_code(const struct dl_phdr_info *info, uintptr_t address)
{
    for (unsigned i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *segment = &info->dlpi_phdr[i];
        if (segment->p_type == PT_LOAD && segment->p_flags & PF_X &&
            address - info->dlpi_addr - segment->p_vaddr < segment->p_memsz)
            return segment;
    }
    return NULL;
}

/* The first module is the program, which has no name in the list. */
static void find_path(const struct dl_phdr_info *info, bool is_program, char path[MODULE_PATH_SIZE])
{
    ssize_t length = is_program ? readlink("/proc/self/exe", path, MODULE_PATH_SIZE - 1) : -1;
    if (length >= 0)
        path[length] = '\0';
    else if (info->dlpi_name[0] == '/' || !realpath(info->dlpi_name, path))
        snprintf(path, MODULE_PATH_SIZE, "%s", info->dlpi_name);
}

static int visit(struct dl_phdr_info *info, size_t size, void *user)
{
    struct search *search = user;
    struct module_place *place = search->place;
    const ElfW(Phdr) *segment = find_code(info, search->address);
    (void)size;
    if (!segment) {
        search->modules++;
        return 0;
    }
    const unsigned char *code = (const unsigned char *)(info->dlpi_addr + segment->p_vaddr);
    find_path(info, search->modules == 0, place->path);
    place->offset = search->address - info->dlpi_addr;
    place->is_layer = defines(info, "vkNegotiateLoaderLayerInterfaceVersion");
    place->is_vulkan = place->is_layer || defines(info, "vkGetInstanceProcAddr");
    place->follows_call =
        !(segment->p_flags & PF_R) || follows_call(code, (const unsigned char *)search->address);
    return 1;
}

bool module_find(uintptr_t address, struct module_place *place)
{
    struct search search = {.address = address, .place = place};
    return dl_iterate_phdr(visit, &search) != 0;
}
