"""A visitor draws beside a real run, and lets it run with what was drawn."""

from __future__ import annotations

from pathlib import Path

from golden import Golden
from visitors import RefusedError, cockpit


def test_a_drawn_function_runs_from_the_beginning_and_every_page_shows_it(
    tmp_path: Path, golden: Golden
) -> None:
    with (
        cockpit("transfer_functions=[]") as here,
        here.visit() as artist,
        here.visit(steers=False) as watcher,
    ):
        classes = artist.call("designer/describe")["functions"]["classes"]
        assert "Neuron2Robot" in classes["TransferFunction"]["choices"]
        watcher.subscribe("/cockpit/designer")
        artist.subscribe("/cockpit/designer")
        artist.call("designer/open", file=str(tmp_path / "drawn.bibi"))
        with golden.raises(RefusedError):
            artist.call("designer/run")

        def do(command: str, **arguments: object) -> str:
            made = artist.call("designer/do", command=command, arguments=arguments)["selected"]
            return str(made)

        function = do("add", path="", field="transfer_function", type="Neuron2Robot")
        command = do("connect", source="topic:/husky/cmd_vel", target=function)
        twist = "geometry_msgs.msg.Twist(angular=geometry_msgs.msg.Vector3(0, 0, 1))"
        do("write", path=command, field="body", text=twist)
        with golden.raises(RefusedError):
            watcher.call("designer/undo")
        shown = artist.until(lambda: watcher.last("designer"))
        assert {box["name"] for box in shown["boxes"]} >= {"sensors", "/husky/camera", "/screens/left/color"}
        findings = artist.call("designer/check")["findings"]
        assert [one for one in findings if one["weight"] == "error"] == []
        refusals = artist.call("designer/fits", source="topic:/husky/odom")["refusals"]
        assert refusals[function] is None
        assert "need a transfer function between them" in refusals["population:sensors"]
        device = "/brain/devices/to_robot/speed/voltage"
        assert device not in artist.channels
        speed = do("connect", source="population:actors", target=function)
        do("set", path=speed, field="name", text="speed")
        assert artist.call("designer/run")["applied"] is True
        artist.until(lambda: device in artist.channels)
        artist.subscribe("/cockpit/status", "/cockpit/functions")
        artist.until(lambda: (artist.last("status") or {"t_s": 0})["t_s"] > 0.5)
        artist.call("pause")
        assert here.run.world.model_motion("husky").angular[2] > 0.5
        assert [one["name"] for one in artist.last("functions")["functions"]] == ["to_robot"]


def test_of_two_models_with_one_function_only_the_one_that_is_run_counts(tmp_path: Path) -> None:
    python = (
        "@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))\n"
        "def f(t):\n    return geometry_msgs.msg.Twist()\n"
    )
    with cockpit("transfer_functions=[]") as here, here.visit() as artist:
        for name in ("first.bibi", "second.bibi"):
            path = str(tmp_path / name)
            artist.call("designer/open", file=path)
            assert artist.call("designer/write", language="python", text=python)["error"] is None
            artist.call("designer/save")
            findings = artist.call("designer/check")["findings"]
            assert [one for one in findings if one["weight"] == "error"] == []
            assert path not in here.session.functions.files, "what is only looked at is no part of the run"
            assert artist.call("designer/run")["applied"] is True
            artist.call("pause")
            assert here.session.functions.files == (path,)


def test_a_text_with_a_mistake_changes_nothing_and_names_its_line(tmp_path: Path) -> None:
    with cockpit("transfer_functions=[]") as here, here.visit() as artist:
        artist.call("designer/open", file=str(tmp_path / "drawn.bibi"))
        found = artist.call("designer/write", language="xml", text="<bibi>\n<bodyModl/>\n</bibi>")
        assert found["line"] == 2
        assert "did you mean 'bodyModel'" in found["error"]
        python = "@nrp.Neuron2Robot(Topic('/a', std_msgs.msg.Float64))\ndef f(t):\n    return 1.0 * t\n"
        assert artist.call("designer/write", language="python", text=python)["error"] is None
        artist.call("designer/save")
        assert 'name="f"' in (tmp_path / "drawn.bibi").read_text()
