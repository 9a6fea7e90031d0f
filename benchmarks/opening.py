"""Whether public robots and rooms open on each engine, and how many findings their files have.

Give it files, or folders that are searched for URDF, SDF, worlds and MJCF; models and packages are found in
the folders, too:

    python benchmarks/opening.py FILE | FOLDER ... [--engines mujoco pybullet drake] [--search FOLDER ...]

Each file is read and opened in a process of its own, which may use ``--cpu-s`` of CPU time, and is simulated
for 0.1 s. Outcomes are: opens; refused, with a message of the program; crashes, with any other error;
diverges, if a pose is not a number; slow, beyond the time. First comes a table with the CPU time (s) for each
file, then the number of files by outcome, the median number of findings, and why files did not open.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from math import isfinite
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median

from conditions import print_conditions

from nrp_core.errors import NrpError
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds

RUN_NS = 100_000_000
SUFFIXES = (".urdf", ".sdf", ".world", ".xml", ".mjcf")
ROOTS = ("<robot", "<sdf", "<mujoco>", "<mujoco ")
MARKS = ("model.config", "package.xml")
"""Files in the folder of a model or package."""

Outcome = tuple[str, str, float]
"""The outcome, its reason and the CPU time to open (s)."""
Result = tuple[int, dict[str, Outcome]]
"""The number of findings, and the outcome for each engine."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    installed = [name for name in ("mujoco", "pybullet", "drake") if name in worlds().names()]
    parser.add_argument("places", nargs="+", type=Path, help="files and folders")
    parser.add_argument("--engines", nargs="+", default=installed, help="world backends")
    parser.add_argument("--search", nargs="+", type=Path, default=[], help="more folders of models, packages")
    parser.add_argument("--cpu-s", type=int, default=60, help="CPU time of a file")
    asked = parser.parse_args()
    print_conditions()
    engines: Sequence[str] = asked.engines
    print("|", " | ".join(("file", "findings", *engines)), "|")
    print("|---" * (2 + len(engines)) + "|")
    search = [*searched([*asked.places, *asked.search])]
    for engine in engines:
        worlds().load(engine)  # once, before the processes
    results: dict[Path, Result] = {}
    for path in files(asked.places):
        count, outcomes = results[path] = isolated(path, search, engines, asked.cpu_s)
        row = [f"{kind}, {cpu_s:.1f}" for kind, _, cpu_s in outcomes.values()]
        print("|", " | ".join((f"{path.parent.name}/{path.name}", str(count), *row)), "|", flush=True)
    if results:
        summarize(results, engines)


def summarize(results: dict[Path, Result], engines: Sequence[str]) -> None:
    """Print the number of files by outcome, and those that did not open."""
    print(f"\n{len(results)} files; findings: median {median(count for count, _ in results.values()):g}")
    for engine in engines:
        kinds = Counter(outcomes[engine][0] for _, outcomes in results.values())
        print(f"{engine}:", ", ".join(f"{kind} {count}" for kind, count in kinds.most_common()))
    for path, (_, outcomes) in results.items():
        for reason in {f"{kind}: {why}" for kind, why, _ in outcomes.values() if kind != "opens"}:
            failed = [engine for engine, (kind, why, _) in outcomes.items() if f"{kind}: {why}" == reason]
            print(f"- {path.parent.name}/{path.name} ({', '.join(failed)}) {reason}")


def files(places: Sequence[Path]) -> Iterator[Path]:
    """Yield the robots and rooms in files and folders."""
    for place in places:
        found = [place] if place.is_file() else sorted(each for each in place.rglob("*") if each.is_file())
        for path in found:
            if path == place or (path.suffix in SUFFIXES and is_whole(path)):
                yield path


def is_whole(path: Path) -> bool:
    """Return whether a file has a model: others are settings, or parts that another file includes."""
    text = path.read_text(errors="replace")
    return any(root in text for root in ROOTS) and ("<link" in text or "<body" in text or "<include" in text)


def searched(places: Sequence[Path]) -> Iterator[Path]:
    """Yield the folders in which models and packages are."""
    for place in places:
        folder = place if place.is_dir() else place.parent
        found = {mark.parent.parent for name in MARKS for mark in folder.rglob(name)}
        yield from (folder, *sorted(found))


def isolated(path: Path, search: Sequence[Path], engines: Sequence[str], cpu_s: int) -> Result:
    """Return the result for a file, from a process of its own."""
    context = get_context("fork")
    mine, theirs = context.Pipe(duplex=False)
    process = context.Process(target=opened, args=(path, search, engines, cpu_s, theirs))
    process.start()
    theirs.close()
    count, outcomes = 0, {}
    with suppress(EOFError):
        count = mine.recv()
        for engine in engines:
            outcomes[engine] = mine.recv()
    process.join()
    slow = cpu_s <= resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime and process.exitcode == -24
    ended = (
        ("slow", f"over {cpu_s} s", float(cpu_s)) if slow else ("crashes", f"exit {process.exitcode}", 0.0)
    )
    return count, {engine: outcomes.get(engine, ended) for engine in engines}


def opened(
    path: Path, search: Sequence[Path], engines: Sequence[str], cpu_s: int, results: Connection
) -> None:
    """Send the number of findings, then the outcome for each engine."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 1))
    try:
        if path.suffix == ".urdf":
            model = read_model(path, search_path=search)
            scene, count = Scene((model,)), len(model.warnings)
        else:
            scene = read_scene(path, search_path=search)
            count = len(scene.warnings)
    except Exception as error:  # noqa: BLE001 - any error is an outcome
        results.send(0)
        for _ in engines:
            results.send((kind_of(error), reason_of(error), time.process_time()))
        return
    results.send(count)
    for engine in engines:
        results.send(outcome_on(engine, scene))


def outcome_on(engine: str, scene: Scene) -> Outcome:
    """Return the outcome of a scene on an engine."""
    began = time.process_time()
    backend = worlds().load(engine)
    try:
        with backend.open(scene, seed=1, options=backend.options()) as world:
            took = time.process_time() - began
            world.run_until(-(-RUN_NS // world.engine.step_ns) * world.engine.step_ns)
            poses = [world.model_motion(model.name).pose for model in scene.models]
    except Exception as error:  # noqa: BLE001 - any error is an outcome
        return kind_of(error), reason_of(error), time.process_time() - began
    valid = all(map(isfinite, (value for pose in poses for value in (*pose.position, *pose.orientation))))
    return "opens" if valid else "diverges", "", took


def kind_of(error: Exception) -> str:
    return "refused" if isinstance(error, NrpError) else "crashes"


def reason_of(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".replace("\n", " ")[-200:]


if __name__ == "__main__":
    main()
