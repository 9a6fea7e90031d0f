"""Capability: declared features work, and others are refused rather than silently left out."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from nrp_core.conformance.guard import undeclared
from nrp_core.conformance.world.kit import WorldKit
from nrp_core.conformance.world.scenes import RED, at, floor, prop, robot, screen
from nrp_core.errors import CapabilityError, DivergedError, LifecycleError
from nrp_core.world.scene.model import Sphere


class CapabilityTests(WorldKit):
    """The declaration of capabilities is correct, in both directions."""

    level = "capability"

    def test_capabilities_are_the_same_at_every_call(self) -> None:
        declared = self.capabilities
        assert self.backend.capabilities(self.chosen) == declared
        assert self.open(floor(), robot()).capabilities == declared
        assert declared.step_ns > 0
        assert len(set(declared.renderers)) == len(declared.renderers)

    def test_undeclared_cameras_are_refused(self) -> None:
        if self.capabilities.renderers:
            assert self.look(self.open(floor(), robot(), screen("screen", 0.0, RED))).any()
        else:
            with pytest.raises(CapabilityError):
                self.open(floor(), robot()).engine.render("robot", "eye", "camera")

    def test_undeclared_snapshots_are_refused(self) -> None:
        world = self.open(floor(), robot())
        self.run(world, 0.1)
        if self.capabilities.snapshot:
            assert world.snapshot().t_ns == world.now_ns
        else:
            with pytest.raises(CapabilityError):
                world.snapshot()

    def test_experiments_that_need_gravity_are_refused_without_it(self) -> None:
        ball = prop("ball", Sphere(0.1), at(0, 0, 5), mass=1.0)
        if self.capabilities.dynamics:
            assert self.open(ball).capabilities.dynamics
            return
        with pytest.raises(CapabilityError, match="ball"):
            self.open(ball)
        with pytest.raises(CapabilityError):
            self.open(floor(), robot()).joint_states("robot")

    def test_each_declared_renderer_can_be_chosen(self) -> None:
        self.require_camera()
        if "renderer" not in self.backend.options.model_fields:
            undeclared("a choice of renderers")
        for renderer in self.capabilities.renderers:
            options = self.backend.options.model_validate({**self.options, "renderer": renderer})
            assert self.backend.capabilities(options).renderers[0] == renderer

    def test_unknown_options_are_refused(self) -> None:
        with pytest.raises(ValidationError):
            self.backend.options.model_validate({**self.options, "no_such_option": 1})

    def test_a_world_that_is_not_finite_is_reported_and_a_reset_repairs_it(self) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.1), at(0, 0, 5), mass=1.0)
        world = self.open(ball, gravity=(0.0, 0.0, float("nan")))
        with pytest.raises(DivergedError):
            self.run(world, 1.0)
        with pytest.raises(LifecycleError):
            self.run(world, 2.0)
        world.reset()
        assert world.model_motion("ball").pose.position == pytest.approx((0, 0, 5))
