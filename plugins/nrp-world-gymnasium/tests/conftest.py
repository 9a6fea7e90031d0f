"""Worlds of environments, and environments with the spaces that Gymnasium's own small ones do not have."""

import tomllib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from nrp_world_gymnasium import GymnasiumBackend

from nrp_core.world import Scene, World

Open = Callable[..., World]
EMPTY = Scene(())
PLUGIN = Path(__file__).parents[1]


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The plugin can be found by its name, as if it were installed."""
    project = tomllib.loads((PLUGIN / "pyproject.toml").read_text())["project"]
    info = tmp_path / "site" / "nrp_world_gymnasium-0.1.0.dist-info"
    info.mkdir(parents=True)
    info.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 0.1.0\n")
    ((group, entries),) = project["entry-points"].items()
    lines = [f"[{group}]", *(f"{name} = {target}" for name, target in entries.items())]
    info.joinpath("entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(info.parent)


@pytest.fixture
def open_world() -> Iterator[Open]:
    with ExitStack() as opened:

        def open_(env: str, *, seed: int = 1, scene: Scene = EMPTY, **options: Any) -> World:
            backend = GymnasiumBackend()
            chosen = backend.options.model_validate({"env": env, **options})
            return opened.enter_context(backend.open(scene, seed=seed, options=chosen))

        yield open_


class Corridor(gymnasium.Env[Any, Any]):
    """A walker sees an image, a map and a text; its actions are a number of steps and two turns."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    observation_space = spaces.Dict(
        {
            "eye": spaces.Box(0, 255, (4, 6, 3), np.uint8),
            "map": spaces.Box(0.0, 9.0, (2, 3), np.float32),
            "mission": spaces.Text(20),
        }
    )
    action_space = spaces.Dict(
        {"steps": spaces.Discrete(3, start=-1), "turns": spaces.Box(-1.0, 2.0, (2,), np.float32)}
    )

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.taken: list[Any] = []
        self.eye = np.arange(72, dtype=np.uint8).reshape(4, 6, 3)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        super().reset(seed=seed)
        self.place = 0
        return self._seen(), {}

    def step(self, action: Any) -> Any:
        self.taken.append(action)
        self.place += int(action["steps"])
        return self._seen(), float(action["turns"].sum()), False, False, {}

    def render(self) -> Any:
        return np.full((3, 5, 3), 7, np.uint8)

    def _seen(self) -> dict[str, Any]:
        self.eye[0, 0, 0] = self.place % 256  # in the same array each time, as many environments do
        places = np.arange(6, dtype=np.float32).reshape(2, 3) + self.place / 8
        return {"eye": self.eye, "map": places.clip(0, 9), "mission": f"go to {self.place}"}


class Forgetful(Corridor):
    """Its place differs in each life."""

    lives = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        super().reset(seed=seed)
        Forgetful.lives += 1
        self.place = Forgetful.lives
        return self._seen(), {}


class Lost(Corridor):
    """Its map loses its numbers."""

    def _seen(self) -> dict[str, Any]:
        return {**super()._seen(), "map": np.full((2, 3), np.nan if self.place else 0.0, np.float32)}


class Graphs(Corridor):
    """Its observations are not messages."""

    observation_space = spaces.Graph(spaces.Box(0, 1), None)  # type: ignore[assignment]

    def _seen(self) -> Any:
        return self.observation_space.sample()


for kind in (Corridor, Forgetful, Graphs, Lost):
    gymnasium.register(f"tests/{kind.__name__}-v0", kind, disable_env_checker=True)
