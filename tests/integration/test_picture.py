"""The picture of a run as it is now."""

from __future__ import annotations

from base64 import b64decode
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from golden import Golden
from lxml import html
from nrp_conformance.world.kit import at, prop, robot, twist
from nrp_world_minimal.engine import MinimalBackend

from nrp_core import open_run
from nrp_core.errors import ExperimentError, SceneError
from nrp_core.experiment.running.picture import image_of
from nrp_core.world import Box, Scene, WorldCapabilities, WorldOptions
from nrp_core.world.render.portrait import portrait


def test_a_picture_shows_the_robot_where_it_is_and_changes_nothing(tmp_path: Path, golden: Golden) -> None:
    with open_run("braitenberg_husky") as run, open_run("braitenberg_husky") as unseen:
        before = run.show(width=160, height=120)
        run.run_until(0.5)
        run.world.set_material("husky/base_link/deck", (1.0, 0.0, 1.0, 1.0))
        after = run.show(width=160, height=120)
        run.run_until(1.0)
        unseen.run_until(1.0)
        assert run.result().trajectory_digest == unseen.result().trajectory_digest
        whole = run.show([], width=160, height=120)
        with golden.raises(SceneError):
            run.show("huski")
    changed = (before.pixels != after.pixels).any(axis=2)
    assert 0.02 < changed.mean() < 0.9
    assert changed.mean() < (whole.pixels != after.pixels).any(axis=2).mean()
    after.save(tmp_path / "run.png")
    assert (cv2.imread(str(tmp_path / "run.png"))[:, :, ::-1] == after.pixels).all()
    with golden.raises(ExperimentError):
        after.save(tmp_path / "run.jpg")


def test_a_notebook_gets_the_image_with_time_and_rates() -> None:
    with open_run("braitenberg_husky") as run:
        run.run_until(0.5)
        shown, spikes = run.show(width=160, height=120), run.spikes
    figure = html.fromstring(shown._repr_html_())
    data = figure.find(".//img").get("src").removeprefix("data:image/png;base64,")
    image = cv2.imdecode(np.frombuffer(b64decode(data), np.uint8), cv2.IMREAD_COLOR)
    assert (image[:, :, ::-1] == shown.pixels).all()
    assert shown.rates_hz["actors"] == spikes["actors"] / 2 / 0.5
    assert "0.5 s" in figure.text_content()


def test_muscles_are_drawn_in_the_colour_of_their_activation() -> None:
    with open_run("reflex_arm") as run:
        before = run.show(width=160, height=120).pixels.astype(int)
        run.run_until(2.0)
        after = run.show(width=160, height=120).pixels.astype(int)
    reds = [int((image[:, :, 0] - image[:, :, 1] > 60).sum()) for image in (before, after)]
    assert (before != after).any()
    assert min(reds) > 0


def test_an_engine_that_reports_only_models_has_pictures() -> None:
    class WithoutLinks(MinimalBackend):
        def capabilities(self, options: WorldOptions) -> WorldCapabilities:
            return replace(super().capabilities(options), links=False, renderers=())

    scene = Scene(
        (robot(), prop("mark", Box((0.1, 0.1, 0.1)), at(-2.0, 0.0, 0.0), rgba=(0.0, 1.0, 0.0, 1.0)))
    )
    with WithoutLinks().open(scene, seed=1, options=WorldOptions()) as world:
        world.advertise("/robot/cmd_vel").publish(twist(1.0, 0.0))
        before = image_of(world, 160, 120, [])
        assert (before == portrait(scene, 160, 120)).all()
        world.run_until(1_000_000_000)
        after = image_of(world, 160, 120, [])
    marks = [(image[:, :, 1] > 80) & (image[:, :, 0] < 20) for image in (before, after)]
    assert 0 < marks[1].sum() < marks[0].sum()  # the robot is farther from it, so all is smaller
