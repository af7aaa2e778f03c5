# SPDX-License-Identifier: Apache-2.0
"""The command line of assay-run."""

import argparse
import os
import shlex

from .settings import SettingFailure, check_settings, did_you_mean, known_settings, words_of

DESCRIPTION = """\
Runs an application with the Assay validation layer enabled, in it and in its child processes. Then
prints the findings and a summary, and sets the exit status."""

EPILOG = """\
exit status:
  the application's own   there is no finding
  99 (--error-exitcode)   there are findings that the baseline does not have
  98                      the layer was not loaded in any process
  97                      a record is damaged (is the disk full?), so that findings may be missing
  2                       wrong arguments, or an unreadable baseline or record
  126, 127                the application cannot be started, or is not found
  If a signal ends the application, assay-run ends itself with the same signal. Findings before it are
  printed.

baseline: one known finding a line: an id; ID@GLOB, where GLOB matches the debug name of an object of
the finding, or one of its labels; ID@fn:GLOB, a function that called the command; or ID@file:GLOB, its
source file. ID@A & B needs both. # begins a comment.

expected findings: inside a debug label "assay:expect ID" that the application opens, findings with this
id do not count. A region without one counts as a finding.

examples:
  assay-run -- ./app --frames 10
  assay-run --lavapipe --everything --junit assay.xml -- ./app
  assay-run --write-baseline known.txt -- ./app; assay-run --baseline known.txt -- ./app
  assay-run --merge host1/record host2/record --html assay.html"""


SET_BY_ASSAY_RUN = ("log_format", "log_filename")


def setting(text):
    key, separator, value = text.partition("=")
    if not separator or not key.replace("_", "").isalnum():
        raise argparse.ArgumentTypeError(f"not KEY=VALUE: {text}")
    if key.lower() in SET_BY_ASSAY_RUN:
        raise argparse.ArgumentTypeError(f"assay-run sets {key.lower()} itself; see --record")
    return key.lower(), value


def exitcode(text):
    if not text.isdecimal() or not 1 <= int(text) <= 125:
        raise argparse.ArgumentTypeError("not a number from 1 to 125")
    return int(text)


def is_writable(path):
    """A mistake in the name of a report should not cost a run."""
    folder = os.path.dirname(path) or "."
    return os.access(path if os.path.exists(path) else folder, os.W_OK) and not os.path.isdir(path)


def make_parser():
    parser = argparse.ArgumentParser(
        prog="assay-run", description=DESCRIPTION, epilog=EPILOG, allow_abbrev=False,
        usage="assay-run [options] -- application [argument...]\n"
              "       assay-run --merge RECORD... [options]",
        formatter_class=argparse.RawDescriptionHelpFormatter)
    layer = parser.add_argument_group("layer")
    settings = known_settings() or {}
    for name in ("level", "backend"):
        layer.add_argument(f"--{name}", choices=words_of(settings[name]) if name in settings else None)
    layer.add_argument("--everything", action="store_true",
                       help="all checks, by setting preset=everything: level content, hazards, guarded "
                            "builds, advice, full call sites and a record of all builds; a setting that "
                            "is given, here or in the environment, wins over it")
    layer.add_argument("--set", dest="settings", metavar="KEY=VALUE", type=setting, action="append",
                       default=[], help="any other setting of the layer; may be repeated: " +
                                          ", ".join(key for key in settings if key not in SET_BY_ASSAY_RUN))
    layer.add_argument("--lavapipe", action="store_true", help="run on Mesa's CPU driver")
    layer.add_argument("--with-khronos", action="store_true",
                       help="also enable the Khronos validation layer; its messages do not count")
    layer.add_argument("--count-khronos", action="store_true",
                       help="also enable the Khronos validation layer, and count its errors as findings; "
                            "what both layers report counts once")
    layer.add_argument("--stop-at-first", action="store_true",
                       help="end the application at the first finding that the baseline does not have")
    reports = parser.add_argument_group("reports")
    reports.add_argument("--live", action=argparse.BooleanOptionalAction, default=None,
                         help="print findings while the application runs (default: on a terminal)")
    for name, text in (("junit", "for Jenkins, GitLab and others"),
                       ("sarif", "for code scanning"),
                       ("json", "everything, with the verdict"),
                       ("html", "one page to look at, without other files; sets record_builds=true, and draws the "
                                "scene at level content")):
        reports.add_argument(f"--{name}", metavar="FILE", help=text)
    reports.add_argument("--github", action="store_true",
                         help="print annotations for GitHub Actions")
    reports.add_argument("--record", metavar="FOLDER",
                         help="keep the records of the processes, for --merge")
    reports.add_argument("--capture", metavar="FOLDER",
                         help="write all builds with their data to a new folder, which assay-scene "
                              "reads; sets level=content")
    reports.add_argument("--scene", metavar="FILE",
                         help="a page about what was built: what accuracy costs on this scene, where it is fragile, "
                              "what its effects cost and what it wastes (assay-scene report); captures, and sets "
                              "level=content and advice=true")
    reports.add_argument("--quiet", action="store_true", help="print no summary")
    verdict = parser.add_argument_group("verdict")
    verdict.add_argument("--error-exitcode", metavar="N", type=exitcode, default=99,
                         help="exit status if there are findings (default: 99)")
    verdict.add_argument("--advice-is-error", action="store_true",
                         help="advice counts as findings; sets advice=true")
    verdict.add_argument("--baseline", metavar="FILE", help="known findings, which do not count")
    verdict.add_argument("--strict-baseline", action="store_true",
                         help="lines of the baseline without a finding count as findings")
    verdict.add_argument("--write-baseline", metavar="FILE",
                         help="write the findings as a baseline; they do not count then")
    verdict.add_argument("--merge", nargs="+", metavar="RECORD",
                         help="run nothing; join records (files, or folders of --record)")
    return parser


def explain_unknown(parser, words, has_command):
    """Returns what to do about words that are no options: mostly an application without -- before it."""
    first = words[0]
    if not first.startswith("-"):
        return f"no option: {first}" if has_command else \
            f"write -- before the application: -- {shlex.join(words)}"
    known = [name for action in parser._actions for name in action.option_strings]  # pylint: disable=protected-access
    return f"unknown option: {first}{did_you_mean(first, known)}"


def parse_arguments(words):
    """Splits at --, because the application has options of its own."""
    parser = make_parser()
    command = []
    if "--" in words:
        place = words.index("--")
        words, command = words[:place], words[place + 1:]
    arguments, unknown = parser.parse_known_args(words)
    if unknown:
        parser.error(explain_unknown(parser, unknown, bool(command)))
    arguments.command = command
    if bool(command) == bool(arguments.merge):
        parser.error("name an application after --, or records after --merge")
    try:
        check_settings(arguments.settings)
    except SettingFailure as failure:
        parser.error(str(failure))
    arguments.with_khronos |= arguments.count_khronos
    if arguments.strict_baseline and not arguments.baseline:
        parser.error("--strict-baseline needs --baseline")
    if arguments.write_baseline and arguments.strict_baseline:
        parser.error("--strict-baseline has no meaning with --write-baseline")
    if arguments.scene and arguments.merge:
        parser.error("--scene needs an application: records have no captures")
    for name in ("junit", "sarif", "json", "html", "scene", "write_baseline"):
        path = getattr(arguments, name)
        if path and not is_writable(path):
            parser.error(f"--{name.replace('_', '-')}: {path} cannot be written")
    return arguments
