/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the tables. */
#include "src/check/life/implicit.h"

#include <string.h>

#include "arguments.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"
#include "src/state/commands/query_pools.h"
#include "src/view/names.h"
#include "vuid-tables/registry.h"

#include "implicit_tables.inc"

/* What is validated now. */
struct subject_of_check {
    struct walk *walk;
    const struct call_view *call;
    struct location location;
    const char *bytes; /* of the structure, readable and aligned */
    bool is_well_formed;
    bool skips_addresses; /* a buffer may have been destroyed since */
    enum rule reported;   /* the rule of the last finding */
};

static uint64_t read_word(const char *bytes, size_t at, size_t size)
{
    uint64_t word = 0;
    memcpy(&word, bytes + at, size < sizeof(word) ? size : sizeof(word));
    return word;
}

static const void *read_pointer(const char *bytes, size_t at)
{
    return (const void *)(uintptr_t)read_word(bytes, at, sizeof(void *));
}

/* A rule that is not active makes no finding, but its mistake still hides others. */
static void report_implicit(struct subject_of_check *subject, const struct implicit_check *check,
                            struct finding *finding)
{
    struct walk *walk = subject->walk;
    const enum rule also = check->also ? (enum rule)(check->also - 1) : RULE_COUNT;
    subject->reported = check->rule;
    if (walk->active[check->rule]) {
        if (also != RULE_COUNT)
            also_violates(finding, also);
        walk_report(walk, check->rule, subject->location, finding);
    } else if (also != RULE_COUNT && walk->active[also]) {
        walk_report(walk, also, subject->location, finding);
    }
}

#define REPORT(subject, check, says, ...)                                                          \
    do {                                                                                           \
        struct finding finding;                                                                    \
        finding_says(&finding, (check)->field, says, __VA_ARGS__);                                 \
        report_implicit(subject, check, &finding);                                                 \
    } while (0)

static void report_plainly(struct subject_of_check *subject, const struct implicit_check *check,
                           const char *says)
{
    struct finding finding;
    finding_fill(&finding, check->field, says, NULL, 0);
    report_implicit(subject, check, &finding);
}

/* ---- values */

static const struct implicit_value *find_value(const struct implicit_check *check, uint64_t value)
{
    for (uint32_t i = 0; i < check->value_count; i++)
        if (check->values[i].value == value)
            return &check->values[i];
    return NULL;
}

static bool value_is_enabled(const struct device_facts *device, const struct implicit_value *value)
{
    return !value->owners || value->owners & device->owners;
}

static void check_stype(struct subject_of_check *subject, const struct implicit_check *check,
                        uint64_t value)
{
    if (value != check->value)
        REPORT(subject, check, "{} is not {}", structure_type((VkStructureType)value),
               structure_type((VkStructureType)check->value));
}

static void check_enum(struct subject_of_check *subject, const struct implicit_check *check,
                       uint64_t value)
{
    const struct device_facts *device = subject->call->device;
    const struct implicit_value *found = find_value(check, value);
    if (found ? value_is_enabled(device, found) : device->newer_than_registry)
        return;
    subject->is_well_formed = false;
    REPORT(subject, check, "{} is not a {} value of an enabled extension",
           found ? phrase(found->name) : number(value), phrase(check->type));
}

static void check_flags(struct subject_of_check *subject, const struct implicit_check *check,
                        uint64_t value)
{
    const struct device_facts *device = subject->call->device;
    uint64_t unknown = value;
    for (uint32_t i = 0; i < check->value_count && unknown; i++)
        if (value_is_enabled(device, &check->values[i]))
            unknown &= ~check->values[i].value;
    if (!unknown || device->newer_than_registry)
        return;
    subject->is_well_formed = false;
    REPORT(subject, check, "{} has bits {}, which no enabled extension defines", hex(value),
           hex(unknown));
}

static void check_zero(struct subject_of_check *subject, const struct implicit_check *check,
                       uint64_t value)
{
    if (value && !subject->call->device->newer_than_registry)
        REPORT(subject, check, "{} is not 0", hex(value));
}

static void check_length(struct subject_of_check *subject, const struct implicit_check *check,
                         uint64_t value)
{
    if (value)
        return;
    subject->is_well_formed = false;
    report_plainly(subject, check, "is 0");
}

/* ---- chains */

/* The application's structures may be misaligned. */
static VkBaseInStructure read_link(const void *s)
{
    VkBaseInStructure link;
    memcpy(&link, s, sizeof(link));
    return link;
}

static bool comes_before(const void *chain, int count, VkStructureType type)
{
    for (; count; chain = read_link(chain).pNext, count--)
        if (read_link(chain).sType == type)
            return true;
    return false;
}

static bool link_is_readable(struct subject_of_check *subject, const void *s)
{
    struct readable_cache *cache = subject->walk->context->readable;
    if (!readable(cache, s, sizeof(VkBaseInStructure)))
        return false;
    const struct registry_structure *known = registry_find_structure(read_link(s).sType);
    return !known || readable(cache, s, known->size);
}

/* A structure is identified by its sType alone, so an invalid one is a guess at the structure that
 * was meant: one of the same extension. */
static const struct implicit_value *find_meant(const struct subject_of_check *subject,
                                               const struct implicit_check *check,
                                               VkStructureType type)
{
    enum { TYPES_OF_EXTENSION = 1000 };
    for (uint32_t i = 0; i < check->value_count; i++)
        if (check->values[i].scope && value_is_enabled(subject->call->device, &check->values[i]) &&
            check->values[i].value / TYPES_OF_EXTENSION == (uint64_t)type / TYPES_OF_EXTENSION)
            return &check->values[i];
    return NULL;
}

/* Reports the sType of the structure that was meant, and names the rule of the chain if it has one.
 */
static void report_meant(struct subject_of_check *subject, const struct implicit_check *check,
                         const struct implicit_value *meant, VkStructureType type)
{
    const struct implicit_check *stype = &meant->scope->checks[0];
    struct finding finding;
    finding_says(&finding, stype->field, "{} is not {}", structure_type(type),
                 structure_type((VkStructureType)stype->value));
    if (check->field)
        also_violates(&finding, check->rule);
    report_implicit(subject, stype, &finding);
    subject->reported = check->rule;
}

static void check_link(struct subject_of_check *subject, const struct implicit_check *check,
                       const void *s)
{
    const VkStructureType type = read_link(s).sType;
    const struct device_facts *device = subject->call->device;
    const struct implicit_value *value = find_value(check, (uint64_t)type);
    if ((value && value_is_enabled(device, value)) || device->newer_than_registry)
        return;
    const struct implicit_value *meant = find_meant(subject, check, type);
    if (meant && subject->walk->active[meant->scope->checks[0].rule])
        report_meant(subject, check, meant, type);
    else if (!check->field)
        return;
    else if (!check->value_count)
        REPORT(subject, check, "{} is not NULL", hex((uint64_t)(uintptr_t)s));
    else
        REPORT(subject, check, "has a structure of type {}, which is not valid in this chain",
               structure_type(type));
}

/* Reports the first mistake only. */
static void check_chain(struct subject_of_check *subject, const struct implicit_check *check)
{
    const void *s = read_pointer(subject->bytes, check->at);
    for (int i = 0; s && i < CHAIN_MAX; i++) {
        if (!link_is_readable(subject, s)) {
            subject->is_well_formed = false;
            if (!check->field)
                return;
            REPORT(subject, check, "leads to {}, which is not readable",
                   hex((uint64_t)(uintptr_t)s));
            return;
        }
        subject->reported = RULE_COUNT;
        check_link(subject, check, s);
        if (subject->reported == check->rule)
            return;
        s = read_link(s).pNext;
    }
}

static void check_unique(struct subject_of_check *subject, const struct implicit_check *check)
{
    const void *chain = read_pointer(subject->bytes, check->at), *s = chain;
    for (int i = 0; s && i < CHAIN_MAX && link_is_readable(subject, s);
         s = read_link(s).pNext, i++) {
        const VkStructureType type = read_link(s).sType;
        if (!comes_before(chain, i, type))
            continue;
        REPORT(subject, check, "has more than one structure of type {}", structure_type(type));
        return;
    }
}

/* ---- pointers */

/* Returns false if the number cannot be read. */
static bool read_count(struct subject_of_check *subject, const struct implicit_check *check,
                       uint64_t *count)
{
    const char *bytes = subject->bytes;
    *count = check->count;
    if (!check->count_size)
        return true;
    if (check->counts_through) {
        bytes = read_pointer(bytes, check->pointer_at);
        if (!readable(subject->walk->context->readable, bytes,
                      check->count_at + (size_t)check->count_size))
            return false;
    }
    *count = read_word(bytes, check->count_at, check->count_size);
    return true;
}

/* Returns the first element that points to nothing readable, or `count`. */
static uint64_t find_unreadable(struct subject_of_check *subject,
                                const struct implicit_check *check, const char *array,
                                uint64_t count)
{
    for (uint64_t i = 0; check->pointee && i < count; i++)
        if (!readable(subject->walk->context->readable, read_pointer(array, i * sizeof(void *)),
                      check->pointee))
            return i;
    return count;
}

static void report_array(struct subject_of_check *subject, const struct implicit_check *check,
                         const void *pointer, uint64_t count)
{
    subject->is_well_formed = false;
    if (!pointer)
        report_plainly(subject, check, "is NULL");
    else if (check->is_array)
        REPORT(subject, check, "{} is not a readable array of {}",
               hex((uint64_t)(uintptr_t)pointer),
               count_of(count, check->element == 1 ? "byte" : "element"));
    else
        REPORT(subject, check, "{} is not readable", hex((uint64_t)(uintptr_t)pointer));
}

/* Returns the array, or NULL if it is empty or not readable. */
static const char *check_pointer(struct subject_of_check *subject,
                                 const struct implicit_check *check, uint64_t *count)
{
    const char *pointer = read_pointer(subject->bytes, check->at);
    uint64_t size;
    if (!read_count(subject, check, count) || !*count || (!pointer && check->is_optional))
        return NULL;
    bool overflows = __builtin_mul_overflow(*count, check->element, &size);
    if (overflows || !readable(subject->walk->context->readable, pointer, (size_t)size)) {
        report_array(subject, check, pointer, *count);
        return NULL;
    }
    uint64_t first = find_unreadable(subject, check, pointer, *count);
    if (first == *count)
        return pointer;
    subject->is_well_formed = false;
    REPORT(subject, check, "has an element {}, which is not a readable pointer: {}", number(first),
           hex((uint64_t)(uintptr_t)read_pointer(pointer, first * sizeof(void *))));
    return NULL;
}

static void check_address(struct subject_of_check *subject, const struct implicit_check *check,
                          uint64_t address)
{
    const struct check_context *context = subject->walk->context;
    struct address_facts facts;
    if (context->level < LEVEL_STATE || (!address && check->is_optional) ||
        subject->skips_addresses)
        return;
    resources_look_up_address(context->resources, address, &facts);
    if (facts.status == ADDRESS_NULL)
        report_plainly(subject, check, "is 0");
    else if (facts.status == ADDRESS_NOWHERE)
        REPORT(subject, check, "{} is in no buffer whose address was retrieved",
               address_of_missing(VK_OBJECT_TYPE_BUFFER, address));
}

/* ---- objects */

struct object_state {
    enum tristate alive;
    bool of_another_device;
};

static struct object_state find_object(struct subject_of_check *subject, VkObjectType type,
                                       uint64_t handle)
{
    static const struct {
        VkObjectType type;
        enum resource_kind kind;
    } kinds[] = {{VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, RESOURCE_ACCEL},
                 {VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, RESOURCE_ACCEL_NV},
                 {VK_OBJECT_TYPE_BUFFER, RESOURCE_BUFFER},
                 {VK_OBJECT_TYPE_MICROMAP_EXT, RESOURCE_MICROMAP},
                 {VK_OBJECT_TYPE_DEVICE_MEMORY, RESOURCE_MEMORY}};
    struct check_context *context = subject->walk->context;
    struct object_state state = {UNKNOWN, false};
    enum resource_kind kind = RESOURCE_QUERY_POOL;
    for (size_t i = 0; i < sizeof(kinds) / sizeof(kinds[0]); i++)
        if (kinds[i].type == type) {
            kind = kinds[i].kind;
            state.alive = resources_has(context->resources, kind, handle);
        }
    if (type == VK_OBJECT_TYPE_QUERY_POOL) {
        struct query_pool_facts facts;
        query_pools_facts(context->query_pools, (VkQueryPool)(uintptr_t)handle, &facts);
        state.alive = facts.alive;
    }
    if (state.alive == NO)
        state.of_another_device = context->hooks->of_another_device(context->user, kind, handle);
    return state;
}

/* A handle of an extension or feature that is off is a mistake with an id of its own, whose message
 * names the id of the handle, too. */
static bool is_reported_as_off(const struct subject_of_check *subject,
                               const struct implicit_check *check)
{
    const struct device_facts *device = subject->call->device;
    const bool *active = subject->walk->active;
    switch ((int)check->rule) {
    case RULE_VkAccelerationStructureCaptureDescriptorDataInfoEXT_accelerationStructure_parameter:
        return !device->acceleration_structure && active[RULE_captured_structure_has_its_feature];
    case RULE_VkAccelerationStructureCaptureDescriptorDataInfoEXT_accelerationStructureNV_parameter:
        return !device->extension.ray_tracing_nv &&
               active[RULE_captured_nv_structure_has_its_extension];
    default:
        return false;
    }
}

static void check_object(struct subject_of_check *subject, const struct implicit_check *check,
                         uint64_t handle)
{
    const VkObjectType type = (VkObjectType)check->value;
    const bool is_parent = check->kind == IMPLICIT_PARENT;
    if (!handle) {
        if (!(check->is_pointer ? check->elements_are_optional : check->is_optional) && !is_parent)
            report_plainly(subject, check, "is VK_NULL_HANDLE");
        return;
    }
    if (is_reported_as_off(subject, check))
        return;
    const struct object_state state = find_object(subject, type, handle);
    if (state.alive != NO || state.of_another_device != is_parent)
        return;
    if (is_parent)
        REPORT(subject, check, "{} was created from another VkDevice", object(type, handle));
    else
        REPORT(subject, check, "{} is not a {} of this device: it was destroyed or never created",
               destroyed_object(type, handle, 0), phrase(check->type));
}

/* A command reports one of several objects that were created from another device. */
static void check_objects(struct subject_of_check *subject, const struct implicit_check *check)
{
    uint64_t count;
    if (subject->walk->context->level < LEVEL_STATE ||
        (check->kind == IMPLICIT_PARENT && subject->reported == check->rule))
        return;
    if (!check->is_pointer) {
        check_object(subject, check, read_word(subject->bytes, check->at, check->size));
        return;
    }
    const bool is_parent = check->kind == IMPLICIT_PARENT;
    const char *handles = read_pointer(subject->bytes, check->at);
    if (is_parent ? !read_count(subject, check, &count) ||
                        !readable(subject->walk->context->readable, handles,
                                  (size_t)count * check->element)
                  : !(handles = check_pointer(subject, check, &count)))
        return;
    for (uint64_t i = 0; i < count && subject->walk->active[check->rule]; i++) {
        subject->location.geometry = (uint32_t)i;
        check_object(subject, check, read_word(handles, i * check->element, check->element));
    }
}

/* ---- one structure */

static void evaluate_word(struct subject_of_check *subject, const struct implicit_check *check)
{
    const uint64_t value = read_word(subject->bytes, check->at, check->size);
    switch ((int)check->kind) {
    case IMPLICIT_STYPE:
        check_stype(subject, check, value);
        break;
    case IMPLICIT_ENUM:
        check_enum(subject, check, value);
        break;
    case IMPLICIT_FLAGS:
        check_flags(subject, check, value);
        break;
    case IMPLICIT_ZERO:
        check_zero(subject, check, value);
        break;
    case IMPLICIT_ADDRESS:
        check_address(subject, check, value);
        break;
    default:
        check_length(subject, check, value);
        break;
    }
}

/* Whether a member of a union counts. */
static bool is_selected(const struct subject_of_check *subject, uint32_t selections, size_t at)
{
    uint32_t selector;
    memcpy(&selector, subject->bytes + at, sizeof(selector));
    return selector < 32 && selections >> selector & 1;
}

static void evaluate(struct subject_of_check *subject, const struct implicit_check *check)
{
    uint64_t count;
    if (check->selections && !is_selected(subject, check->selections, check->selector_at))
        return;
    switch ((enum implicit_kind)check->kind) {
    case IMPLICIT_CHAIN:
        check_chain(subject, check);
        break;
    case IMPLICIT_UNIQUE:
        check_unique(subject, check);
        break;
    case IMPLICIT_POINTER:
        check_pointer(subject, check, &count);
        break;
    case IMPLICIT_HANDLE:
    case IMPLICIT_PARENT:
        check_objects(subject, check);
        break;
    case IMPLICIT_QUEUES:
        if (!subject->call->device->has_queues)
            report_plainly(subject, check, "was created without a queue");
        break;
    default:
        evaluate_word(subject, check);
        break;
    }
}

static void check_chained(struct subject_of_check *subject, const struct implicit_check *check,
                          const void *chain);
static void check_visit(struct subject_of_check *subject, const struct implicit_visit *visit);

static void check_scope(struct subject_of_check *subject, const struct implicit_scope *scope)
{
    subject->reported = RULE_COUNT;
    for (uint32_t i = 0; i < scope->check_count; i++) {
        evaluate(subject, &scope->checks[i]);
        if (scope->checks[i].kind == IMPLICIT_CHAIN)
            check_chained(subject, &scope->checks[i],
                          read_pointer(subject->bytes, scope->checks[i].at));
    }
    for (uint32_t i = 0; i < scope->visit_count; i++)
        check_visit(subject, &scope->visits[i]);
}

/* Validates the structures of a chain that have ids. */
static void check_chained(struct subject_of_check *subject, const struct implicit_check *check,
                          const void *chain)
{
    struct subject_of_check chained = *subject;
    const void *s = chain;
    for (int i = 0; s && i < CHAIN_MAX && link_is_readable(subject, s);
         s = read_link(s).pNext, i++) {
        const VkStructureType type = read_link(s).sType;
        const struct implicit_value *value = find_value(check, (uint64_t)type);
        if (!value || !value->scope || comes_before(chain, i, type))
            continue;
        chained.bytes = s;
        check_scope(&chained, value->scope);
    }
    subject->is_well_formed &= chained.is_well_formed;
}

static void check_visit(struct subject_of_check *subject, const struct implicit_visit *visit)
{
    struct subject_of_check structure = *subject;
    struct check_context *context = subject->walk->context;
    const char *pointer = read_pointer(subject->bytes, visit->at);
    uint32_t count =
        visit->is_array ? (uint32_t)read_word(subject->bytes, visit->count_at, sizeof(count)) : 1;
    if (!count || !readable(context->readable, pointer, (size_t)count * visit->scope->size) ||
        (visit->selections && !is_selected(subject, visit->selections, visit->selector_at)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        structure.location = visit->is_array ? check_element(subject->call, visit->parameter, i)
                                             : check_argument(subject->call, visit->parameter);
        structure.bytes = pointer + (size_t)i * visit->scope->size;
        check_scope(&structure, visit->scope);
    }
    subject->is_well_formed &= structure.is_well_formed;
}

bool check_implicit(struct walk *walk, const struct call_view *call)
{
    const struct implicit_scope *scope = scope_of_command[call->command];
    struct subject_of_check subject = {.walk = walk,
                                       .call = call,
                                       .location = check_argument(call, NULL),
                                       .bytes = call->arguments,
                                       .is_well_formed = true};
    if (!scope)
        return true;
    check_scope(&subject, scope);
    return subject.is_well_formed;
}

void check_implicit_descriptor(struct walk *walk, const struct call_view *call,
                               const struct location *location, const void *chain)
{
    struct subject_of_check subject = {
        .walk = walk, .call = call, .location = *location, .is_well_formed = true};
    subject.bytes = (const char *)&chain;
    check_chain(&subject, &chain_of_descriptors);
    check_chained(&subject, &chain_of_descriptors, chain);
}

void check_implicit_read(struct walk *walk, const struct call_view *call,
                         const struct location *location, const char *name, const void *bytes,
                         bool addresses_are_known)
{
    struct subject_of_check subject = {.walk = walk,
                                       .call = call,
                                       .location = *location,
                                       .bytes = bytes,
                                       .is_well_formed = true,
                                       .skips_addresses = !addresses_are_known};
    for (size_t i = 0; i < sizeof(scopes_in_device_memory) / sizeof(scopes_in_device_memory[0]);
         i++)
        if (strcmp(scopes_in_device_memory[i].name, name) == 0)
            check_scope(&subject, scopes_in_device_memory[i].scope);
}
