"""``nrp replay``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import Json, Overwrite, RecordingPath, usage_errors
from nrp_core.cli.output import NO, document, warn

if TYPE_CHECKING:
    from nrp_core.recording.reading.integrity import Flaw
    from nrp_core.recording.replay.replay import ReplayResult

RECORDED = "recorded"


def _side(name: str) -> Any:
    return typer.Option(
        f"--{name}", metavar=RECORDED, envvar=f"NRP_REPLAY_{name.upper()}",
        help=f"Play back the recorded {name} instead of simulating it.",
    )  # fmt: skip


def replay(
    recording: RecordingPath,
    verify: Annotated[
        bool,
        typer.Option("--verify", envvar="NRP_VERIFY", help="Stop at the first difference and fail."),
    ] = False,
    brain: Annotated[str | None, _side("brain")] = None,
    world: Annotated[str | None, _side("world")] = None,
    start: Annotated[
        str | None, typer.Option("--from", metavar="TIME", help="Continue from this time, e.g. 12.3s.")
    ] = None,
    until: Annotated[
        str | None, typer.Option(metavar="TIME", envvar="NRP_UNTIL", help="Stop at this time, e.g. 20s.")
    ] = None,
    functions: Annotated[
        list[Path] | None,
        typer.Option(
            "--transfer-functions",
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="An edited file of transfer functions; it replaces the recorded file of the same name.",
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", envvar="NRP_RECORD", help="Record the replay into a new folder."),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Run a recording again and report whether it is identical; this executes code from the recording.

    With --verify, a recording that was changed or damaged is not run, because it would prove nothing.
    """
    from nrp_core._support.used_files import FilesRead
    from nrp_core.cli.progress import display
    from nrp_core.cli.summary import print_problems
    from nrp_core.recording.layout import check_folder
    from nrp_core.recording.recording import Recording
    from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict

    if verify and record is not None:
        raise typer.BadParameter(
            "cannot be combined with --record: it stops at a difference", param_hint="--verify"
        )
    with usage_errors("DIR"):
        source = Recording(recording)
    if record is not None:
        with usage_errors("--record"):
            check_folder(record, overwrite=overwrite)
    check = source.check()
    if verify and check.flaws:
        _refuse(check.flaws, as_json=json)
    sides = frozenset(
        name for name, given in (("brain", brain), ("world", world)) if _is_recorded(name, given)
    )
    request = ReplayRequest(
        sides,  # type: ignore[arg-type]
        _ns("--from", start),
        _ns("--until", until),
        tuple(functions or ()),
        record,
        overwrite=overwrite,
    )
    with (
        display() as shown,
        FilesRead() as files,
        Replay(source, request, shown.begin_task, files=files, check=check) as again,
    ):
        outcome = again.verify() if verify else again.go()
        result = again.run.result()
    for warning in outcome.warnings:
        warn(str(warning))
    if json:
        document({
            "identical": outcome.identical, "verdict": outcome.verdict, **_data(outcome),
            "result": result.to_dict(),
        })  # fmt: skip
    else:
        typer.echo(_verdict(outcome))
        if outcome.error is not None and outcome.difference is None:
            typer.echo(f"it ended like the recorded run: {outcome.error}")
        if not result.complete:
            typer.echo("the run is not complete:")
            print_problems(result.judgement, details=False)
        if record is not None:
            typer.echo(f"recorded in {record}")
    proved = outcome.verdict in (ReplayVerdict.IDENTICAL, ReplayVerdict.SAME)
    raise typer.Exit(NO if verify and not proved else 0)


def _refuse(flaws: Sequence[Flaw], *, as_json: bool) -> None:
    """Report that a recording was changed or damaged, and end."""
    if as_json:
        document({"identical": False, "verdict": "not identical", "flaws": flaws})
    else:
        typer.echo(_not_identical(flaws))
    raise typer.Exit(NO)


def _verdict(outcome: ReplayResult) -> str:
    if outcome.difference is not None:
        return typer.style("differs", fg="red", bold=True) + f" first at {outcome.difference}"
    if outcome.flaws or not outcome.steps:
        return _not_identical(outcome.flaws)
    span = f"{outcome.from_ns * 1e-9:g} s to {outcome.until_ns * 1e-9:g} s, {outcome.steps} steps"
    left_out = f"; not compared: {', '.join(outcome.not_compared)}" if outcome.not_compared else ""
    return typer.style(str(outcome.verdict), fg="green", bold=True) + f": {span}{left_out}"


def _not_identical(flaws: Sequence[Flaw]) -> str:
    reasons = "; ".join(map(str, flaws)) or "not a single step was compared"
    return typer.style("not identical", fg="red", bold=True) + f": {reasons}"


def _data(outcome: ReplayResult) -> dict[str, Any]:
    from nrp_core._support.json_values import to_jsonable

    return dict(to_jsonable(outcome))


def _is_recorded(side: str, given: str | None) -> bool:
    if given not in (None, RECORDED):
        raise typer.BadParameter(
            f"a {side} can only be '{RECORDED}' here, not '{given}'; for another backend, use nrp run DIR "
            f"--{side} {given}",
            param_hint=f"--{side}",
        )
    return given == RECORDED


def _ns(option: str, text: str | None) -> int | None:
    from nrp_core.quantities import time_ns

    if text is None:
        return None
    with usage_errors(option):
        return time_ns(text)
