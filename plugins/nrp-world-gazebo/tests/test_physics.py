"""What nrp-core adds to Gazebo: plugins of own files run, hinges keep their turns, contacts are firm."""

from dataclasses import replace
from math import inf, pi

import pytest
from nrp_conformance.world.capability import arm
from nrp_world_gazebo import GazeboBackend

from nrp_core.messages.std_msgs import Float64
from nrp_core.world import Scene, read_model

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]
WEIGHTLESS = (0.0, 0.0, 0.0)
THROWN = """
<sdf version="1.6"><model name="thrown"><link name="link"><inertial><mass>1</mass></inertial></link>
  <plugin name="throw" filename="libInitialVelocityPlugin.so"><linear>0.5 0 0</linear></plugin></model></sdf>
"""


def opened(*models, **options):
    backend = GazeboBackend()
    scene = Scene(models, gravity=WEIGHTLESS)
    return backend.open(scene, seed=1, options=backend.options.model_validate(options))


@pytest.mark.parametrize(("models", "way"), [("file", 0.5), ("scene", 0.0)])
def test_a_plugin_of_gazebo_in_a_users_file_runs(tmp_path, models, way):
    file = tmp_path / "thrown.sdf"
    file.write_text(THROWN)
    with opened(read_model(file), models=models) as world:
        world.run_until(1_000_000_000)
        assert world.model_motion("thrown").pose.position == pytest.approx((way, 0.0, 0.0), abs=2e-3)


def turning():
    model = arm("effort")
    return replace(model, joints=(replace(model.joints[0], kind="continuous", lower=-inf, upper=inf),))


def test_a_hinge_keeps_its_turns_in_snapshots_and_where_it_is_put():
    with opened(turning()) as world, opened(turning()) as fresh:
        world.advertise("/arm/cmd").publish(Float64(8.0))
        world.run_until(2_000_000_000)
        snapshot, before = world.snapshot(), float(world.joint_states("arm").positions[0])
        assert before > 4 * pi
        fresh.restore(snapshot)
        assert float(fresh.joint_states("arm").positions[0]) == before
        for position in (-9.0, 9.0):
            fresh.engine.set_joints("arm", {"joint": position})
            assert float(fresh.joint_states("arm").positions[0]) == pytest.approx(position, abs=1e-9)
