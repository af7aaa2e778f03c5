# SPDX-License-Identifier: Apache-2.0
"""What scripts/bench findings makes of the output of test programs."""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "tools" / "findings"))

from judge import Judge
from play import read_plays

EXPECTED, RETIRED, OTHER = "VUID-a-1", "VUID-a-0", "VUID-b-2"
NAME = "calls/x: case/device"
UNEXPECTED = ["messages: 1, of which 1 are not expected"]


def output(*lines, end=f"[  FAILED  ] {NAME}", name=NAME):
    return "\n".join((f"[ RUN      ] {name}", *lines, end))


def got(name, text="text"):
    return [f"    got {name}", f"        {text}"]


class Findings(unittest.TestCase):
    def setUp(self):
        self.judge = Judge({EXPECTED: {EXPECTED, RETIRED}, OTHER: {OTHER}})
        self.ours = read_plays(output(end=f"[       OK ] {NAME}"))[0]

    def verdict(self, text, expected=(EXPECTED,), twin=None):
        play = read_plays(text)[0]
        return self.judge.judge(play.name, self.ours, play, expected, twin)

    def outcome(self, *lines, end=f"[  FAILED  ] {NAME}"):
        return self.verdict(output(*lines, end=end)).outcome

    def test_a_mistake_is_found_by_its_id_or_a_retired_one(self):
        self.assertEqual(self.outcome(end=f"[       OK ] {NAME}"), "found")
        self.assertEqual(self.outcome(*UNEXPECTED, *got(EXPECTED)), "found")
        self.assertEqual(self.outcome(*UNEXPECTED, *got(RETIRED)), "found")

    def test_a_message_with_another_id_is_counted_apart(self):
        self.assertEqual(self.outcome(*UNEXPECTED, *got(OTHER)), "another id")

    def test_what_is_also_said_of_the_twin_finds_nothing(self):
        twin = read_plays(output("the call: 1 messages instead of silence", *got(OTHER)))[0]
        self.assertEqual(self.verdict(output(*UNEXPECTED, *got(OTHER)), twin=twin).outcome, "missed")

    def test_silence_of_a_program_misses_the_mistake(self):
        name = "order_programs.p/device"
        text = output("the call returned 0 instead of -1000011001", "(in step 3)", name=name,
                      end=f"[  FAILED  ] {name}")
        self.assertEqual(self.verdict(text).outcome, "missed")

    def test_silence_misses_the_mistake(self):
        self.assertEqual(self.outcome(f"no message is {EXPECTED}: "), "missed")

    def test_a_program_that_ends_within_a_play_has_crashed(self):
        self.assertEqual(self.outcome(end=""), "crashed")
        self.assertEqual(self.outcome(end=f"[  FAILED  ] crashed in {NAME}"), "crashed")

    def test_messages_about_valid_calls_are_false_alarms(self):
        lines = ["the call: 1 messages instead of silence"]
        self.assertEqual(self.verdict(output(*lines, *got(OTHER)), ()).alarms, [OTHER])
        self.assertEqual(self.verdict(output(*lines, *got("VUID-c-3")), ()).alarms, [])
        crashed = self.verdict(output(end=""), ())
        self.assertTrue(crashed.crashed)

    def test_messages_before_the_call_are_no_false_alarms(self):
        lines = ["the call: 1 messages before it", *got(OTHER)]
        self.assertEqual(self.verdict(output(*lines), ()).alarms, [])

    def test_skipped_plays_are_left_out(self):
        verdict = self.verdict(output(end=f"[  SKIPPED ] {NAME}: no driver"))
        self.assertEqual((verdict.kind, verdict.reason), ("left out", "skipped: no driver"))

    def test_plays_after_one_another(self):
        text = output(*UNEXPECTED, *got(OTHER)) + "\n" + output(end="[       OK ] " + NAME)
        self.assertEqual([play.outcome for play in read_plays(text)], ["failed", "passed"])


if __name__ == "__main__":
    unittest.main()
