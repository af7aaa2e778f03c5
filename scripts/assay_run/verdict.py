# SPDX-License-Identifier: Apache-2.0
"""What a run amounts to: the summary and the exit status."""

import signal
from collections import Counter

from .call_sites import frames_of_application, place_of
from .groups import group_findings, identity, repetition_lines
from .last_state import last_state_lines
from .properties import COUNTS
from .records import is_advice

NOT_LOADED = 98  # exit status if a run has not loaded the layer in any process
DAMAGED = 97     # exit status if a record is damaged, so that it may miss findings
FRAMES_SHOWN = 4  # of a call site, in text


class Verdict:
    """The findings of a run, without those that the baseline knows."""

    def __init__(self, record, new, known, entries=(), is_strict=False):
        self.record, self.new, self.known = record, new, known
        self.new_groups, self.known_groups = group_findings(new), group_findings(known)
        self.unused_entries = [entry for entry in entries if not entry.used]
        self.wide_entries = [entry for entry in entries if entry.carriers]
        self.is_strict = is_strict
        self.expected_groups, self.absent = [], []
        self.status = 0  # of the application: a negative one is the signal that ended it
        self.is_stopped = False  # the first finding has ended the run

    def expect(self, expected, absent):
        """Adds the findings that the application announced. `absent`: those that did not come."""
        self.expected_groups, self.absent = group_findings(expected), absent

    @property
    def is_loaded(self):
        return self.record.is_loaded and not self.record.runs_without_khronos()

    @property
    def is_whole(self):
        return not self.record.damaged and not self.record.unfinished_runs()


def plural(count, noun, nouns=None):
    return f"{count:,} {noun if count == 1 else nouns or noun + 's'}"


def describe_exit(status):
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        return f"the application was ended by {name}"
    return f"the application's exit status is {status}"


def call_site_lines(finding):
    """Returns lines that name the first callers: where the source is known, if there is any."""
    return [f"{'from' if i else 'at'} {place_of(frame)}"
            for i, frame in enumerate(frames_of_application(finding)[:FRAMES_SHOWN])]


def command_lines(finding):
    """Returns a line that says which command a finding is about, and where it was recorded and submitted."""
    function = finding.get("Function", "")
    parts = [] if not function or finding["MainMessage"].startswith(function) else [f"{function}()"]
    buffers = [item for item in finding.get("Objects", []) if item["type"] == "VkCommandBuffer"]
    if buffers:
        name = f" \"{buffers[0]['name']}\"" if buffers[0].get("name") else ""
        parts.append(f"VkCommandBuffer {buffers[0]['handle']}{name}")
    parts += [f"{word} {finding[word]}" for word in COUNTS if word in finding]
    if finding.get("DebugRegion"):
        parts.append(f"labels {finding['DebugRegion']}")
    return [f"in {', '.join(parts)}"] if function and parts else []


def group_lines(group):
    """Returns the lines that describe a mistake."""
    finding = group.first
    return [f"{finding['Severity']}: {group.title}",
            *(f"  {line}" for line in finding["MainMessage"].splitlines()),
            *(f"  {line}" for line in command_lines(finding)),
            *(f"  {line}" for line in call_site_lines(finding)),
            *(f"  {line}" for line in repetition_lines(group))]


def total_line(verdict):
    record = verdict.record
    text = plural(len(verdict.new_groups), "finding")
    notes = []
    if len(verdict.new) > len(verdict.new_groups):
        notes.append(f"reported {len(verdict.new):,} times")
    khronos = sum(bool(group.first.get("Layer")) for group in verdict.new_groups)
    if khronos:
        notes.append(f"{khronos:,} by the Khronos layer only")
    held_back = sum(count for name, count in record.held_back().items()
                    if record.advice_is_error or not is_advice({"VUID": name}))
    if held_back:
        notes.append(f"{plural(held_back, 'duplicate')} not reported")
    elif record.may_lack_repetitions():
        notes.append("perhaps found more often: a VkInstance was not destroyed")
    if notes:
        text += f" ({', '.join(notes)})"
    text += f" in {plural(len(record.processes), 'process', 'processes')}"
    if verdict.known:
        text += f"; {plural(len(verdict.known_groups), 'known finding')}"
    if verdict.expected_groups:
        text += f"; {plural(len(verdict.expected_groups), 'expected finding')}"
    if record.warnings():
        text += f"; {plural(len(record.warnings()), 'warning')}"
    if record.advice():
        text += f"; {plural(len(record.advice()), 'piece', 'pieces')} of advice"
    return text


def mistake_lines(verdict):
    """Returns what keeps the run from being judged, which is said even with --quiet."""
    record = verdict.record
    lines = [f"{folder}: the layer was not loaded" for folder in record.runs_without_layer()
             if len(record.runs) > 1]
    if not record.is_loaded and not lines:
        lines = ["the layer was not loaded: no process has created a VkInstance, which needs a Vulkan driver "
                 "(--lavapipe runs on Mesa's CPU driver), or the loader has not found the layer "
                 "(VK_LOADER_DEBUG=layer shows what it does)"]
    lines += [f"{folder + ': ' if len(record.runs) > 1 else ''}the Khronos layer was not loaded, or has not "
              "written to its log" for folder in record.runs_without_khronos()]
    if len(record.runs) > 1 or not record.headers:
        lines += [f"{folder}: the run was cut off" for folder in record.unfinished_runs()]
    if record.damaged:
        lines.append(f"{record.damaged[0]}: this was not written whole: is the disk full? Findings may "
                     "be missing")
    return lines


def note_lines(what, findings):
    """Returns the messages that do not count, each once."""
    lines = []
    for text, layer in dict.fromkeys((finding["MainMessage"], finding.get("Layer")) for finding in findings):
        first, *others = text.splitlines() or [""]
        lines += [f"{what}{f' ({layer} layer)' if layer else ''}: {first}", *(f"  {line}" for line in others)]
    return lines


def summary_lines(verdict, printed=()):
    """Returns the lines of the summary. `printed` has the identities of the findings that were printed
    while the application ran."""
    record = verdict.record
    lines = []
    for group in verdict.new_groups:
        if identity(group.first) not in printed:
            lines += group_lines(group)
        elif group.count > 1:
            lines += [f"{group.first['VUID']}:", *(f"  {line}" for line in repetition_lines(group))]
    for name, count in Counter(finding["VUID"] for finding in verdict.new).most_common():
        lines.append(f"{count:6,}  {name}")
    if record.headers:
        lines.append(total_line(verdict))
    lines += note_lines("warning", record.warnings()) + note_lines("advice", record.advice())
    lines += last_state_lines(record) if record.follows_advice() else []
    lines += [f"not checked: {reason}" for reason in
              dict.fromkeys(reason for summary in record.summaries
                            for reason in summary.get("Unchecked", []))]
    lines += [one.text for one in verdict.absent]
    for entry in verdict.wide_entries:
        lines.append(f"{entry.path}:{entry.line}: mutes {entry.id} wherever it arises in "
                     f"{min(entry.carriers)}; name an object, a label or a function instead")
    for entry in verdict.unused_entries:
        lines.append(f"{entry.path}:{entry.line}: matches no finding any more: {entry.text}")
    if verdict.status:
        lines.append(describe_exit(verdict.status))
    if verdict.is_stopped:
        later = len(verdict.new) - 1
        lines.append("the first finding has ended the run (--stop-at-first)" +
                     (f"; {later:,} more came before the application had ended" if later > 0 else ""))
    return lines


def exit_status(verdict, error_exitcode):
    """Returns the exit status of the run. A negative one is a signal, to be passed on."""
    if verdict.status < 0:
        return verdict.status
    if verdict.new or verdict.absent or (verdict.is_strict and verdict.unused_entries):
        return error_exitcode
    if not verdict.is_loaded:
        return NOT_LOADED
    if not verdict.is_whole:
        return DAMAGED
    return verdict.status
