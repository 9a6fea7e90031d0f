"""``hbp_nrp_client`` works in plain scripts, and gives way to an installed ROS."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from pathlib import Path

import nrp_core.dsl as nrp


def run(script: str, *path: Path) -> str:
    program = [sys.executable, "-c", textwrap.dedent(script)]
    extra = "import sys\n" + "".join(f"sys.path.insert(0, {str(p)!r})\n" for p in path)
    program[2] = extra + program[2]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_plain_script_needs_no_loader() -> None:
    out = run(
        """
        import hbp_nrp_client.tf_framework as nrp
        import geometry_msgs.msg
        from std_msgs.msg import Float64
        from nrp_core.dsl.testing import Rig

        @nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
        @nrp.Neuron2Robot(nrp.Topic("/cmd", geometry_msgs.msg.Twist))
        def drive(t, wheel):
            return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(wheel.voltage, 0, 0))

        rig = Rig(drive)
        rig.set(wheel=0.25)
        rig.run()
        print(rig.sent("/cmd")[-1].linear.x, Float64(1).data)
        """
    )
    assert out == "0.25 1"


def test_an_installed_ros_comes_first_in_a_plain_script(tmp_path: Path) -> None:
    (tmp_path / "geometry_msgs").mkdir()
    (tmp_path / "geometry_msgs" / "__init__.py").write_text("")
    (tmp_path / "geometry_msgs" / "msg.py").write_text("who = 'ros'\n")
    script = "import hbp_nrp_client.tf_framework\nimport geometry_msgs.msg\nprint(geometry_msgs.msg.who)"
    assert run(script, tmp_path) == "ros"


def test_the_client_has_the_names_of_the_language() -> None:
    script = "import hbp_nrp_client.tf_framework as nrp\nprint(*sorted(nrp.__all__))"
    assert run(script).split() == sorted(nrp.__all__)


def test_the_language_is_imported_without_opencv() -> None:
    script = "import sys, hbp_nrp_client.tf_framework\nprint({'cv2', 'numba', 'pyNN'} & set(sys.modules))"
    assert run(script) == "set()"
