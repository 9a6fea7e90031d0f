"""Write an experiment of the platform as a folder in our own format."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from nrp_core.clock import milliseconds
from nrp_core.dsl.function import Flow
from nrp_core.dsl.mocks import MockWorld
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.prepare import Examination, quietly
from nrp_core.experiment.reader import read_yaml
from nrp_core.world.scene.model import Scene
from nrp_legacy.convert.brain import write_brain
from nrp_legacy.convert.machines import events_of
from nrp_legacy.convert.models import Models, add_controllers
from nrp_legacy.convert.python import Piece, piece_of
from nrp_legacy.documents import is_active, priority_of
from nrp_legacy.functions import part_source
from nrp_legacy.maker import LegacyMaker

FILE, FUNCTIONS, REPORT = "experiment.yaml", "transfer_functions", "import.md"


@dataclass
class Report:
    """What differs from the original.

    Attributes:
        changed: what is written otherwise and means the same.
        left_out: what has no counterpart.
        noted: what a run of the original leaves out or replaces as well.
    """

    changed: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)


def write_folder(experiment: Experiment, folder: Path) -> Report:
    """Write an experiment into a folder.

    Args:
        experiment: as :func:`nrp_legacy.reader.read_exc` returns it.
        folder: where to; it is made.

    Raises:
        ExperimentError: it cannot be read.
    """
    maker = experiment.maker
    assert isinstance(maker, LegacyMaker)
    folder.mkdir(parents=True, exist_ok=True)
    return _Import(experiment, maker, folder).done()


class _Import:
    def __init__(self, experiment: Experiment, maker: LegacyMaker, folder: Path) -> None:
        self._experiment, self._maker, self._folder = experiment, maker, folder
        self._examined = Examination(experiment, quietly)
        self._examined.collector.raise_errors()
        self._report = Report(noted=[str(one.message) for one in self._examined.collector.findings])

    def done(self) -> Report:
        exp = self._experiment
        document: dict[str, Any] = {"name": exp.name}
        if exp.description:
            document["description"] = exp.description
        document |= {
            "timestep": f"{milliseconds(exp.timestep):g} ms",
            "duration": f"{milliseconds(exp.duration) / 1000:.10g} s",
            "seed": exp.seed,
            "brain": {"backend": exp.brain.backend, **self._brain()},
            "world": {"backend": exp.world.backend, **self._world()},
            "transfer_functions": [f"{FUNCTIONS}/{name}" for name in self._functions()],
            "tf_time": exp.tf_time, "on_error": exp.on_error, "strict": False, "csv_folder": "csv",
        }  # fmt: skip
        if (self._folder / "models").is_dir():
            document["models"] = ["models"]
        document |= {
            key: value for key, value in (("aliases", self._aliases()), ("events", self._events())) if value
        }
        with (self._folder / FILE).open("w", encoding="utf-8") as file:
            YAML().dump(document, file)
        self._check()
        self._write_report()
        return self._report

    def _brain(self) -> dict[str, Any]:
        network = self._examined.network
        assert network is not None
        names, exp = list(self._maker.bibi.populations), self._experiment
        section, changed = write_brain(exp.brain.model, network, names, exp.seed, self._folder)
        self._report.changed += changed
        return section

    def _world(self) -> dict[str, Any]:
        models, world = Models(self._maker.library, self._folder), self._experiment.world
        robots: dict[str, Any] = {}
        scene = models.copy(world.scene)
        for name, robot in world.robots.items():
            robots[name] = {"model": models.copy(robot.model)}
            if robot.pose is not None:
                robots[name]["pose"] = list(robot.pose)
            self._commanded(name, self._folder / robots[name]["model"])
        return {"scene": scene, **({"robots": robots} if robots else {})}

    def _commanded(self, name: str, path: Path) -> None:
        """Write the controllers that only commands told of into the file of a robot."""
        model = next((one for one in self._scene.models if one.name == name), None)
        added = [one for one in model.controllers if one.gains is None] if model else []
        if added and add_controllers(path, added):
            joints = ", ".join(one.joint for one in added)
            self._report.changed.append(
                f"{path.name}: controllers of the joints that are commanded: {joints}"
            )

    @property
    def _scene(self) -> Scene:
        assert self._examined.scene is not None
        return self._examined.scene

    def _aliases(self) -> dict[str, str]:
        return self._maker.aliases(MockWorld(scene=self._scene), self._examined.functions)

    # -- transfer functions

    def _functions(self) -> list[str]:
        (self._folder / FUNCTIONS).mkdir(exist_ok=True)
        resources = self._maker.library.folder / "resources"
        if resources.is_dir():
            shutil.copytree(resources, self._folder / FUNCTIONS, dirs_exist_ok=True)
        pieces = self._pieces()
        shared = {
            name for stem, piece in pieces.items() for name in piece.lacks
            if any(name in other.defines for key, other in pieces.items() if key != stem)
        }  # fmt: skip
        if shared:
            self._report.changed.append(
                f"one file of all transfer functions, which share {', '.join(sorted(shared))}"
            )
            texts = "\n\n".join(piece.text for piece in pieces.values())
            defined = frozenset().union(*(piece.defines for piece in pieces.values()))
            pieces = {"all_functions": Piece(texts, (), "", defined, frozenset())}
        order = self._in_order(pieces)
        for stem in order:
            (self._folder / FUNCTIONS / f"{stem}.py").write_text(
                pieces[stem].text + self._tail(pieces[stem], order, pieces), encoding="utf-8"
            )
        return [f"{stem}.py" for stem in order]

    def _pieces(self) -> dict[str, Piece]:
        found: dict[str, Piece] = {}
        bibi = self._maker.bibi
        for element in bibi.functions:
            try:
                sources = part_source(element, bibi.element, self._maker.library)
                pieces = [piece_of(source) for source in sources]
            except ExperimentError:
                continue  # told by the examination
            for source, piece in zip(sources, pieces, strict=True):
                names = [one.name for one in self._examined.functions if one.name in piece.defines]
                if bibi.nest_units:
                    piece = Piece(
                        piece.text,
                        piece.changes,
                        piece.obstacle or _in_nest_units(piece),
                        piece.defines,
                        piece.lacks,
                    )
                if piece.obstacle or not names:
                    if names:
                        self._report.left_out.append(
                            f"{', '.join(names)} ({source.path.name}): {piece.obstacle}"
                        )
                    continue
                self._report.changed += [f"{names[0]}: {change}" for change in piece.changes]
                extra = "".join(
                    f"\n{name}.priority = {priority_of(element)}" for name in names if priority_of(element)
                )
                extra += "".join(f"\n{name}.active = False" for name in names if not is_active(element))
                text = piece.text + (extra + "\n" if extra else "")
                found[names[0]] = Piece(text, piece.changes, "", piece.defines, piece.lacks)
        return found

    def _names_in(self, piece: Piece) -> list[str]:
        return [one.name for one in self._examined.functions if one.name in piece.defines]

    def _in_order(self, pieces: dict[str, Piece]) -> list[str]:
        """Return files in the order of their first functions."""
        place = {function.name: i for i, function in enumerate(self._examined.functions)}
        return sorted(pieces, key=lambda stem: min(place[name] for name in self._names_in(pieces[stem])))

    def _tail(self, piece: Piece, order: list[str], pieces: dict[str, Piece]) -> str:
        """Return priorities, where the order of the files alone would not give the order of the functions."""
        meant = [
            one for one in self._examined.functions if any(one.name in pieces[stem].defines for stem in order)
        ]
        mixed = any(
            len({one.flow for one in meant if one.name in pieces[stem].defines}) > 1 for stem in order
        )
        if not mixed:
            return ""
        lines = [
            f"{one.name}.priority = {2 * one.priority + (one.flow is not Flow.ROBOT_TO_NEURON)}"
            for one in meant if one.name in piece.defines
        ]  # fmt: skip
        return "\n" + "\n".join(lines) + "\n"

    # -- state machines

    def _events(self) -> dict[str, Any]:
        events: dict[str, Any] = {}
        for path in self._maker.machines:
            try:
                found = events_of(path, self._maker.names)
            except ExperimentError as error:
                self._report.left_out.append(f"the state machine {path.name}: {error}")
                continue
            if found is None:
                self._report.left_out.append(
                    f"the state machine {path.name}: it does more than colour at times"
                )
            else:
                self._report.changed.append(f"{path.name}: events")
                events |= found
        return events

    # -- what came of it

    def _check(self) -> None:
        """Take note of every function that the written experiment has not."""
        again = Examination(read_yaml(self._folder / FILE), quietly)
        again.collector.raise_errors()
        written = {function.name for function in again.functions}
        known = "\n".join(self._report.left_out)
        for function in self._examined.functions:
            if function.name not in written and function.name not in known:
                reasons = [one.message for one in again.collector.findings if function.name in one.message]
                self._report.left_out.append(f"{function.name}: {'; '.join(reasons) or 'it cannot be bound'}")

    def _write_report(self) -> None:
        lines = [f"# Import of {self._experiment.name}", ""]
        report = self._report
        sections = (
            ("Changed", report.changed),
            ("Left out", report.left_out),
            ("Left out or replaced in a run of the original, too", report.noted),
        )
        for title, items in sections:
            lines += [f"## {title}", "", *(f"- {item}" for item in items or ["nothing"]), ""]
        (self._folder / REPORT).write_text("\n".join(lines), encoding="utf-8")


def _in_nest_units(piece: Piece) -> str:
    devices = [kind for kind in ("dc_source", "ac_source", "nc_source", "weight=") if kind in piece.text]
    return f"it sets {', '.join(devices)} in the units of NEST" if devices else ""
