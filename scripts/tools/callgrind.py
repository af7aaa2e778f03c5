# SPDX-License-Identifier: Apache-2.0
"""Counting the instructions of one function of a program, with callgrind."""

import re
import subprocess
import sys


def collect(valgrind, function, *command):
    """Returns the instructions executed in the function and below, and what the program prints."""
    run = subprocess.run(
        [valgrind, "--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no",
         f"--toggle-collect={function}", *map(str, command)],
        capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode or not collected or not int(collected[1]):
        sys.exit(f"{command}: the count failed ({run.returncode}):\n{run.stdout}{run.stderr}")
    return int(collected[1]), run.stdout


def count_recording(arguments, layer, *options):
    """Returns the instructions a build and the probes of memory that recording takes in the program
    `record`, with the layer ("on") or without it ("off")."""
    collected, printed = collect(arguments.valgrind, "profiled_recording", arguments.record,
                                 "--profile", layer, "--driver", "null", *options)
    recorded = re.search(r"recorded (\d+) builds, (\d+) probes", printed)
    return collected / int(recorded[1]), int(recorded[2])
