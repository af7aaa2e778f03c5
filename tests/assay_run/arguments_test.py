# SPDX-License-Identifier: Apache-2.0
"""The command line: what is wrong ends with status 2 before the application runs."""

import re
import subprocess
import sys
import unittest

from runs import LAYER, ROOT, Runs, main
from assay_run.options import make_parser


class Arguments(Runs):
    def expect_refused(self, *words):
        self.expect(self.run_words(*words, "--", "touch", "was-run"), 2)
        self.assertFalse((self.folder / "was-run").exists())

    def test_refused(self):
        (self.folder / "known.txt").write_text("an id with spaces\n")
        (self.folder / "binary").write_bytes(b"\xff\xfe")
        for words in (["--level", "everything"], ["--leve", "content"], ["--set", "level"],
                      ["--error-exitcode", "0"], ["--error-exitcode", "²"],
                      ["--strict-baseline"], ["--baseline", "none.txt"], ["--baseline", "known.txt"],
                      ["--baseline", "binary"], ["--junit", "no/folder/a.xml"], ["--html", "."],
                      ["--set", "hazard=true"], ["--set", "hazards=maybe"],
                      ["--set", "level=everything"], ["--set", "compare_rays=1000001"],
                      ["--set", "hang_seconds=-1"], ["--set", "report_flags=error,wurn"],
                      ["--set", "log_filename=x"], ["--set", "log_format=text"],
                      ["--merge", "known.txt"]):
            with self.subTest(words):
                self.expect_refused(*words)

    def test_equals_sign(self):
        script = "load(); sys.exit(os.environ['VK_ASSAY_VALIDATION_LEVEL'] != 'content')"
        self.expect(self.run_script(script, "--level=content"), 0)

    def test_values_that_the_layer_takes(self):
        for given in ("hazards=ON", "LEVEL=content", "compare_rays=1000000", "report_flags=error, perf",
                      "debug_action=log,VK_DBG_LAYER_ACTION_BREAK", "message_id_filter=what,ever",
                      "duplicate_message_limit=0", "record_builds=true"):
            with self.subTest(given):
                self.expect(self.run_script("load()", "--set", given), 0)

    def test_refused_settings_are_named(self):
        self.expect(self.run_words("--set", "hazard=true", "--", "true"), 2,
                    "--set hazard: the layer has no such setting (did you mean hazards?); it has advice, ")
        self.expect(self.run_words("--set", "guard=on", "--", "true"), 2,
                    "--set guard=on: not off, references")

    def test_unknown_words(self):
        for words, said in ((["./app", "--frames", "a b"], "write -- before the application: -- ./app --frames 'a b'"),
                            (["--junit", "a.xml", "./app"], "write -- before the application: -- ./app"),
                            (["app", "--", "true"], "no option: app"),
                            (["--lavpipe", "--", "true"], "unknown option: --lavpipe (did you mean --lavapipe?)"),
                            (["--leve", "content", "--", "true"], "unknown option: --leve (did you mean --level?)"),
                            (["--zzz", "--", "true"], "unknown option: --zzz\n")):
            with self.subTest(words):
                self.expect(self.run_words(*words), 2, said)

    def test_missing_baseline(self):
        self.expect(self.run_words("--baseline", "none.txt", "--", "true"), 2,
                    "none.txt: No such file or directory\n")

    def test_everything(self):
        script = ("load(); print(*(os.environ.get('VK_ASSAY_VALIDATION_' + name) for name in "
                  "('PRESET', 'LEVEL', 'HAZARDS')))")
        result = self.expect(self.run_script(script, "--everything"), 0)
        self.assertEqual(result.out, "everything None None\n")
        result = self.run_script(script, "--set", "hazards=off", "--everything", "--level", "execution")
        self.assertEqual(result.out, "everything execution off\n")
        self.assertEqual(self.run_script(script, "--everything", "--set", "preset=ci").out, "ci None None\n")

    def test_advice_is_error_turns_advice_on(self):
        script = "load(); print(os.environ.get('VK_ASSAY_VALIDATION_ADVICE'))"
        result = self.run_script(script, "--advice-is-error")
        self.assertEqual(result.out, "true\n")
        result = self.run_script(script, "--advice-is-error", "--set", "advice=false")
        self.assertEqual(result.out, "false\n")

    def test_nothing_to_run(self):
        self.assertEqual(self.run_words().status, 2)
        self.assertEqual(self.run_words("--").status, 2)

    def test_the_application_has_options_of_its_own(self):
        script = LAYER + "load(); sys.exit(sys.argv[1:] != ['--level', '--', '-h'])"
        self.expect(self.run_words("--", sys.executable, "-c", script, "--level", "--", "-h"), 0)

    def test_help(self):
        result = self.expect(self.run_words("--help"), 0)
        self.assertIn("exit status", result.out)


class Elsewhere(unittest.TestCase):
    """The manual and the completion have every option."""

    OPTIONS = sorted(option for action in make_parser()._actions
                     for option in action.option_strings if option.startswith("--"))

    def test_manual(self):
        page = (ROOT / "docs/man/assay-run.1").read_text(encoding="utf-8").replace("\\-", "-")
        for option in self.OPTIONS:
            self.assertIn(option, page)

    def test_statuses_in_the_manual(self):
        page = (ROOT / "docs/man/assay-run.1").read_text(encoding="utf-8")
        epilog = make_parser().epilog
        for number in re.findall(r"^  (\d+)", epilog, re.M):
            self.assertIn(number, page)

    def test_completion(self):
        script = ROOT / "scripts/assay_run/completion.bash"
        words = subprocess.run(
            ["bash", "-c", f"source {script}; COMP_WORDS=(assay-run --); COMP_CWORD=1; "
             "_assay_run; printf '%s\\n' \"${COMPREPLY[@]}\""],
            capture_output=True, encoding="utf-8", check=True).stdout.split()
        self.assertEqual(sorted(set(words) - {"--"}), self.OPTIONS)


if __name__ == "__main__":
    main()
