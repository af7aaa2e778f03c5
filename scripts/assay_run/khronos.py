# SPDX-License-Identifier: Apache-2.0
"""--count-khronos: what the Khronos validation layer reports becomes findings of the run's record.

The layer writes its messages to a named pipe: processes that log to one file would erase each other's
messages. A thread reads the pipe, so findings are in the record soon after they were reported."""

import json
import os
import pathlib
import select
import subprocess
import threading

from .groups import CARRIERS
from .khronos_messages import last_heading, read_messages

SETTINGS = "vk_layer_settings.txt"
PREFIX = "khronos_validation."
POLL_SECONDS = 0.05


def given_settings(environment):
    """Returns the lines of the settings file that the layers would read."""
    path = pathlib.Path(environment.get("VK_LAYER_SETTINGS_PATH") or SETTINGS)
    try:
        text = (path / SETTINGS if path.is_dir() else path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return text.splitlines()


def key_of(line):
    return line.partition("=")[0].strip()


class KhronosLog:
    """Is open while the application runs."""

    def __init__(self, folder, records, is_limited=True):
        """`folder` is for temporary files. `is_limited`: the layer may hold back
        messages that repeat."""
        self.pipe, self.settings = folder / "khronos.pipe", folder / SETTINGS
        self.record = records / "khronos.jsonl"
        self.is_limited = is_limited
        self.was_opened = False
        self.is_ending = threading.Event()
        self.text, self.file, self.poll, self.thread = b"", None, select.poll(), None

    def change(self, environment):
        """Makes the layer write to the pipe. Layers before 1.3.268 know these settings only from a file,
        and later ones prefer the environment."""
        values = {"debug_action": "VK_DBG_LAYER_ACTION_LOG_MSG", "log_filename": str(self.pipe)}
        if not self.is_limited:
            values["enable_message_limit"] = "false"
        lines = [line for line in given_settings(environment)
                 if key_of(line) not in {PREFIX + key for key in values}]
        lines += [f"{PREFIX}{key} = {value}" for key, value in values.items()]
        self.settings.write_text("\n".join(lines) + "\n", encoding="utf-8")
        environment["VK_LAYER_SETTINGS_PATH"] = str(self.settings)
        for key, value in values.items():
            environment["VK_KHRONOS_VALIDATION_" + key.upper()] = value

    def __enter__(self):
        os.mkfifo(self.pipe)
        self.file = os.open(self.pipe, os.O_RDONLY | os.O_NONBLOCK)
        self.poll.register(self.file, select.POLLIN)
        self.thread = threading.Thread(target=self.read_pipe)
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.is_ending.set()
        self.thread.join()
        if self.read() is None:
            self.leave_reader()
        os.close(self.file)

    def leave_reader(self):
        """Keeps reading the pipe: without a reader, SIGPIPE ends a process that still writes."""
        os.set_blocking(self.file, True)
        subprocess.Popen(["cat"], stdin=self.file,  # pylint: disable=consider-using-with
                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)

    def read(self):
        """Returns what was written; None if a process has the pipe open and has written nothing; nothing if
        none has it open."""
        was_closed = bool(self.poll.poll(0))  # or written to
        try:
            data = os.read(self.file, 1 << 16)
        except BlockingIOError:
            data = None
        self.was_opened = self.was_opened or was_closed or data is None
        return data

    def read_pipe(self):
        """Until the end, and then what is left."""
        while True:
            is_last = self.is_ending.is_set()
            data = self.read()
            if data:
                self.add(data)
                continue
            self.write(len(self.text))  # the layer writes a message at once: the last one is whole
            if is_last:
                return
            self.is_ending.wait(POLL_SECONDS)

    def add(self, data):
        self.text += data
        self.write(last_heading(self.text.decode("latin-1")))

    def write(self, length):
        """Moves so much of the text to the record, as findings."""
        messages = read_messages(self.text[:length].decode("utf-8", "replace"))
        self.text = self.text[length:]
        if not messages:
            return
        try:
            with open(self.record, "a", encoding="utf-8") as file:
                file.write("".join(json.dumps(message) + "\n" for message in messages))
        except OSError:
            pass  # a full disk: run.json says so. The application must not wait for a reader


class Doubles:
    """Finds the findings of the Khronos layer that are Assay's, too: with the same id, about the same object
    or in the same command. Debug names tell objects apart, handles do not: the layers may see others."""

    def __init__(self):
        self.first = {}

    def note(self, finding):
        """Adds a finding of Assay."""
        for name in [finding["VUID"], *finding.get("formerly", []), *finding.get("also", [])]:
            for value in things_of(finding):
                self.first.setdefault((name, value), finding)
            self.first.setdefault((name, finding.get("Function"), has_names(finding)), finding)

    def find(self, finding):
        """Returns Assay's finding, or None."""
        name, function = finding["VUID"], finding.get("Function")
        keys = [(name, value) for value in things_of(finding)]
        if function:
            keys += [(name, function, False)] + ([] if has_names(finding) else [(name, function, True)])
        return next((self.first[key] for key in keys if key in self.first), None)


def things_of(finding):
    """Returns the handles and debug names of the objects that few findings have in common."""
    return [item[member] for item in finding.get("Objects", [])
            if item["type"] not in ("VkInstance", "VkPhysicalDevice", "VkDevice", "VkQueue")
            for member in ("name", "handle") if item.get(member)]


def has_names(finding):
    return any(item.get("name") and item["type"] not in CARRIERS for item in finding.get("Objects", []))


def is_khronos(finding):
    return finding.get("Layer") == "Khronos"


def without_doubles(findings, run_of):
    """Returns the findings without those of the Khronos layer that are Assay's, too, which are marked.
    `run_of` returns the run of a finding."""
    doubles = {}
    for finding in findings:
        if not is_khronos(finding):
            doubles.setdefault(run_of(finding), Doubles()).note(finding)
    kept = []
    for finding in findings:
        run = doubles.get(run_of(finding))
        same = run.find(finding) if run and is_khronos(finding) else None
        if same:
            same["LayerToo"] = "Khronos"
        else:
            kept.append(finding)
    return kept
