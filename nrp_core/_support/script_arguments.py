"""The command line ``python -m MODULE [OPTIONS] SCRIPT [ARGUMENTS]`` of modules that run a user's script."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path


def script_arguments(
    parser: argparse.ArgumentParser, arguments: Sequence[str]
) -> tuple[argparse.Namespace, Path]:
    """Return the options and the absolute path of the script, which finds its own arguments in ``sys.argv``.

    A script that does not exist ends the program, with the usage.

    Args:
        parser: knows the options.
        arguments: those of the command line.
    """
    parser.add_argument("script", metavar="SCRIPT")
    parser.add_argument("arguments", metavar="ARGUMENTS", nargs=argparse.REMAINDER)
    given = parser.parse_args(arguments)
    script = Path(given.script)
    if not script.is_file():
        parser.error(f"there is no file {given.script}")
    sys.argv = [given.script, *given.arguments]
    return given, script.resolve()
