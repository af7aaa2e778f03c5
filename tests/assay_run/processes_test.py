# SPDX-License-Identifier: Apache-2.0
"""The exit status: the application's, or what assay-run makes of the records of its processes. layer_test.py
has what an application under the layer can show."""

import os
import signal
import subprocess
import sys
import textwrap

from runs import ASSAY_RUN, LAYER, VUID, Runs, main


class Statuses(Runs):
    def test_finding(self):
        self.expect(self.run_script("load(); find(); end(); sys.exit(42)"), 99, VUID,
                    "1 finding in 1 process", "exit status is 42")

    def test_not_loaded(self):
        self.expect(self.run_script("pass"), 98, "the layer was not loaded")

    def test_not_loaded_is_said_when_quiet(self):
        self.assertIn("the layer was not loaded", self.run_script("pass", "--quiet").err)

    def test_empty_record(self):
        self.assertEqual(self.run_script('write("")').status, 98)

    def test_warnings_are_no_findings(self):
        for members in ("'ASSAY-warning'", "'ASSAY-compare-missed', Function='vkB'"):
            script = f"load(); find({members}, Severity='Warning')"
            self.expect(self.run_script(script), 0, "1 warning")

    def test_warnings_about_calls_are_findings(self):
        script = "load(); find('ASSAY-read-past-buffer', Severity='Warning', Function='vkB')"
        self.expect(self.run_script(script), 99, "Warning: ASSAY-read-past-buffer", "1 finding in")

    def test_quiet_and_clean_is_silent(self):
        result = self.run_script("load(); end(); print('own output')", "--quiet")
        self.assertEqual((result.out, result.err), ("own output\n", ""))

    def test_not_found(self):
        self.assertEqual(self.run_words("--", "./no-such-program").status, 127)

    def test_not_executable(self):
        (self.folder / "text").write_text("text")
        self.assertEqual(self.run_words("--", "./text").status, 126)


class Signals(Runs):
    def test_passed_on_after_a_finding(self):
        for number in (signal.SIGSEGV, signal.SIGKILL, signal.SIGABRT, signal.SIGTERM):
            result = self.run_script(f"load(); find(); os.kill(os.getpid(), {int(number)})")
            self.assertEqual(result.status, -number)
            self.assertIn(VUID, result.err)
            self.assertIn(f"ended by {number.name}", result.err)

    def test_crash_report(self):
        result = self.run_script("load(); find(); find('ASSAY-crash', Severity='Warning', "
                                 "MainMessage='It received SIGSEGV:\\n1. build of x'); "
                                 f"os.kill(os.getpid(), {int(signal.SIGSEGV)})")
        self.assertEqual(result.status, -signal.SIGSEGV)
        self.assertIn(VUID, result.err)
        self.assertIn("1 warning", result.err)
        self.assertIn("warning: It received SIGSEGV:\nassay-run:   1. build of x\n", result.err)

    def start(self, script):
        process = subprocess.Popen(
            [sys.executable, "-B", ASSAY_RUN, "--", sys.executable, "-B", "-c", LAYER + script],
            cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            encoding="utf-8", start_new_session=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.assertEqual(process.stdout.readline(), "ready\n")
        return process

    def test_termination_reaches_the_application(self):
        process = self.start("signal.signal(15, lambda *_: sys.exit(5)); load(); "
                             "print('ready', flush=True); time.sleep(60)")
        process.terminate()
        self.assertEqual(process.wait(), 5)

    def test_interrupt_from_the_terminal(self):
        process = self.start("signal.signal(2, lambda *_: sys.exit(6)); load(); find(); "
                             "print('ready', flush=True); time.sleep(60)")
        os.killpg(process.pid, signal.SIGINT)
        self.assertEqual(process.wait(), 99)
        self.assertIn(VUID, process.stderr.read())

    def test_ignored_signals_stay_ignored(self):
        script = "load(); end(); sys.exit(signal.getsignal(1) != signal.SIG_IGN)"
        process = subprocess.run(
            ["nohup", sys.executable, "-B", ASSAY_RUN, "--", sys.executable, "-B", "-c",
             LAYER + script], env=self.environment, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, cwd=self.folder, check=False)
        self.assertEqual(process.returncode, 0, process.stderr)

    def test_default_signals_stay_default(self):
        script = """
            load(); end()
            sys.exit(any(signal.getsignal(i) != signal.SIG_DFL for i in (1, 3, 15)))"""
        self.assertEqual(self.run_script(script).status, 0)


class Children(Runs):
    def test_a_launcher_ends_before_its_game(self):
        self.expect(self.run_script("""
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
            if os.fork() == 0:
                load()
                os.kill(os.getppid(), signal.SIGUSR1)
                time.sleep(0.5); find(); os._exit(0)
            signal.sigwait([signal.SIGUSR1])"""), 99, "waiting for process")

    def test_interrupt_ends_the_waiting(self):
        script = """
            if os.fork() == 0:
                load(); find()
                time.sleep(600)
            time.sleep(0.5)"""
        process = subprocess.Popen(
            [sys.executable, "-B", ASSAY_RUN, "--", sys.executable, "-B", "-c",
             LAYER + textwrap.dedent(script)], cwd=self.folder, env=self.environment,
            stderr=subprocess.PIPE, encoding="utf-8", start_new_session=True)
        self.addCleanup(process.stderr.close)
        self.assertIn("waiting for process", process.stderr.readline())
        process.send_signal(signal.SIGINT)
        status = process.wait()
        os.killpg(process.pid, signal.SIGKILL)
        self.assertEqual(status, 99)
        self.assertIn("not waiting for", process.stderr.read())


class Folders(Runs):
    def test_percent_in_the_name(self):
        self.assertEqual(self.run_script("load(); find()", "--record", "100%p").status, 99)
        self.assertEqual(len(list((self.folder / "100%p").glob("*/*.jsonl"))), 1)

    def test_nothing_is_left_without_record(self):
        self.run_script("load(); find()", TMPDIR=str(self.folder))
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_full_disk(self):
        # A limit on the size of files cuts lines as a full disk does.
        self.expect(self.run_script("""
            import resource
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))
            load()
            for _ in range(9):
                try: find()
                except OSError: pass
            sys.exit(0)"""), 99, "not written whole")  # those before are found

    def test_cut_line_in_a_clean_run(self):
        self.expect(self.run_script("""load(); write('{"Type": "Fin')"""), 97, "not written whole")


if __name__ == "__main__":
    main()
