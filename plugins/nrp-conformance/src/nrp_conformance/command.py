"""``nrp conformance``."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from nrp_core.cli.options import Json, Overwrite, require_distinct, require_writable
from nrp_core.cli.output import NO, document


class TestedSide(StrEnum):
    """The side of the loop under test."""

    BRAIN = "brain"
    WORLD = "world"


class KitLevel(StrEnum):
    """How much is tested; each level contains the one before it."""

    CONTRACT = "contract"
    CORE = "core"
    FULL = "full"


def conformance(
    kind: Annotated[
        TestedSide, typer.Argument(metavar="SIDE", help="The simulated side of the loop: brain or world.")
    ],
    name: Annotated[str, typer.Argument(metavar="NAME", help="The name of an installed backend.")],
    options: Annotated[
        list[str] | None,
        typer.Option(
            "--options",
            "-o",
            metavar="KEY=VALUE",
            help="An option of the backend, its value in YAML; repeatable.",
        ),
    ] = None,
    level: Annotated[
        KitLevel,
        typer.Option(
            help="Tests to run: core adds capabilities and accuracy; full adds statistics, pairs and speed."
        ),
    ] = KitLevel.CORE,
    scene: Annotated[
        Path | None,
        typer.Option("--scene", metavar="FILE", help="The scene of a world that reads files of its own."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE", help="Also write the report as JSON.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Test whether a backend meets its contract, has its declared capabilities and is accurate enough."""
    _require_backend(kind, name)
    require_writable(report, "--report", overwrite=overwrite)
    found = _run(kind, name, _parse_options(options or []), level, _existing(scene))
    if report is not None:
        _write(report, found)
    if json:
        document(found)
    else:
        _print(found)
    if not found["conforms"]:
        raise typer.Exit(NO)


def _require_backend(kind: TestedSide, name: str) -> None:
    from nrp_core import brains, worlds

    (brains() if kind is TestedSide.BRAIN else worlds()).provider(name)


def _existing(scene: Path | None) -> str:
    if scene is None:
        return ""
    if not scene.is_file():
        raise typer.BadParameter(f"{scene} must be an existing file", param_hint="--scene")
    return str(scene.resolve())


def _parse_options(options: list[str]) -> dict[str, Any]:
    from nrp_core.experiment import Place, parse_tree

    require_distinct(options, "--options")
    pairs = [option.partition("=") for option in options]
    for key, equals, _ in pairs:
        if not (key and equals):
            raise typer.BadParameter(f"an option is written KEY=VALUE, not '{key}'", param_hint="--options")
    return {key: parse_tree(value, Place(override=f"{key}={value}")).plain() for key, _, value in pairs}


def _run(kind: TestedSide, name: str, options: dict[str, Any], level: KitLevel, scene: str) -> Any:
    """Run the tests in a separate process; the output of pytest goes to standard error."""
    from nrp_conformance.run import ALONE
    from nrp_core.errors import ExperimentError, NrpError

    with TemporaryDirectory() as folder:
        written = Path(folder, "report.json")
        asked = {"kind": kind, "name": name, "options": options, "level": level, "scene": scene}
        command = [sys.executable, "-P", "-m", "pytest", *ALONE, "--tb=short", "-p", "nrp_conformance.plugin"]
        command += ["--prove", json.dumps(asked), "--write", str(written)]
        code = _run_command(command)
        if not written.exists():
            raise NrpError(
                f"the tests of {kind} '{name}' ended with exit code {code} and without a report; "
                "see their output above"
            )
        found = json.loads(written.read_text("utf-8"))
    if "refused" in found:
        raise ExperimentError(found["refused"])
    return found


def _run_command(command: list[str]) -> int:
    """Run a command whose output goes to standard error, and return its exit code.

    It gets its own process group: Ctrl-C reaches only the waiting process, which then kills the group.
    """
    with subprocess.Popen(command, stdout=2, process_group=0) as process:
        try:
            return process.wait()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise


def _write(path: Path, found: Any) -> None:
    from nrp_core.utilities import replace_file

    replace_file(path, json.dumps(found, indent=2, ensure_ascii=False) + "\n")


def _print(found: Any) -> None:
    from nrp_conformance.report import lines

    for line in lines(found):
        typer.echo(line)
