"""A run is steered, and its functions are changed, over a real websocket."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from visitors import Cockpit, RefusedError, Visitor, cockpit

TO_GROUND = (-0.1698, 0.1, -0.3)
"""The direction of the sun in room.sdf."""
COLOUR = "/left_vr_screen/body/screen_glass/color"


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        yield opened


def listing(visitor: Visitor, name: str) -> tuple[str, str]:
    """Return the path and the text of a file with transfer functions."""
    files = visitor.until(lambda: visitor.last("functions"))["files"]
    found = next(each for each in files if each["path"].endswith(name))
    return found["path"], found["source"]


# -- steering


def test_a_publication_arrives(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("publish", topic=COLOUR, value="red")
    visitor.call("step")
    assert opened.run.world.engine.visual_colors[COLOUR[1:].removesuffix("/color")][:3] == (1.0, 0.0, 0.0)


def test_a_wrong_topic_is_refused_with_the_one_that_was_meant(visitor: Visitor, golden: Golden) -> None:
    with golden.raises(RefusedError):
        visitor.call("publish", topic="/husky/cmd_vell", value={"linear": {"x": 1}})


def test_messages_of_another_program_keep_their_order(opened: Cockpit, visitor: Visitor) -> None:
    speeds = [number / 100 for number in range(50)]
    visitor.publish("/husky/cmd_vel", *({"linear": {"x": speed}} for speed in speeds))
    for _ in range(30):
        visitor.call("pause")  # answered, however many messages wait before it
    visitor.until(lambda: len(opened.run.loop._published) == len(speeds))
    assert [message.linear.x for _, message in opened.run.loop._published] == speeds


def test_a_message_that_cannot_be_published_is_a_warning(visitor: Visitor) -> None:
    visitor.publish("/nowhere", 1)
    assert "/nowhere" in visitor.until(lambda: visitor.warnings)[0]


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("service", "arguments", "said"),
    [
        ("seek", {}, "the argument 't_s' is missing"),
        ("seek", {"t_s": "soon"}, "t_s: input should be a valid number, not 'soon'"),
        ("seek", {"t_s": 1, "fast": True}, "there is no argument 'fast'; valid: t_s"),
        ("seek", {"ts": 1}, "the argument 't_s' is missing"),
        ("halt", {"now": True}, "there is no argument 'now', and none is needed"),
        ("pace", {"factor": [1]}, "factor: input should be a valid number, not [1]"),
        ("membrane", {"population": "circut", "indices": [0]}, "did you mean 'circuit'?"),
        ("membrane", {"population": "circuit", "indices": [600]}, "the cells of 'circuit' are 0 to"),
        ("designer/show", {"topic": "/husky/camra"}, "did you mean '/husky/camera'?"),
        (
            "designer/write",
            {"language": "yaml", "text": ""},
            "language: input should be 'xml' or 'python', not 'yaml'",
        ),
        ("seek", {"t_s": -1}, "t_s: a time from 0 to 40 s, not -1 s"),
        ("seek", {"t_s": 5e9}, "t_s: a time from 0 to 40 s, not 5e+09 s"),
        ("step", {"n": True}, "n: input should be a valid integer"),
        ("pace", {"factor": 1e-9}, "the pace is a factor of at least 0.0001, not 1e-09"),
        (
            "push",
            {"body": "husky", "force_n": [9, 0, 0], "duration_s": -1},
            "duration_s: a time of 1e-06",
        ),
        ("push", {"body": "husky", "force_n": [0, 0, 0], "duration_s": 1}, "a force of 0 N moves nothing"),
        (
            "push",
            {"body": "desk", "force_n": [9, 0, 0], "duration_s": 1},
            "'desk' is static: no force",
        ),
        (
            "place",
            {"body": "husky", "position": [0, 0, 1], "orientation": [0, 0, 0, 0]},
            "length 1, not 0",
        ),
        (
            "place",
            {"body": "husky", "position": [0, 0, 1], "orientation": [0, 0, 1, 90]},
            "length 1, not 90",
        ),
        (
            "place",
            {"body": "husky", "position": [1e9, 0, 1], "orientation": [0, 0, 0, 1]},
            "m from the origin, since the scene is",
        ),
        ("step", {"n": 0}, "the number of steps must be 1 or more, not 0"),
        ("step", {"n": 1_000_000_000}, "steps, which are all of this run, not 1000000000"),
        ("push", {"body": "husky", "force_n": [1], "duration_s": 1}, "a force, N is 3 finite numbers"),
        ("push", {"body": "huskie", "force_n": [1, 0, 0], "duration_s": 1}, "husky"),
        (
            "place",
            {"body": "husky", "position": [0, 0, 0], "orientation": [0]},
            "an orientation, x, y, z and w is 4",
        ),
        ("functions/activate", {"name": "nothing", "active": True}, "nothing"),
        ("functions/save", {"files": {"/etc/passwd": ""}}, "is not a file with transfer functions"),
    ],
)
def test_a_wrong_request_is_refused_in_a_sentence(
    visitor: Visitor, service: str, arguments: dict[str, Any], said: str
) -> None:
    with pytest.raises(RefusedError) as refused:
        visitor.call(service, **arguments)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


LOSES = """

@nrp.MapVariable("held", initial_value=None)
@nrp.Robot2Neuron()
def holds(t, held):
    if t > 0.3:
        held.value = (number for number in range(3))
"""


def test_a_run_that_cannot_be_saved_any_more_says_so_and_goes_back_as_far_as_it_can(
    opened: Cockpit, visitor: Visitor, golden: Golden
) -> None:
    path, source = listing(visitor, "listing2.py")
    visitor.subscribe("/cockpit/experiment")
    assert visitor.call("functions/apply", files={path: source + LOSES})["applied"]
    able = visitor.until(lambda: (visitor.last("experiment") or {}).get("capabilities"))
    assert able["snapshot"] is True
    visitor.call("run_to", t_s=2.2)
    visitor.status(state="paused", t_s=2.2)
    able = visitor.until(lambda: _lacks(visitor, "snapshot"))
    assert "a value that cannot be saved" in able["snapshot"]
    assert able["step_back"] is True
    assert "no more snapshots can be taken" in visitor.until(lambda: visitor.last("log"))["text"]
    with golden.raises(RefusedError):
        visitor.call("snapshot")
    visitor.call("step_back")
    visitor.status(t_s=2.18)
    visitor.call("place", body="husky", position=[0, 0, 0.2], orientation=[0, 0, 0, 1])
    visitor.call("step")
    with golden.raises(RefusedError):
        visitor.call("step_back")
    assert "a value that cannot be saved" in visitor.until(lambda: _lacks(visitor, "step_back"))["step_back"]
    visitor.call("functions/revert")
    visitor.until(lambda: visitor.last("experiment")["capabilities"]["snapshot"] is True)
    visitor.call("step")
    visitor.call("step_back")


def _lacks(visitor: Visitor, capability: str) -> dict[str, Any] | None:
    able = visitor.last("experiment")["capabilities"]
    return None if able[capability] is True else dict(able)


def test_a_run_is_recorded_until_time_goes_back(visitor: Visitor, tmp_path: Path, golden: Golden) -> None:
    folder = tmp_path / "recording"
    assert visitor.call("record", folder=str(folder)) == {"path": str(folder)}
    with golden.raises(RefusedError):
        visitor.call("record", folder=str(tmp_path / "other"))
    visitor.call("step", n=3)
    assert visitor.status(t_s=0.06)["recording"]["path"] == str(folder)
    visitor.call("step_back")
    visitor.status(recording=None)
    assert (folder / "run.json").is_file()
    assert (folder / "recording.mcap").stat().st_size > 1000
    assert (
        "the recording ended because the run went back" in visitor.until(lambda: visitor.last("log"))["text"]
    )


# -- transfer functions


def test_findings_about_a_draft_stand_at_its_lines(visitor: Visitor) -> None:
    path, source = listing(visitor, "listing2.py")
    found = visitor.call("functions/check", files={path: source + "\n\ndef (:\n"})["findings"]
    lines = source.count("\n") + 3
    assert (path, lines) in [(each["file"], each["line"]) for each in found]


@pytest.mark.parametrize("wrong", ["\ndef (:\n", "\n@nrp.Nothing\ndef f(t): pass\n"])
def test_of_several_files_all_are_applied_or_none(opened: Cockpit, visitor: Visitor, wrong: str) -> None:
    first, second = listing(visitor, "listing2.py"), listing(visitor, "listing1.py")
    functions = opened.run.loop.functions
    renamed = first[1].replace("def eye_sensor_transmit", "def another_name")
    answer = visitor.call("functions/apply", files={first[0]: renamed, second[0]: second[1] + wrong})
    assert not answer["applied"]
    assert {each["file"] for each in answer["findings"]} == {second[0]}
    assert all(each["line"] > second[1].count("\n") for each in answer["findings"])
    assert opened.run.loop.functions == functions


def test_an_edit_is_applied_and_reverted(opened: Cockpit, visitor: Visitor) -> None:
    path, source = listing(visitor, "listing2.py")
    edited = source.replace("def eye_sensor_transmit", "def another_name")
    assert visitor.call("functions/apply", files={path: edited}) == {"applied": True, "findings": []}
    names = {each.name for each in opened.run.loop.functions}
    assert "another_name" in names
    assert "eye_sensor_transmit" not in names
    visitor.until(lambda: listing(visitor, "listing2.py")[1] == edited)
    visitor.call("step")
    assert Path(path).read_text() == source
    visitor.call("functions/revert")
    assert {each.name for each in opened.run.loop.functions} == {"eye_sensor_transmit", "linear_twist"}


def test_a_body_is_coloured_by_the_topic_that_the_experiment_names(visitor: Visitor) -> None:
    visitor.subscribe("/cockpit/experiment")
    bodies = visitor.until(lambda: visitor.last("experiment"))["bodies"]
    topics = {body["name"]: (body["colorable"], body["colored_part"]) for body in bodies}
    assert topics["left_vr_screen"] == ("/screens/left/color", "left_vr_screen/body/screen_glass")
    assert topics["sofa"] == ("/sofa/link/seat/color", "sofa/link/seat")


def test_the_page_receives_the_poses_of_cameras_and_lights(visitor: Visitor) -> None:
    visitor.subscribe("/cockpit/experiment")
    experiment = visitor.until(lambda: visitor.last("experiment"))
    [sun] = experiment["lights"]  # as room.sdf has it
    assert (sun["kind"], sun["range_m"]) == ("directional", None)
    assert sun["direction"] == pytest.approx([part / hypot(*TO_GROUND) for part in TO_GROUND])
    [mount] = experiment["mounts"]
    assert (mount["topic"], mount["frame"]) == ("/husky/camera", "husky/base_link")
    assert mount["position"] == pytest.approx([-0.16, 0, 0.362])
    assert mount["view"] == {"fov_rad": 1.57, "aspect": pytest.approx(4 / 3)}


def test_a_text_that_is_saved_and_not_applied_does_not_run(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path, source = listing(visitor, "listing2.py")
    elsewhere = tmp_path / "listing2.py"
    elsewhere.write_text(source)
    monkeypatch.setitem(opened.session.functions._files, path, elsewhere)
    edited = source.replace("def eye_sensor_transmit", "def another_name")
    visitor.call("functions/save", files={path: edited})
    assert elsewhere.read_text() == edited
    assert visitor.call("functions/apply", files={})["applied"]
    assert "another_name" not in {each.name for each in opened.run.loop.functions}
    assert listing(visitor, "listing2.py")[1] == source


def test_a_file_that_changed_on_the_disk_or_in_the_run_is_not_overwritten(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, golden: Golden
) -> None:
    path, source = listing(visitor, "listing2.py")
    elsewhere = tmp_path / "listing2.py"
    elsewhere.write_text(source)
    monkeypatch.setitem(opened.session.functions._files, path, elsewhere)
    visitor.call("functions/save", files={path: source + "# one\n"}, base={path: source})
    visitor.call("functions/save", files={path: source + "# two\n"})
    elsewhere.write_text(changed := source + "# of an editor\n")
    with golden.raises(RefusedError, match="changed on the disk"):
        visitor.call("functions/save", files={path: source + "# three\n"})
    with golden.raises(RefusedError, match="somebody else has changed"):
        visitor.call("functions/save", files={path: source}, base={path: "another text"})
    assert elsewhere.read_text() == changed
    visitor.call("functions/save", files={path: changed})
    visitor.call("functions/save", files={path: source})
    assert elsewhere.read_text() == source


def test_the_time_of_a_call_is_that_of_the_calls_that_are_counted(visitor: Visitor) -> None:
    visitor.call("step", n=5)
    visitor.call("seek", t_s=0.04)
    visitor.call("step")
    for each in visitor.until(lambda: counted(visitor, 1)):
        assert each["mean_ms"] == pytest.approx(each["recent_ms"][-1], abs=1e-3)


def test_calls_without_a_viewer_are_counted(opened: Cockpit) -> None:
    session = opened.session
    session.ask(session.reset)
    session.ask(lambda: session.step(4))
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/functions")
        functions = visitor.until(lambda: counted(visitor, 4))
        assert all(each["mean_ms"] > 0 for each in functions)
        visitor.call("step", n=2)
        functions = visitor.until(lambda: counted(visitor, 6))
        assert all(each["recent_ms"] for each in functions)
        assert {each["since_s"] for each in functions} == {0.0}
        visitor.call("step_back")
        functions = visitor.until(lambda: counted(visitor, 0))
        assert [each["since_s"] for each in functions] == pytest.approx(
            [session.now_ns / 1e9] * len(functions)
        )


def counted(visitor: Visitor, calls: int) -> list[dict[str, Any]] | None:
    """Return the functions, once each was called that often."""
    functions = (visitor.last("functions") or {"functions": []})["functions"]
    return functions if functions and {each["calls"] for each in functions} == {calls} else None


def test_an_error_of_a_draft_is_shown_in_its_file(opened: Cockpit, visitor: Visitor, golden: Golden) -> None:
    path, source = listing(visitor, "listing2.py")
    broken = (
        f"{source}    missing = []\n    if t > 0.2:  # later than a check before a run\n        missing[0]\n"
    )
    assert visitor.call("functions/apply", files={path: broken}) == {"applied": True, "findings": []}
    visitor.call("step", n=15)
    error = visitor.status(state="failed")["error"]
    assert (error["file"], error["line"]) == (path, broken.count("\n"))
    assert "nrp-cockpit-" not in error["message"]
    with golden.raises(RefusedError):
        visitor.call("play")
    visitor.call("functions/revert")
    visitor.call("step_back")
    visitor.status(state="paused", error=None)


def test_a_function_that_is_not_active_does_not_run(visitor: Visitor) -> None:
    def calls(active: bool) -> int:
        visitor.call("functions/activate", name="linear_twist", active=active)
        visitor.call("step", n=2)
        return int(visitor.until(lambda: shown(active))["calls"])

    def shown(active: bool) -> dict[str, Any] | None:
        functions = (visitor.last("functions") or {"functions": []})["functions"]
        fits = (each for each in functions if each["name"] == "linear_twist" and each["active"] is active)
        return next(fits, None)

    assert calls(active=False) == 0
    assert calls(active=True) > 0


def test_an_editor_is_offered_topics_populations_and_words(visitor: Visitor) -> None:
    labels = {word["label"] for word in visitor.call("functions/complete")["words"]}
    assert {"/husky/camera", "nrp.brain.sensors", "nrp.MapRobotSubscriber"} <= labels


def test_snapshots_are_bounded_and_one_that_is_removed_makes_room(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    def kept() -> list[str]:
        return [each["id"] for each in opened.session.past.data()["snapshots"] if not each["left"]]

    monkeypatch.setattr("nrp_cockpit.session.past.MOST_KEPT", len(kept()) + 2)
    first = visitor.call("snapshot")
    visitor.call("snapshot")
    with golden.raises(RefusedError):
        visitor.call("snapshot")
    visitor.call("forget", id=first["id"])
    assert first["id"] not in kept()
    visitor.call("snapshot")


def test_a_long_way_to_another_time_is_halted_where_it_is(opened: Cockpit, visitor: Visitor) -> None:
    way = visitor.ask("seek", t_s=30.0)
    visitor.until(lambda: opened.run.now_s > 0.1)
    visitor.call("halt")
    visitor.answer(way)
    assert 0.1 < opened.session.ask(lambda: opened.run.now_s) < 30
    visitor.status(state="paused")


def test_a_cell_and_a_projection_are_read_when_somebody_looks(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=3)
    brain = opened.run.brain
    label, population = next(each for each in brain.network.populations.items() if not each[1].is_source)
    looked = visitor.call("membrane", population=label, indices=[1, 0])
    first = int(brain.network.offsets[label])
    v_mv = opened.session.ask(lambda: brain.read_state("v", [first + 1, first])).tolist()
    assert looked == {"t_s": 0.06, "v_mv": v_mv}
    projection = brain.network.projections[0]
    weights = visitor.call("weights", projection=projection.label)
    assert sum(weights["counts"]) == projection.size
    assert weights["summary"][0] == pytest.approx(projection.weight.min(), rel=0.01)
    for call, said in (
        (
            lambda: visitor.call("membrane", population=label, indices=[10_000]),
            f"the cells of '{label}' are 0 to",
        ),
        (lambda: visitor.call("weights", projection="nothing"), "nothing"),
    ):
        with pytest.raises(RefusedError, match=said):
            call()
    assert population.size > 1
