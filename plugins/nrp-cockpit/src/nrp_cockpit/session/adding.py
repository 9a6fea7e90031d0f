"""Bodies that users add to a run: simple shapes, and models in files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, count
from math import isfinite
from pathlib import Path
from typing import Any, Final

from nrp_core.errors import ExperimentError, SceneError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.scene.inertia import shape_inertia
from nrp_core.scene.rigid import Pose
from nrp_core.world import Box, Collision, Cylinder, Geometry, Link, Model, Sphere, Visual, read_model
from nrp_core.world.robot_setup import RobotSetup, set_up_robot

SHAPES: Final = ("box", "sphere", "cylinder")
_DENSITY: Final = 100.0
"""Of shapes, kg/m^3: that of light foam, which robots can push."""
_RGBA: Final = (0.9, 0.6, 0.0, 1.0)
_SUFFIXES: Final = (".sdf", ".urdf")
_MODEL: Final = "model.sdf"
_MOST: Final = 100
"""Maximum number of files that are offered."""
_SMALLEST_M, _LARGEST_M = 1e-4, 100.0


class Adding:
    """Adds bodies to a run, and removes them.

    Args:
        run: the run.
    """

    def __init__(self, run: Run) -> None:
        self._run = run

    def models(self) -> dict[str, Any]:
        """Return the names of the models that can be added: shapes, and models by their files or folders."""
        return {"models": [*SHAPES, *self._files()]}

    def add(self, model: str, position: Sequence[float], size_m: float = 0.5) -> dict[str, Any]:
        """Add a body that stands at a place; return its name.

        Args:
            model: one of :meth:`models`.
            position: the place on the ground, m.
            size_m: the size of a shape, m.

        Raises:
            ExperimentError: the model does not exist, or the position or the size is impossible.
            SceneError: the file of the model cannot be read.
            CapabilityError: the engine cannot add bodies.
        """
        if len(position) != 3 or not all(map(isfinite, position)):
            raise ExperimentError(f"a position, m is 3 finite numbers, not {list(position)}")
        if not _SMALLEST_M <= size_m <= _LARGEST_M:
            raise ExperimentError(f"size_m: a size from {_SMALLEST_M:g} to {_LARGEST_M:g} m, not {size_m:g}")
        files = {} if model in SHAPES else self._files()
        if model not in SHAPES and model not in files:
            raise ExperimentError(f"no model '{model}' can be added{did_you_mean(model, [*SHAPES, *files])}")
        x, y, z = position
        pose, name = Pose((x, y, z)), self._free_name(Path(model).stem)
        if model in SHAPES:
            added = _shape(model, name, pose, size_m)
        else:
            search = self._run.experiment.models
            added = read_model(files[model], name=name, pose=pose, search_path=search)
        self._run.world.spawn(_standing(added))
        return {"body": name}

    def remove(self, body: str) -> None:
        """Remove a body.

        Raises:
            ExperimentError: it is a robot.
            SceneError: the body does not exist.
        """
        if body in self._run.experiment.world.robots:
            raise ExperimentError(f"'{body}' is a robot, which the experiment needs")
        self._run.world.delete(body)

    def _files(self) -> dict[str, Path]:
        """Return the files of models in the folder of the experiment and of its libraries, by their names."""
        path = self._run.experiment.source.place.path
        folders = [] if path is None else [path.parent]
        found: dict[str, Path] = {}
        for folder in (*folders, *self._run.experiment.models):
            for file in _model_files(folder):
                inside = file.relative_to(folder)
                found.setdefault(str(inside.parent if file.name == _MODEL else inside), file)
        return dict(list(found.items())[:_MOST])

    def _free_name(self, stem: str) -> str:
        taken = {model.name for model in self._run.world.scene.models}
        names = chain([stem], (f"{stem}_{number}" for number in count(2)))
        return next(name for name in names if name not in taken)


def _model_files(folder: Path) -> Iterator[Path]:
    """Yield the files with one model in a folder, and in the folders in it."""
    for file in sorted((*folder.glob("*.*"), *folder.glob(f"*/{_MODEL}"))):
        if file.suffix in _SUFFIXES and file.is_file() and b"<world" not in file.read_bytes():
            yield file


def _shape(kind: str, name: str, pose: Pose, size_m: float) -> Model:
    geometries: dict[str, Geometry] = {
        "box": Box((size_m, size_m, size_m)),
        "sphere": Sphere(size_m / 2),
        "cylinder": Cylinder(size_m / 2, size_m),
    }
    geometry = geometries[kind]
    seen, solid = Visual("visual", geometry, rgba=_RGBA), Collision("collision", geometry)
    inertial = shape_inertia(geometry, _DENSITY)
    return Model(name, (Link("link", inertial=inertial, visuals=(seen,), collisions=(solid,)),), pose=pose)


def _standing(model: Model) -> Model:
    """Return a model whose lowest point is at the height of its pose; a static model does not change."""
    if model.static:
        return model
    try:
        return set_up_robot(model, RobotSetup(placed=True, on_ground=True))
    except SceneError:  # it has no collisions
        return model
