"""The command line: a thin shell that parses, calls the workflow and prints."""

import sys

from fullwell.cli.overview import INTERRUPTED, overview, version_line


def main() -> None:
    """Run the command line; `SystemExit` carries the exit status of RESULTS section 1.

    The overview and the version are printed without loading what the commands need, so that they come at once.
    """
    arguments = sys.argv[1:]
    if arguments in (["--help"], ["-h"]):
        sys.stdout.write(overview())
    elif arguments == ["--version"]:
        sys.stdout.write(version_line())
    else:
        try:
            from fullwell.cli.app import app  # noqa: PLC0415 - `fullwell --help` must not wait for it

            app(prog_name="fullwell")
        except KeyboardInterrupt:
            sys.exit(INTERRUPTED)
