"""The shipped experiments as registered environments.

The agent commands the robot in place of the brain; of the fly it drives the descending cells, and the brain
is small.
"""

from __future__ import annotations

from typing import Any

import gymnasium

_LEGS = [f"{row}_{side}" for row in ("front", "middle", "rear") for side in ("left", "right")]
_SPEEDS = {"linear.x": (-1.0, 1.0), "angular.z": (-2.0, 2.0)}

SHIPPED: dict[str, dict[str, Any]] = {
    "nrp/BraitenbergHusky-v0": {
        "experiment": "braitenberg_husky",
        "overrides": ("world.options.image_scale=0.25",),
        "observe": ("/husky/camera",),
        "act": {"/husky/cmd_vel": _SPEEDS},
    },
    "nrp/SlalomPioneer-v0": {
        "experiment": "slalom_pioneer",
        "observe": ("/pioneer/scan", "rate:feelers"),
        "act": {"/pioneer/cmd_vel": _SPEEDS},
    },
    "nrp/FollowingHead-v0": {
        "experiment": "following_head",
        "overrides": ("world.options.image_scale=0.25",),
        "observe": ("/pan_tilt/eye/image_raw", "/pan_tilt/joint_states"),
        "act": {f"/pan_tilt/{joint}/cmd_pos": {"data": (-1.0, 1.0)} for joint in ("pan", "tilt")},
    },
    "nrp/WalkingHexapod-v0": {
        "experiment": "walking_hexapod",
        "observe": ("/hexapod/joint_states",),
        "act": {
            f"/hexapod/{leg}_{joint}/cmd_pos": {"data": (-1.0, 1.0)}
            for leg in _LEGS
            for joint in ("alpha", "beta", "gamma", "delta")
        },
    },
    "nrp/ReachingArm-v0": {
        "experiment": "reaching_arm",
        "observe": ("/arm/joint_states", "/arm/miss"),
        "act": {f"/arm/{joint}/cmd_pos": {"data": (-2.0, 2.0)} for joint in ("shoulder", "elbow")},
    },
    "nrp/Fly-v0": {
        "experiment": "fly",
        "overrides": ("brain.parameters.cells=2500",),
        "observe": ("motion:fly", "/fly/drive"),
        "act": {f"source:{cell}": (0.0, 300.0, 15.0) for cell in ("DNp09_left", "DNp09_right", "MDN")},
    },
}
"""Arguments of :class:`~nrp_lab.gym.env.NrpEnv` by the id of the environment."""


def register_shipped() -> None:
    """Register the environments with Gymnasium, once."""
    for name, settings in SHIPPED.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                "nrp_lab.gym.env:NrpEnv",
                vector_entry_point="nrp_lab.gym.vector_processes:make_vec",
                kwargs=settings,
            )
