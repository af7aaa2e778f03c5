# SPDX-License-Identifier: Apache-2.0
"""Records: the lines of JSON that the layer writes for each process, and what became of each run."""

import json
import os
import pathlib
import tempfile
from collections import Counter

from .khronos import is_khronos, without_doubles

RUN = "run.json"  # beside the records of a run's processes: its command, and the status at the end
LONGEST_LINE = 1 << 16
STRINGS = {"Finding": ("VUID", "Severity", "MainMessage"), "Header": ("LayerVersion",)}


class RecordFailure(Exception):
    """A record that cannot be read; the text says which and why."""


def is_mistake(finding):
    """Returns whether a finding counts: an error, or a warning about a call (docs/warnings.md). Other
    warnings are about the layer, a lost device, or what the driver built. Those of the Khronos layer are
    about habits."""
    is_of_call = finding.get("Function") and not is_khronos(finding) and not finding["VUID"].startswith("ASSAY-compare-")
    return finding["Severity"] == "Error" or bool(finding["Severity"] == "Warning" and is_of_call)


def is_advice(finding):
    """Returns whether a finding is one of setting advice: it counts only with --advice-is-error."""
    return finding["VUID"].startswith("ASSAY-advice-")


class Record:
    """What one or several processes have reported."""

    def __init__(self):
        self.headers, self.devices, self.findings, self.summaries = [], [], [], []
        self.lines = []  # all of them in their order, each with the number of its process
        self.damaged = []  # "file:line" of lines that were not written whole, folders on a full disk
        self.runs = {}  # by folder: the command, the status if it has ended, the number of records
        self.processes = {}  # numbers, by file and pid
        self.advice_is_error = False

    def add(self, line, path):
        lists = {"Header": self.headers, "Device": self.devices, "Finding": self.findings,
                 "Summary": self.summaries}
        if line["Type"] in lists:
            lists[line["Type"]].append(line)
        if is_khronos(line):
            self.lines.append((None, line))  # its log does not name the process
            return
        # Several hosts may use the same pid, and several processes the same file.
        process = self.processes.setdefault((str(path), line.get("pid")), len(self.processes))
        self.lines.append((process, line))

    def counts(self, finding):
        return self.advice_is_error if is_advice(finding) else is_mistake(finding)

    def mistakes(self):
        return [finding for finding in self.findings if self.counts(finding)]

    def advice(self):
        """Returns the advice that does not count, the worst first for each device."""
        return [finding for finding in self.findings
                if is_advice(finding) and not self.counts(finding)]

    def follows_advice(self):
        """Returns whether a process has setting advice."""
        return any(header.get("Settings", {}).get("advice") == "true" for header in self.headers)

    def warnings(self):
        return [finding for finding in self.findings if finding["Severity"] == "Warning" and
                not self.counts(finding) and not is_advice(finding)]

    def held_back(self):
        """Returns how often each id was found beyond what was reported."""
        counts = Counter()
        for summary in self.summaries:
            counts.update(summary.get("HeldBack", {}))
        return counts

    def may_lack_repetitions(self):
        """Returns whether a process reached the limit of repeated messages, and ended before a summary
        said how many of them were held back."""
        ends, limits, counts = Counter(), {}, Counter()
        for process, line in self.lines:
            ends[process] += {"Header": 1, "Summary": -1}.get(line["Type"], 0)
            if line["Type"] == "Header":
                limit = str(line.get("Settings", {}).get("duplicate_message_limit"))
                limits[process] = int(limit) if limit.isdecimal() else 0
            elif line["Type"] == "Finding" and self.counts(line):
                counts[process, line["VUID"]] += 1
        return any(ends[process] > 0 and 0 < limits.get(process, 0) <= count
                   for (process, _), count in counts.items())

    @property
    def is_loaded(self):
        return bool(self.headers) and not self.runs_without_layer()

    def runs_without_layer(self):
        return [folder for folder, run in self.runs.items() if not run["loaded"]]

    def runs_without_khronos(self):
        """Returns the runs that should have loaded the Khronos layer, too, and have not."""
        return [folder for folder, run in self.runs.items() if run["khronos"] is False]

    def unfinished_runs(self):
        """Returns the runs that ended together with assay-run, before it could judge them."""
        return [folder for folder, run in self.runs.items() if run["status"] is None]

    def worst_status(self):
        """Returns the first status of a run's application that is not 0, or 0."""
        return next((run["status"] for run in self.runs.values() if run["status"]), 0)


def without_surrogates(value):
    """JSON can escape half a character, which no file in UTF-8 can hold."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, list):
        return [without_surrogates(item) for item in value]
    if isinstance(value, dict):
        return {without_surrogates(key): without_surrogates(item) for key, item in value.items()}
    return value


def parse_line(text):
    """Returns the object of a line, or None if it is not a line of a record."""
    try:
        line = json.loads(text)
    except ValueError:
        return None
    if not isinstance(line, dict) or not isinstance(line.get("Type"), str):
        return None
    if not all(isinstance(line.get(name), str) for name in STRINGS.get(line["Type"], ())):
        return None
    return without_surrogates(line) if "\\ud" in text.lower() else line


def read_lines(record, path):
    """Adds a file's lines. Returns whether the layer was loaded."""
    loaded = False
    with open(path, encoding="utf-8", errors="replace", newline="\n") as file:
        for number, text in enumerate(file, 1):
            if not text.strip():
                continue
            line = parse_line(text)
            if line:
                record.add(line, path)
                loaded = loaded or line["Type"] == "Header"
            else:
                record.damaged.append(f"{path}:{number}")
    return loaded


def read_run(path):
    try:
        run = json.loads(path.read_text(encoding="utf-8"))
        return {"command": list(map(str, run["command"])), "status": run["status"],
                "full": bool(run.get("full")), "loaded": False, "khronos": run.get("khronos")}
    except (ValueError, KeyError, TypeError) as error:
        raise RecordFailure(f"{path}: not written by assay-run") from error


def write_run(folder, command, status=None, khronos=None):
    """Says what runs, or ran, so that --merge knows it, too. `khronos`: whether the Khronos layer has been
    loaded, if its findings count. A full disk may have kept whole lines from
    the records: none of them is damaged then, so the space is tried."""
    run = {"command": command, "status": status, "full": not has_space(folder),
           "khronos": khronos}
    (folder / RUN).write_text(json.dumps(run) + "\n", encoding="utf-8")


def has_space(folder):
    try:
        with tempfile.NamedTemporaryFile(dir=folder, buffering=0) as file:
            return file.write(bytes(LONGEST_LINE)) == LONGEST_LINE
    except OSError:
        return False


def fail_walk(error):
    raise error


def find_files(path):
    """Returns the file, or the files of a folder and its folders."""
    if not path.is_dir():
        return [path]
    found = []
    for folder, _, names in os.walk(path, onerror=fail_walk):
        found += [pathlib.Path(folder) / name for name in names
                  if name == RUN or name.endswith(".jsonl")]
    return sorted(found)


def read_process(record, file, folders):
    """Adds a file, and notes the folder of each of its findings."""
    count = len(record.findings)
    if read_lines(record, file) and str(file.parent) in record.runs:
        record.runs[str(file.parent)]["loaded"] = True
    folders.update({id(finding): file.parent for finding in record.findings[count:]})


def read_records(paths):
    """Reads files, and the records in folders and their folders. What is named twice is read once."""
    record, folders = Record(), {}
    try:
        files = {file.resolve(): None for path in paths for file in find_files(pathlib.Path(path))}
        for file in files:
            if file.name == RUN:
                run = record.runs[str(file.parent)] = read_run(file)
                if run["full"]:
                    record.damaged.append(str(file.parent))
        for file in files:
            if file.name != RUN:
                read_process(record, file, folders)
    except OSError as error:
        raise RecordFailure(f"{error.filename}: {error.strerror}") from error
    record.findings = without_doubles(record.findings, lambda finding: folders[id(finding)])
    return record
