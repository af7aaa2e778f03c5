# SPDX-License-Identifier: Apache-2.0
"""The exit status: the application's, or what assay-run makes of the records of its processes; and while the
application runs: findings are printed, and the first one may end it. layer_test.py has what an application under the
layer can show."""

import os
import pty
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


LONG = 600  # seconds: a test that waits for the end of the application fails by its time limit


class Live(Runs):
    def test_findings_are_printed_while_the_application_runs(self):
        """The application goes on when it reads a line, which the test writes after the finding."""
        script = "load(); find(); input(); find(); end()"
        with subprocess.Popen(
                [sys.executable, "-B", ASSAY_RUN, "--live", "--", sys.executable, "-c",
                 LAYER + script], cwd=self.folder, env=self.environment, encoding="utf-8",
                stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            first = [process.stderr.readline() for _ in range(2)]
            process.stdin.write("\n")
            process.stdin.close()
            rest = process.stderr.read()
        self.assertIn(VUID, first[0])
        self.assertIn("infoCount is 0.", first[1])
        self.assertNotIn("infoCount is 0.", rest)  # printed once
        self.assertIn("2 times", rest)
        self.assertIn("1 finding (reported 2 times)", rest)

    def run_on_terminal(self, *options, waits):
        """Returns what stands on the terminal. `waits`: the application ends only after the finding was
        printed."""
        script = "load(); find(); input(); print('last words', file=sys.stderr); end()"
        try:
            outer, inner = pty.openpty()
        except OSError as error:  # a container without /dev/pts
            self.skipTest(str(error))
        with subprocess.Popen(
                [sys.executable, "-B", ASSAY_RUN, *options, "--", sys.executable, "-c", LAYER + script],
                cwd=self.folder, env=self.environment, stdin=subprocess.PIPE, stderr=inner) as process:
            os.close(inner)
            text = b""
            while True:
                if not process.stdin.closed and (not waits or VUID.encode() in text):
                    process.stdin.write(b"\n")
                    process.stdin.close()
                try:
                    text += os.read(outer, 4096)
                except OSError:  # the other end is closed
                    break
        os.close(outer)
        return text.decode()

    def test_default_on_a_terminal(self):
        text = self.run_on_terminal(waits=True)
        self.assertLess(text.index(VUID), text.index("last words"))

    def test_not_live_on_a_terminal(self):
        text = self.run_on_terminal("--no-live", waits=False)
        self.assertLess(text.index("last words"), text.index(VUID))

    def test_half_a_line(self):
        """A line is read when it is whole."""
        script = """
            load()
            text = json.dumps({"Type": "Finding", "pid": os.getpid(), "time": TIME, "Severity": "Error",
                               "VUID": VUID, "MessageID": "0x1", "Objects": [], "MainMessage": "Half."})
            write(text[:40]); time.sleep(0.3); write(text[40:] + "\\n"); time.sleep(0.3); end()"""
        self.expect(self.run_script(script, "--live"), 99, "Half.", "1 finding in 1 process")


class StopAtFirst(Runs):
    def test_first_finding_ends_the_run(self):
        script = f"load(); find(); time.sleep({LONG})"
        self.expect(self.run_script(script, "--stop-at-first"), 99, "1 finding in 1 process",
                    "the first finding has ended the run")

    def test_findings_while_the_application_ends(self):
        """The signal comes again while a busy machine is slow to handle it."""
        script = f"""
            import itertools
            turns = itertools.count()
            signal.signal(signal.SIGTERM, lambda *_: next(turns) or (find(), end(), sys.exit(0)))
            load(); find(); time.sleep({LONG})"""
        self.expect(self.run_script(script, "--stop-at-first"), 99,
                    "has ended the run (--stop-at-first); 1 more came before the application had ended")

    def test_signal_is_ignored(self):
        script = f"signal.signal(signal.SIGTERM, signal.SIG_IGN); load(); find(); time.sleep({LONG})"
        self.expect(self.run_script(script, "--stop-at-first"), 99, "has ended the run")

    def test_process_that_outlives_the_application(self):
        script = f"""
            ours, theirs = os.pipe()
            if os.fork() == 0:
                load(); os.write(theirs, b"."); time.sleep(0.5); find(); time.sleep({LONG})
            os.read(ours, 1)"""
        self.expect(self.run_script(script, "--stop-at-first"), 99, "has ended the run")

    def test_nothing_to_stop_for(self):
        result = self.expect(self.run_script("load(); end(); sys.exit(3)", "--stop-at-first"), 3)
        self.assertNotIn("has ended the run", result.err)

    def test_known_findings_do_not_count(self):
        (self.folder / "known.txt").write_text(VUID)
        script = textwrap.dedent("load(); find(); time.sleep(0.5); end(); sys.exit(4)")
        self.expect(self.run_script(script, "--stop-at-first", "--baseline", "known.txt"), 4)

    def test_warnings_do_not_count(self):
        script = "load(); find(Severity='Warning'); time.sleep(0.5); end(); sys.exit(4)"
        self.expect(self.run_script(script, "--stop-at-first"), 4)


if __name__ == "__main__":
    main()
