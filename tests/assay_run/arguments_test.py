# SPDX-License-Identifier: Apache-2.0
"""The command line: what is wrong ends with status 2 before the application runs; and the environment that the
application gets."""

import os
import pathlib
import re
import subprocess
import sys
import unittest

from runs import LAYER as FUNCTIONS, ROOT, Runs, main
from assay_run import environment
from assay_run.environment import KHRONOS, LAYER, MANIFEST, application_environment
from assay_run.options import make_parser, parse_arguments


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
        script = FUNCTIONS + "load(); sys.exit(sys.argv[1:] != ['--level', '--', '-h'])"
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


class Environment(Runs):
    def make(self, *words, **base):
        arguments = parse_arguments([*words, "--", "true"])
        return application_environment(arguments, pathlib.Path("/records"), base)

    def test_layers(self):
        """The layer comes behind others, and is named once."""
        for given, made in (("A:B", f"A:B:{LAYER}"), (f"{LAYER}:A", f"{LAYER}:A"), ("", LAYER)):
            self.assertEqual(self.make(VK_INSTANCE_LAYERS=given)["VK_INSTANCE_LAYERS"], made)
        self.assertEqual(self.make()["VK_INSTANCE_LAYERS"], LAYER)
        self.assertEqual(self.make("--with-khronos")["VK_INSTANCE_LAYERS"], f"{KHRONOS}:{LAYER}")

    def test_switches_of_the_implicit_layer(self):
        made = self.make(VK_ASSAY_DISABLE="1", VK_ASSAY_ENABLE="1")
        self.assertFalse({"VK_ASSAY_DISABLE", "VK_ASSAY_ENABLE"} & set(made))

    def test_disabled_layers(self):
        self.assertNotIn("VK_LOADER_LAYERS_ALLOW", self.make())
        made = self.make(VK_LOADER_LAYERS_DISABLE="~all~", VK_LOADER_LAYERS_ALLOW="A")
        self.assertEqual(made["VK_LOADER_LAYERS_ALLOW"], f"A,{LAYER}")

    def test_settings(self):
        made = self.make("--level", "content", "--set", "spec_text=none", "--backend=cpu")
        for key, value in {"LEVEL": "content", "SPEC_TEXT": "none", "BACKEND": "cpu",
                           "LOG_FORMAT": "json", "LOG_FILENAME": "/records/%p.jsonl",
                           "REPORT_FLAGS": "error,warn"}.items():
            self.assertEqual(made["VK_ASSAY_VALIDATION_" + key], value)

    def test_errors_are_always_reported(self):
        key = "VK_ASSAY_VALIDATION_REPORT_FLAGS"
        self.assertEqual(self.make("--set", "report_flags=info")[key], "error,info")
        self.assertEqual(self.make(**{key: "warn,error,info"})[key], "warn,error,info")
        self.assertEqual(self.make(**{key: "warn"})[key], "error,warn")

    def test_messages_are_always_logged(self):
        key = "VK_ASSAY_VALIDATION_DEBUG_ACTION"
        for given, made in (("callback", "log,callback"), ("ignore", "log"), ("log,fail", "log,fail"),
                            ("VK_DBG_LAYER_ACTION_LOG_MSG", "VK_DBG_LAYER_ACTION_LOG_MSG"),
                            ("VK_DBG_LAYER_ACTION_IGNORE", "log"), ("default", "default")):
            self.assertEqual(self.make("--set", f"debug_action={given}")[key], made)
        self.assertEqual(self.make()[key], "default")

    def test_crashes_are_reported(self):
        key = "VK_ASSAY_VALIDATION_CRASH_REPORT"
        self.assertEqual(self.make()[key], "true")
        self.assertEqual(self.make("--set", "crash_report=false")[key], "false")
        self.assertEqual(self.make(**{key: "false"})[key], "false")

    def test_the_page_has_builds(self):
        key = "VK_ASSAY_VALIDATION_RECORD_BUILDS"
        page = ("--html", str(self.folder / "a.html"))
        self.assertNotIn(key, self.make())
        self.assertEqual(self.make(*page)[key], "true")
        self.assertEqual(self.make(*page, "--level", "content")[key], "true")
        self.assertEqual(self.make(*page, "--set", "record_builds=false")[key], "false")
        self.assertEqual(self.make(*page, **{key: "false"})[key], "false")
        self.assertNotIn(key, self.make(*page, "--level", "state"))
        self.assertNotIn(key, self.make(*page, VK_ASSAY_VALIDATION_LEVEL="parameters"))

    def test_known_findings_use_up_no_limit(self):
        key = "VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT"
        self.assertNotIn(key, self.make())
        self.assertEqual(self.make("--write-baseline", str(self.folder / "a"))[key], "false")

    def test_lavapipe(self):
        folder = self.folder / "vulkan/icd.d"
        folder.mkdir(parents=True)
        names = [str(folder / f"lvp_icd.{machine}.json") for machine in ("i686", "x86_64")]
        for name in names:
            pathlib.Path(name).touch()
        made = self.make("--lavapipe", XDG_CONFIG_HOME=str(self.folder), VK_DRIVER_FILES="mine",
                         VK_LOADER_DRIVERS_SELECT="*mine*")
        self.assertEqual(made["VK_DRIVER_FILES"], os.pathsep.join(names))
        self.assertEqual(made["VK_ICD_FILENAMES"], os.pathsep.join(names))
        self.assertNotIn("VK_LOADER_DRIVERS_SELECT", made)

    def test_given_driver_stays(self):
        self.assertEqual(self.make(VK_DRIVER_FILES="mine")["VK_DRIVER_FILES"], "mine")

    # ---- where the layer is

    def make_tree(self, name, time=1000):
        tree = self.folder / "repository/build" / name
        for file in (tree / "layer/libVkLayer_assay.so", tree / "explicit_layer.d" / MANIFEST):
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch()
            os.utime(file, (time, time))
        return tree / "explicit_layer.d"

    def find(self):
        (self.folder / "repository/scripts").mkdir(parents=True, exist_ok=True)
        return environment.find_manifest_folder(self.folder / "repository/scripts")

    def test_no_build(self):
        self.assertIsNone(self.find())

    def test_newest_build(self):
        newest = self.make_tree("release", 3000)
        self.make_tree("debug", 2000)
        self.make_tree("asan", 4000)
        self.assertEqual(self.find(), newest)

    def test_unpacked_anywhere(self):
        folder = self.folder / "share/vulkan/explicit_layer.d"
        folder.mkdir(parents=True)
        (folder / MANIFEST).touch()
        self.assertEqual(environment.find_manifest_folder(self.folder / "share/assay"), folder)

    def test_layer_path(self):
        made = {"HOME": "/home/a", "XDG_DATA_DIRS": "/opt/share"}
        environment.add_layer_path(made, "/here")
        self.assertEqual(made["VK_LAYER_PATH"].split(":"), [
            "/here", *(f"{base}/vulkan/explicit_layer.d" for base in (
                "/home/a/.config", "/etc/xdg", "/usr/local/etc", "/etc", "/home/a/.local/share",
                "/opt/share"))])

    def test_given_layer_path_stays_behind(self):
        made = {"VK_LAYER_PATH": "/wrong:/other"}
        environment.add_layer_path(made, "/here")
        self.assertEqual(made["VK_LAYER_PATH"], "/here:/wrong:/other")

    def test_given_layer_path_with_the_layer_stays(self):
        tree = self.make_tree("release")
        made = {"VK_LAYER_PATH": str(tree)}
        environment.add_layer_path(made, "/here")
        self.assertEqual(made["VK_LAYER_PATH"], str(tree))

    def test_khronos_path(self):
        """It is added if VK_LAYER_PATH hides it; without it assay-run does not start the application."""
        with self.assertRaisesRegex(environment.EnvironmentFailure, "vulkan-validationlayers"):
            self.make("--with-khronos", XDG_DATA_DIRS="/nowhere", HOME="/nowhere",
                      VK_LAYER_PATH="/wrong")
        folder = self.folder / "vulkan/explicit_layer.d"
        folder.mkdir(parents=True)
        (folder / "VkLayer_khronos_validation.json").touch()
        made = self.make("--with-khronos", XDG_DATA_DIRS=str(self.folder), HOME="/nowhere",
                         VK_LAYER_PATH=str(self.make_tree("release")))
        self.assertEqual(made["VK_LAYER_PATH"].split(":")[-1], str(folder))


if __name__ == "__main__":
    main()
