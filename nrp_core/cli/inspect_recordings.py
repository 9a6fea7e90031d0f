"""``nrp inspect`` of a recording, and ``--check`` of its integrity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from nrp_core._support.json_values import to_jsonable
from nrp_core.cli.output import NO, complain, document, size_text, warn
from nrp_core.cli.summary import print_problems, styled_headline
from nrp_core.clock import seconds
from nrp_core.experiment.running.result import recorded_judgement
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, SNAPSHOTS, STEPS, Role, device_group
from nrp_core.recording.reading.errata import errata_of
from nrp_core.recording.reading.integrity import IntegrityCheck
from nrp_core.recording.reading.mcap_messages import is_mcap
from nrp_core.recording.recording import Recording
from nrp_core.scene.randomization import Draw


def check_recording(path: Path, *, as_json: bool) -> None:
    """Check a recording, print the result, and end with exit code 1 if it has a flaw."""
    check = Recording(path).check()
    if as_json:
        document({"intact": check.intact, **to_jsonable(check)})
    else:
        for note in check.notes:
            complain(note, label="note", color="yellow")
        for flaw in check.flaws:
            complain(str(flaw))
        typer.echo(_verdict(path, check))
    raise typer.Exit(NO if check.flaws else 0)


def _verdict(path: Path, check: IntegrityCheck) -> str:
    files = f"{check.files} files of {size_text(check.size)} match their digests"
    if check.flaws:
        return f"{path}: {typer.style('not intact', fg='red', bold=True)}"
    if check.intact:
        return f"{path}: {typer.style('intact', fg='green', bold=True)}: {files}"
    steps = f"{check.chain.steps} steps match their hashes" if check.chain is not None else ""
    return f"{path}: no flaw found: {', '.join(filter(None, (files if check.files else '', steps)))}"


def is_recording(path: Path) -> bool:
    """Return whether a folder holds a recording, even an incomplete one, or a file begins like one."""
    if path.is_dir():
        return (path / MCAP_NAME).is_file() or (path / RUN_NAME).is_file()
    return path.is_file() and is_mcap(path)


@dataclass(slots=True)
class _TopicTotals:
    count: int = 0
    size: int = 0
    first_ns: int = 0
    last_ns: int = 0

    def add(self, t_ns: int, size: int) -> None:
        if not self.count:
            self.first_ns = t_ns
        self.count, self.size, self.last_ns = self.count + 1, self.size + size, t_ns


def inspect_recording(path: Path, *, as_json: bool, details: bool) -> None:
    """Print the contents of a recording; with details, each problem of its run."""
    recording = Recording(path)
    data = _data(recording)
    if not data["intact"]:
        advice = f"'nrp recover {path}' restores its intact part"
        warn(f"the recording is truncated or damaged; {advice}")
    for message in (*_contradictions(recording, data), *data["errata"]):
        warn(message)
    if as_json:
        document(data)
        return
    judgement = recorded_judgement(recording.run, data["end_s"])
    about, *rest = _lines(data)
    typer.echo(about)
    if judgement is not None:
        print_problems(judgement, details=details)
    for line in rest:
        typer.echo(line)
    if judgement is not None:
        typer.echo(styled_headline(judgement))


def _data(recording: Recording) -> dict[str, Any]:
    totals = {name: _TopicTotals() for name in recording.topics}
    snapshots_s: list[float] = []
    for topic, message in recording.raw():
        totals[topic.name].add(message.log_time, len(message.data))
        if topic.name == SNAPSHOTS:
            snapshots_s.append(seconds(message.log_time))
    run = recording.run
    steps = list(recording.messages({STEPS}))
    begin_s = seconds(min((t.first_ns for t in totals.values() if t.count), default=0))
    last_s = seconds(max((t.last_ns for t in totals.values() if t.count), default=0))
    end_s = seconds(steps[-1].t_ns) if steps else last_s  # a failed step leaves later messages
    judgement = recorded_judgement(run, end_s)
    sides = {side: dict(run.get(side) or {}).get("backend") for side in ("brain", "world")}
    return {
        "recording": recording.file,
        "intact": recording.complete,
        "bytes": recording.file.stat().st_size,
        "experiment": run.get("experiment"),
        **sides,
        "seed": run.get("seed"),
        "parameters": run.get("parameters") or {},
        "randomized": dict(run.get("world") or {}).get("randomized") or [],
        "recorded": run.get("recorded"),
        "state": run.get("state"),
        "complete": judgement and judgement.complete,
        "passed": judgement and judgement.passed,
        "problems": [problem.to_dict() for problem in judgement.problems] if judgement else [],
        "errata": [*_errata(recording, {n: t.count for n, t in totals.items()}, max(0, len(steps) - 1))],
        "continues": run.get("continues"),
        "begin_s": begin_s,
        "end_s": end_s,
        "steps": max(0, len(steps) - 1),
        "chain": steps[-1].message.chain if steps else None,
        "snapshots_s": snapshots_s,
        "topics": {
            name: {
                "type": topic.type_name, "role": topic.role, "messages": totals[name].count,
                "bytes": totals[name].size,
            }
            for name, topic in recording.topics.items()
        },
    }  # fmt: skip


def _errata(recording: Recording, counts: Mapping[str, int], steps: int) -> Iterator[str]:
    sensed = {
        name: n for name, n in counts.items() if recording.topics[name].role in (Role.SENSOR, Role.CAMERA)
    }
    return errata_of(recording.run, recording.file.parent, sensed, steps)


def _contradictions(recording: Recording, data: dict[str, Any]) -> Iterator[str]:
    """Yield the contradictions between the files of a recording; ``--check`` compares every byte."""
    run = recording.run
    if not run and recording.file.name == MCAP_NAME:
        yield f"{RUN_NAME} is missing: the experiment, its seed and its verdict are unknown"
    end_s = (run.get("result") or {}).get("sim_time_s")
    if data["intact"] and data["steps"] and end_s is not None and end_s != data["end_s"]:
        yield (
            f"the run ended at {end_s:g} s, and the messages end at {data['end_s']:g} s: they may be those "
            "of another run; --check compares them with their digest"
        )


def _lines(data: dict[str, Any]) -> Iterator[str]:
    sides = " and ".join(filter(None, (data["brain"], data["world"])))
    name = typer.style(str(data["experiment"] or data["recording"].name), bold=True)
    yield f"{name}: {sides}, seed {data['seed']}" if sides else name
    size = size_text(data["bytes"])
    yield f"  {data['begin_s']:g} s to {data['end_s']:g} s, {data['steps']} steps, {size}"
    for side, parameters in data["parameters"].items():
        for name, one in parameters.items():
            yield f"  {side} parameter {name} = {one['value']}{' ' + one['unit'] if one['unit'] else ''}"
    for drawn in data["randomized"]:
        yield f"  {Draw(**drawn)}"
    if data["recorded"]:
        yield f"  recorded {data['recorded']}, {data['state']}"
    if data["continues"]:
        yield f"  continues {data['continues']['recording']} at {seconds(data['continues']['t_ns']):g} s"
    if data["chain"]:
        yield f"  hash of the last step: {data['chain']}"
    if data["snapshots_s"]:
        yield f"  snapshots at {', '.join(f'{t_s:g}' for t_s in data['snapshots_s'])} s"
    topics = _with_groups(data["topics"])
    width = max(map(len, topics), default=0)
    for topic, (messages, kind) in topics.items():
        yield f"  {topic:<{width}}  {messages:>7}  {kind}"


def _with_groups(topics: dict[str, Any]) -> dict[str, tuple[int, str]]:
    """Return the number and type of messages of each topic, with one line for all devices of a group."""
    found: dict[str, tuple[int, str]] = {}
    for topic, about in topics.items():
        group = device_group(topic)
        name = topic if group is None else group[0]
        messages = about["messages"] + found.get(name, (0, ""))[0]
        found[name] = messages, about["type"]
    return found
