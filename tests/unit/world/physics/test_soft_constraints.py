"""Constraints that yield as in MuJoCo."""

from nrp_core.scene.origin import Native
from nrp_core.world.engine_kit.soft_constraints import Reference


def test_numbers_that_an_element_does_not_state_are_the_usual_ones() -> None:
    stated = (("solreflimit", "0.01"), ("solimplimit", "0.8 0.9"))
    solref, solimp, _ = Reference.read(Native("mujoco", "joint", stated), "limit")
    assert (solref.tolist(), solimp.tolist()) == ([0.01, 1.0], [0.8, 0.9, 0.001, 0.5, 2.0])
