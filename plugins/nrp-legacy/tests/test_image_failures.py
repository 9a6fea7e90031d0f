"""An error of a function that has received a camera image says that Gazebo did not draw it."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.errors import TransferFunctionRaisedError
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

_ROBOT = """<sdf version="1.6"><model name="eye"><static>1</static><link name="l">
<sensor name="c" type="camera"><update_rate>50</update_rate>
<camera><horizontal_fov>1</horizontal_fov><image><width>4</width><height>4</height></image></camera>
<plugin name="p" filename="libgazebo_ros_camera.so"><imageTopicName>camera</imageTopicName></plugin>
</sensor></link></model></sdf>"""
_READS = '@nrp.MapRobotSubscriber("camera", Topic("/eye/c/camera", sensor_msgs.msg.Image))\n'
_MADE = '@nrp.MapRobotSubscriber("camera", Topic("/made", sensor_msgs.msg.Image))\n'
_NOTE = "; the image of '/eye/c/camera' comes from another renderer than Gazebo's"


def _opened(folder: Path, code: str, *overrides: str) -> Run:
    (folder / "eye.sdf").write_text(_ROBOT)
    (folder / "tf.py").write_text(code)
    (folder / "x.bibi").write_text(
        '<bibi><bodyModel robotId="eye">eye.sdf</bodyModel><transferFunction src="tf.py"/></bibi>'
    )
    (folder / "x.exc").write_text('<ExD><timeout>1</timeout><bibiConf src="x.bibi"/></ExD>')
    return Run(read_exc(folder / "x.exc", overrides))


def _code(reads: str, body: str) -> str:
    camera = ", camera" if reads else ""
    return f"{reads}@nrp.Robot2Neuron()\ndef see(t{camera}):\n    if t < 0.1: return\n    {body}\n"


@pytest.mark.parametrize(
    ("reads", "body", "is_explained"),
    [
        (_READS, "1 / camera.value.data.count(b'no such pixels')", True),
        (_READS, "None.position", True),
        (_READS, "if not camera.value: found = 1\n    return found", True),
        (_READS, "np.misspelt(camera.value.data)", False),
        (_READS, "open('no such file')", False),
        (_READS, "misspelt(camera.value)", False),
        (_READS, "np.concatenate([])", True),
        (_READS, "__import__('packaging.version').version.Version('of no image')", False),
        (_MADE, "1 / 0", False),
        ("", "1 / 0", False),
    ],
)
def test_the_error_names_the_image_that_the_function_received(
    tmp_path: Path, reads: str, body: str, is_explained: bool
) -> None:
    with _opened(tmp_path, _code(reads, body)) as run:
        run.run_until(0.3)
        (left_out,) = [one for one in run.problems if one.code is Code.NRP272]
        assert left_out.message.endswith(_NOTE if is_explained else "was not called any more")


def test_the_error_that_stops_a_run_says_so_too(tmp_path: Path) -> None:
    with _opened(tmp_path, _code(_READS, "1 / 0"), "on_error=stop") as run:
        with pytest.raises(TransferFunctionRaisedError) as raised:
            run.run_until(0.3)
        assert str(raised.value).splitlines()[0].endswith(_NOTE)
