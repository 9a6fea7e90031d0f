"""States of the platform's library that spawn, warn and end the run, with the arguments of its manual."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach
from nrp_legacy.reader import read_exc
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.states import ClockDelayState

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

HEAD = """
from smach import StateMachine
from geometry_msgs.msg import Point, Vector3
import hbp_nrp_excontrol.nrp_states as states
sm = StateMachine(outcomes=["DONE", "ERROR", "PREEMPTED"])
def then(state, next):
    return state, {"succeeded": next, "aborted": "ERROR", "preempted": "PREEMPTED"}
with sm:
"""

SPHERE = "<sphere><radius>0.1</radius></sphere>"

Ran = Callable[..., Run]


def machine_of(states: list[str]) -> str:
    follow = [*(repr(f"s{i}") for i in range(1, len(states))), "'DONE'"]
    named = enumerate(zip(states, follow, strict=True))
    lines = [f"    StateMachine.add('s{i}', *then(states.{state}, {after}))" for i, (state, after) in named]
    return HEAD + "\n".join(lines) + "\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An experiment with a plain floor and the machine ``m.exd``."""
    home = tmp_path / "library"
    home.mkdir()
    (home / "x.bibi").write_text("<bibi/>")
    control = '<experimentControl><stateMachine src="m.exd"/></experimentControl>'
    (home / "x.exc").write_text(f'<ExD><timeout>1.0</timeout><bibiConf src="x.bibi"/>{control}</ExD>')
    return home


@pytest.fixture
def ran(folder: Path, request: pytest.FixtureRequest) -> Ran:
    """Runs a machine of some states to the end."""

    def run_states(*states: str, until_s: float = 0.8) -> Run:
        (folder / "m.exd").write_text(machine_of(list(states)))
        run = Run(read_exc(folder / "x.exc"))
        request.addfinalizer(run.close)
        run.run(until_s)
        return run

    return run_states


def height(run: Run, name: str) -> float:
    return run.world.model_motion(name).pose.position[2]


def test_balls_of_the_library_collide_only_if_a_machine_says_so(ran: Ran) -> None:
    """The manual: "Kinematics and collision are disabled by default"; a box has both."""
    run = ran(
        "SpawnSphere('through', radius=0.1, position=Point(0, 2, 0.3))",
        "SpawnSphere('lands', radius=0.1, position=Point(1, 2, 0.3), can_collide=True, mass=2., kinematic=0)",
        "SpawnBox('box', size=Vector3(0.2, 0.2, 0.2), position=Point(2, 2, 0.3))",
        "SpawnCylinder('floats', radius=0.1, length=0.2, position=Point(3, 2, 0.3), gravity_factor=False)",
    )
    assert height(run, "lands") == pytest.approx(0.1, abs=0.01)
    assert height(run, "box") == pytest.approx(0.1, abs=0.01)
    assert height(run, "floats") == 0.3
    # free fall for 0.8 s
    assert height(run, "through") == pytest.approx(0.3 - 9.81 * 0.8**2 / 2, abs=0.05)
    told = [one.message for one in run.result().problems if one.code is Code.NRP292]
    assert ["'through' falls through the floor" in one for one in told] == [True]
    inertial = run.world.scene.model("lands").links[0].inertial
    assert inertial is not None
    assert inertial.mass == 2.0


def test_a_sphere_and_a_cylinder_have_a_radius_of_1_m_by_default(ran: Ran) -> None:
    run = ran("SpawnSphere('s', gravity_factor=0)", "SpawnCylinder('c', gravity_factor=0)")
    geometries = [run.world.scene.model(name).links[0].visuals[0].geometry for name in "sc"]
    assert [one.radius for one in geometries] == [1.0, 1.0]  # type: ignore[union-attr]


@pytest.mark.parametrize("geometry", [SPHERE, "<geometry>{}</geometry>"])
def test_a_model_is_spawned_from_a_geometry_in_sdf(ran: Ran, geometry: str) -> None:
    text = geometry.format("<box><size>0.2 0.2 0.2</size></box>")
    run = ran(
        f"ModelSpawnServiceState('a', '{text}', Point(1, 0, 0.4), Vector3(), mass=3.0, color='Gazebo/Red')",
        f"ModelSpawnServiceState('b', geometry='{text}', position=Point(2, 0, 0.4), gravity_factor=0)",
        f"ModelSpawnServiceState(lambda ud, last: 'c', '{text}', Point(3, 0, 0.4), can_collide=False)",
    )
    assert [height(run, "a"), height(run, "b")] == [pytest.approx(0.1, abs=0.01), 0.4]
    assert height(run, "c") < -1.0
    link = run.world.scene.model("a").links[0]
    assert (link.inertial is not None and link.inertial.mass, link.visuals[0].rgba[:3]) == (
        3.0,
        (1.0, 0.0, 0.0),
    )


def test_a_warning_is_shown_and_the_machine_goes_on(ran: Ran, caplog: pytest.LogCaptureFixture) -> None:
    run = ran("WarningState('the arm is too hot')", "SpawnSphere('s', gravity_factor=0)")
    assert ("WARNING", "the arm is too hot") in [(one.levelname, one.message) for one in caplog.records]
    assert "s" in [model.name for model in run.world.scene.models]


def test_an_object_is_coloured_by_the_names_of_its_parts_in_the_library(ran: Ran) -> None:
    """As the mouse of the platform's demonstration follows a sphere that turns red."""
    run = ran(
        "SpawnSphere(model_name='tracked', radius=0.05, position=Point(1, 1, 1), use_gravity=False)",
        "SetMaterialColorServiceState('tracked', 'body', 'visual', 'Gazebo/RedGlow')",
        "SpawnBox('box', size=Vector3(1, 1, 1), position=Point(2, 2, 2), use_gravity=False)",
        f"ModelSpawnServiceState('odd', '{SPHERE}', Point(3, 3, 3), use_gravity=False)",
        "SetMaterialColorServiceState('odd', 'body', 'visual', 'Gazebo/BlueGlow')",
        "SpawnSphere('last', gravity_factor=0)",
    )
    names = [model.name for model in run.world.scene.models]
    assert names[-4:] == ["tracked", "box", "odd", "last"]
    assert [height(run, name) for name in names[-4:-1]] == [1.0, 2.0, 3.0]
    assert Code.NRP280 not in [problem.code for problem in run.problems]


def test_a_screen_shows_the_mean_colour_of_a_texture(folder: Path, ran: Ran) -> None:
    """As the digits on the screens of the labyrinth of Telluride."""
    textures = folder / "resources" / "textures"
    textures.mkdir(parents=True)
    cv2.imwrite(str(textures / "9.png"), np.full((4, 4, 3), (0, 51, 255), np.uint8))
    run = ran(
        "SpawnBox('screen', size=Vector3(1, 1, 1), position=Point(2, 2, 2), gravity_factor=0)",
        "SetMaterialColorServiceState('screen', 'body', 'visual', '9.png')",
        "SpawnSphere('last', gravity_factor=0)",
    )
    assert "last" in [model.name for model in run.world.scene.models]
    shown = run.world.subscribe("/screen/body/visual/color").latest
    assert shown is not None
    assert (shown.message.r, shown.message.g, shown.message.b) == pytest.approx((1.0, 0.2, 0.0))


def test_texts_that_a_machine_publishes_are_shown(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    """As machines did before the platform had a logger."""
    machine = """
import rospy
from smach import StateMachine
from smach.state import State
from std_msgs.msg import String
sm = StateMachine(outcomes=['DONE'])
clientLogger = rospy.Publisher('/ros_cle_simulation/logs', String, latch=True, queue_size=10)
class Talk(State):
    def __init__(self, outcomes=['success']):
        super(Talk, self).__init__(outcomes=outcomes)
        clientLogger.publish('begins')
    def execute(self, userdata):
        clientLogger.publish('talks {}'.format(1))
        return 'success'
with sm:
    StateMachine.add('talk', Talk(), {'success': 'DONE'})
"""
    (folder / "m.exd").write_text(machine)
    with caplog.at_level("INFO"), Run(read_exc(folder / "x.exc")) as run:
        run.run(0.2)
        assert Code.NRP212 not in [problem.code for problem in run.problems]
    assert [one.message for one in caplog.records if one.name == "nrp_legacy"] == ["begins", "talks 1"]


WAITS = "    StateMachine.add('wait', states.ClockDelayState(0.3), {'valid': 'wait', 'invalid': 's0'})\n"


@pytest.mark.parametrize("given", ["0.3", "waitfor=0.3", "waittime=0.3"])
def test_a_delay_has_its_name_of_each_year(folder: Path, given: str) -> None:
    text = HEAD + WAITS.replace("0.3", given) + machine_of(["StopSimulation()"]).removeprefix(HEAD)
    (folder / "m.exd").write_text(text)
    with Run(read_exc(folder / "x.exc")) as run:
        run.run()
        assert run.now_s == 0.3


def test_a_delay_without_a_time_is_refused(golden: Golden) -> None:
    with golden.raises(TypeError):
        ClockDelayState(Graph())


OF_ITS_OWN = """
class WaitTo(states.ClockMonitorState):
    def __init__(self, time):
        super(WaitTo, self).__init__(self.__callback)
        self.__time = time
    def __callback(self, user_data, time):
        return time.clock.secs + time.clock.nsecs * 1e-9 < self.__time and time.clock.to_sec() < self.__time
with sm:
    StateMachine.add('wait', WaitTo(0.3), {'valid': 'wait', 'invalid': 's0'})
"""


def test_a_state_of_its_own_reads_the_message_of_the_clock(folder: Path) -> None:
    """As the mice of the project's first co-design do."""
    spawns = "    StateMachine.add('s0', *then(states.SpawnBox('box', size=Vector3(1, 1, 1)), 'DONE'))\n"
    (folder / "m.exd").write_text(HEAD.removesuffix("with sm:\n") + OF_ITS_OWN + spawns)
    with Run(read_exc(folder / "x.exc")) as run:
        run.run(0.28)
        assert "box" not in [model.name for model in run.world.scene.models]
        run.run(0.4)
        assert "box" in [model.name for model in run.world.scene.models]


def test_a_machine_ends_the_run(folder: Path) -> None:
    (folder / "m.exd").write_text(HEAD + WAITS + machine_of(["StopSimulation()"]).removeprefix(HEAD))
    with Run(read_exc(folder / "x.exc")) as run:
        run.run()
        result = run.result()
    assert (result.sim_time_s, result.state) == (0.3, "finished")
    (told,) = [one.message for one in result.problems if "ended the simulation" in one.message]
    assert told == "a state machine has ended the simulation at 0.3 s"


def test_a_machine_ends_a_simulation_of_the_virtual_coach(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "m.exd").write_text(HEAD + WAITS + machine_of(["StopSimulation()"]).removeprefix(HEAD))
    monkeypatch.setenv("NRP_PACE", "max")
    monkeypatch.setenv("NRP_SET", "duration=600s")
    times: list[float] = []
    sim = VirtualCoach(environment=folder.parent).launch_experiment("library")
    sim.register_status_callback(lambda status: times.append(status["simulationTime"]))
    sim.start()
    while sim.get_state() != "stopped":
        pass
    assert times[-1] == 0.3
