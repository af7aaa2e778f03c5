# SPDX-License-Identifier: Apache-2.0
"""Runs the application, and waits for those of its processes that outlive it."""

import os
import pathlib
import signal
import subprocess
import time


class SignalRelay:
    """While the application runs, signals are the application's: it decides what becomes of them.
    The terminal sends some to both; the others are passed on. What is ignored stays ignored."""

    FROM_TERMINAL = (signal.SIGINT, signal.SIGQUIT)
    PASSED_ON = (signal.SIGTERM, signal.SIGHUP)

    def __init__(self):
        self.process, self.got, self.previous = None, [], {}

    def __enter__(self):
        for number in self.FROM_TERMINAL + self.PASSED_ON:
            if signal.getsignal(number) != signal.SIG_IGN:
                self.previous[number] = signal.signal(number, self.handle)
        return self

    def __exit__(self, *_):
        for number, handler in self.previous.items():
            signal.signal(number, handler)

    def handle(self, number, _):
        self.got.append(number)
        if self.process and number in self.PASSED_ON:
            self.process.send_signal(number)

    def watch(self, process):
        self.process = process
        for number in self.got:  # those before the process was known
            process.send_signal(number)


def is_running(pid):
    """A zombie does not run. A container may lack a process that reaps zombies."""
    try:
        stat = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def running_processes(records):
    """Returns the pids of processes that have a record, and so have loaded the layer, and still run."""
    return [path.stem for path in records.glob("*.jsonl")
            if path.stem.isdigit() and is_running(path.stem)]


POLL_SECONDS = 0.05
GRACE_SECONDS = 5


def wait_for(process, observer):
    """Returns the status of the process, or None if the observer wants the run to end."""
    while observer:
        try:
            return process.wait(POLL_SECONDS)
        except subprocess.TimeoutExpired:
            if observer.observe():
                return None
    return process.wait()


def end_processes(process, records):
    """Ends the application and its processes that have loaded the layer."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        process.send_signal(number)  # nothing if it has ended: its pid may be another's then
        for pid in map(int, running_processes(records)):
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass
        end = time.monotonic() + GRACE_SECONDS
        while time.monotonic() < end and (process.poll() is None or running_processes(records)):
            time.sleep(POLL_SECONDS)


def run_application(command, environment, records, say, observer=None):
    """Returns the status of the application; a negative one is the signal that ended it. A launcher
    may end before what it launches: without waiting, the findings of that would be lost. If the
    observer ends the run, the status is 0."""
    with SignalRelay() as relay:
        with subprocess.Popen(command, env=environment) as process:
            relay.watch(process)
            status = wait_for(process, observer)
            if status is None:
                end_processes(process, records)
                return 0
        pids = running_processes(records)
        if pids and not relay.got:
            say(f"waiting for {'process' if len(pids) == 1 else 'processes'} {', '.join(pids)}")
        while not relay.got and running_processes(records):
            time.sleep(POLL_SECONDS)
            if observer and observer.observe():
                end_processes(process, records)
                return 0
        pids = running_processes(records)
        if pids:
            say(f"not waiting for {', '.join(pids)}: what they do from now on is not judged")
        if observer:
            observer.observe()
        return status
