"""``nrp inspect --check``: check that a recording is unchanged and undamaged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from nrp_core._support.json_values import to_jsonable
from nrp_core.cli.failure import NO, complain
from nrp_core.cli.output import document, size_text
from nrp_core.recording.reading.check import Check
from nrp_core.recording.reading.recording import Recording


def check_recording(path: Path, *, as_json: bool) -> None:
    """Check a recording, print the result, and end with exit code 1 if it has a flaw."""
    check = Recording(path).check()
    if as_json:
        document(_data(check))
    else:
        for note in check.notes:
            complain(note, label="note", color="yellow")
        for flaw in check.flaws:
            complain(str(flaw))
        typer.echo(_verdict(path, check))
    raise typer.Exit(NO if check.flaws else 0)


def _data(check: Check) -> dict[str, Any]:
    return {"intact": check.intact, **to_jsonable(check)}


def _verdict(path: Path, check: Check) -> str:
    files = f"{check.files} files of {size_text(check.size)} match their digests"
    if check.flaws:
        return f"{path}: {typer.style('not intact', fg='red', bold=True)}"
    if check.intact:
        return f"{path}: {typer.style('intact', fg='green', bold=True)}: {files}"
    steps = f"{check.chain.steps} steps match their hashes" if check.chain is not None else ""
    return f"{path}: no flaw found: {', '.join(filter(None, (files if check.files else '', steps)))}"
