# SPDX-License-Identifier: Apache-2.0
"""Writes, for backend cpu, what translates the stages and accesses of ray tracing in a call for a driver
without ray tracing (layer/cpu/driver/masks.h). The registry says where a call has them: in parameters, and in
structures of arrays and of chains, of which the driver gets copies."""

import re

STAGES = {"VkPipelineStageFlags", "VkPipelineStageFlags2", "VkPipelineStageFlagBits", "VkPipelineStageFlagBits2"}
ACCESSES = {"VkAccessFlags", "VkAccessFlags2"}
# The stages of an access are those of its structure, or else parameters of the command with these names.
OF_COMMAND = (", VkPipelineStageFlags2 srcStageMask, VkPipelineStageFlags2 dstStageMask",
              ", srcStageMask, dstStageMask")


class Masks:
    def __init__(self, registry):
        self.structures = registry.structures
        self.known = {}  # whether a structure leads to masks
        self.texts = {}  # the functions of structures, each behind those that it calls

    def leads_to_masks(self, name):
        if name not in self.known and name in self.structures:
            self.known[name] = False  # for structures that lead to themselves
            self.known[name] = any(self.is_translated(member) or (
                member.name == "pNext" and self.chained(name)) for member in self.structures[name].members)
        return self.known.get(name)

    def is_translated(self, member):
        return member.type in STAGES | ACCESSES or (
            member.pointers and member.is_const and self.leads_to_masks(member.type))

    def chained(self, name):
        """The structures with masks that extend a structure."""
        return sorted({s.name for s in self.structures.values()
                       if name in s.extends and s.name != name and self.leads_to_masks(s.name)})

    def extra(self, name, form):
        """The parameters or arguments of functions for a structure with accesses that has no stages."""
        types = {member.type for member in self.structures[name].members}
        return OF_COMMAND[form] if types & ACCESSES and not types & STAGES else ""

    def member(self, member, members, prefix):
        """A condition, the size of copies, and the translated value of a member or parameter."""
        place, count = prefix + member.name, member.length(prefix, members) or "1"
        if member.type in STAGES and member.pointers:
            return (f"stages_of_array_trace({place}, {count})", f"block_size({count}, sizeof(*{place}))",
                    f"stages_of_array_below(block, {place}, {count})")
        if member.type in STAGES:
            return f"stages_trace({place})", None, f"({member.type})stages_below({place})"
        if member.type in ACCESSES:
            stages = member.name.replace("Access", "Stage")
            own = prefix if any(other.name == stages for other in members) else ""
            return f"accesses_trace({place})", None, f"({member.type})accesses_below({own}{stages}, {place})"
        self.write(member.type)
        return (f"{member.type}_traces({place}, {count})", f"{member.type}_room({place}, {count})",
                f"{member.type}_below(block, {place}, {count}{self.extra(member.type, 1)})")

    def write(self, name):
        """Writes the functions of a structure."""
        if name in self.texts:
            return
        members = self.structures[name].members
        translated = [(m.name, *self.member(m, members, "s->")) for m in members if self.is_translated(m)]
        # Accesses depend on the stages, which therefore come last.
        translated.sort(key=lambda one: "stages_below" in one[3])
        conditions = [condition for _, condition, _, _ in translated]
        rooms = [room for _, _, room, _ in translated if room]
        lines = [f"s->{member} = {value};" for member, _, _, value in translated]
        for chained in self.chained(name) if self.structures[name].has_chain else []:
            self.write(chained)
            kind = self.structures[chained].type
            found = f"chain_find(s->pNext, {kind})"
            size = f"chain_copy_size(s->pNext, {kind})"
            conditions.append(f"({found} && {chained}_traces({found}, 1))")
            rooms.append(f"block_size(1, {size}) + ({found} ? {chained}_room({found}, 1) : 0)")
            lines += [f"chain_copy_to(&copy, s->pNext, {kind}, block_take(block, 1, {size}));",
                      "s->pNext = copy.first;", "if (copy.found)",
                      f"    {chained}_translate(block, copy.found);"]
        def each(text):
            return re.sub(r"\bs->", "all[i].", text)
        copy = ["struct chain_copy copy;"] if "chain_copy_to" in "".join(lines) else []
        self.texts[name] = f"""
static inline bool {name}_traces(const {name} *all, uint32_t count)
{{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = {each(" || ".join(conditions))};
    return found;
}}

static inline size_t {name}_room(const {name} *all, uint32_t count)
{{
    size_t size = block_size(count, sizeof(*all));
    for (uint32_t i = 0; i < count; i++)
        size += {each(" + ".join(rooms) or "0")};
    return size;
}}

static inline void {name}_translate(struct block *block, {name} *s{self.extra(name, 0)})
{{
{"".join(f"    {line}" + chr(10) for line in copy + lines)}}}

static inline {name} *{name}_below(struct block *block, const {name} *all, uint32_t count{self.extra(name, 0)})
{{
    {name} *below = block_copy(block, all, count, sizeof(*all));
    for (uint32_t i = 0; i < count; i++)
        {name}_translate(block, &below[i]{self.extra(name, 1)});
    return below;
}}
"""

    def call(self, command):
        """The lines that call `down`. A call without such masks goes down unchanged; if memory runs out, so
        does a call that cannot fail."""
        translated = {p.name: self.member(p, command.parameters, "")
                      for p in command.parameters if self.is_translated(p)}
        conditions = " || ".join(condition for condition, _, _ in translated.values())
        rooms = " + ".join(room for _, room, _ in translated.values() if room)
        values = [translated[p.name][2] if p.name in translated else p.name for p in command.parameters]
        down, unchanged = f"down({', '.join(values)})", f"down({command.arguments})"
        if not rooms:
            yield f"{down};"
        elif command.returns == "void":
            yield "struct block memory, *block = &memory;"
            yield f"bool is_translated = ({conditions}) && block_begin(block, {rooms});"
            yield f"if (is_translated) {{ {down}; block_end(block); }}"
            yield f"else {{ {unchanged}; }}"
        else:
            yield "struct block memory, *block = &memory;"
            yield f"if (!({conditions}))"
            yield f"    return {unchanged};"
            yield f"if (!block_begin(block, {rooms}))"
            yield "    return VK_ERROR_OUT_OF_HOST_MEMORY;"
            yield f"{command.returns} result = {down};"
            yield "block_end(block);"
            yield "return result;"
