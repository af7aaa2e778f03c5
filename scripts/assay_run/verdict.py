# SPDX-License-Identifier: Apache-2.0
"""What a run amounts to: the summary and the exit status."""

import signal
from collections import Counter

NOT_LOADED = 98  # exit status if no process has loaded the layer


class Verdict:
    """The findings of a run, without those that the baseline knows."""

    def __init__(self, record, new, known, unused_entries):
        self.record, self.new, self.known = record, new, known
        self.unused_entries = unused_entries

    @property
    def is_loaded(self):
        return bool(self.record.headers)


def plural(count, noun):
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def describe_exit(status):
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        return f"the application was ended by {name}"
    return f"the application's exit status is {status}"


def finding_lines(finding):
    """Returns the lines that describe a finding."""
    lines = [f"{finding['Severity']}: {finding['VUID']}", f"  {finding['MainMessage']}"]
    for frame in finding.get("call_site", []):
        if frame.get("file"):
            lines.append(f"  at {frame['file']}:{frame['line']} in {frame['function']}")
            break
    return lines


def summary_lines(verdict, status):
    """Returns the lines of the summary. `status` is the application's, or None for merged records."""
    record = verdict.record
    lines = []
    if not verdict.is_loaded:
        return [describe_exit(status)] if status else []
    for finding in verdict.new:
        lines += finding_lines(finding)
    counts = Counter(finding["VUID"] for finding in verdict.new)
    for name, count in counts.most_common():
        lines.append(f"{count:6,}  {name}")
    held_back = sum(record.held_back().values())
    text = plural(len(verdict.new), "finding")
    if held_back:
        text += f" and {plural(held_back, 'duplicate')} that were not reported"
    text += f" in {plural(len(record.pids()), 'process')}".replace("processs", "processes")
    if verdict.known:
        text += f"; {plural(len(verdict.known), 'finding')} of the baseline"
    warnings = record.warnings()
    if warnings:
        text += f"; {plural(len(warnings), 'warning')}"
    lines.append(text)
    for summary in record.summaries:
        for reason in summary.get("Unchecked", []):
            lines.append(f"not checked: {reason}")
    for entry in verdict.unused_entries:
        lines.append(f"{entry.path}:{entry.line}: matches no finding any more: {entry.text}")
    if status:
        lines.append(describe_exit(status))
    return lines


def exit_status(verdict, status, error_exitcode, is_strict):
    """Returns the exit status of the run. A negative one is a signal, to be passed on."""
    if status < 0:
        return status
    if not verdict.is_loaded:
        return NOT_LOADED
    if verdict.new or (is_strict and verdict.unused_entries):
        return error_exitcode
    return status
