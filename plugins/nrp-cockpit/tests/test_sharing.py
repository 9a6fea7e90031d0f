"""A recording in one HTML file holds what was recorded, and what does not fit is thinned and named."""

from __future__ import annotations

import base64
import errno
import gzip
import json
import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from nrp_cockpit.sharing.sharing import _telling_ns, shared_file
from nrp_cockpit.sharing.tracks import Track, fitted
from visitors import RefusedError, cockpit

from nrp_core.cli.app import run_app
from nrp_core.errors import ExperimentError
from nrp_core.messages.cdr import Codec
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.recording import Recording

CAMERA = "/husky/camera"
SPIKES = "/brain/circuit/spikes"


def unpacked(html: str, name: str) -> bytes:
    """Return what a block of the file holds."""
    found = re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', html)
    assert found is not None
    return gzip.decompress(base64.b64decode(found[1]))


def messages_in(html: str) -> dict[str, list[tuple[int, bytes]]]:
    """Return the times and messages of each topic, read by the format that the page documents."""
    topics: dict[str, list[tuple[int, bytes]]] = {}
    for number, topic in enumerate(json.loads(unpacked(html, "nrp-recording"))["topics"]):
        data = unpacked(html, f"nrp-topic-{number}")
        (count,) = struct.unpack_from("<Q", data)
        times = struct.unpack_from(f"<{count}d", data, 8)
        lengths = struct.unpack_from(f"<{count}I", data, 8 + 8 * count)
        at = 8 + 12 * count
        found = topics[topic["topic"]] = []
        for t_ns, length in zip(times, lengths, strict=True):
            found.append((int(t_ns), data[at : at + length]))
            at += length
        assert at == len(data)
    return topics


@pytest.fixture(scope="module")
def recorded(recording: Path) -> dict[str, list[tuple[int, bytes]]]:
    found: dict[str, list[tuple[int, bytes]]] = {}
    for topic, one in Recording(recording).raw():
        if topic.role != Role.RUN:
            found.setdefault(topic.name, []).append((one.log_time, one.data))
    return found


@pytest.mark.parametrize(
    ("failed_s", "passed_s", "events_s", "silenced_s", "expected_s"),
    [
        ([], [], [], [], 10.0),
        ([], [], [None, 3.0, 8.0], [], 9.0),
        ([], [], [8.0], [12.0], 13.0),
        ([], [(0.0, 20.0)], [20.0, 1.0], [], 4.0),  # when the plots are filled
        ([], [(0.0, 5.0), (19.0, 20.0)], [], [], 19.5),
        ([6.0, 2.0], [(9.0, 10.0)], [8.0], [], 2.0),
        ([20.0], [], [], [], 10.0),
    ],
)
def test_a_file_opens_at_a_failure_or_else_after_the_last_change(
    failed_s: list[float], passed_s: list[tuple[float, float]], events_s: list[float | None],
    silenced_s: list[float], expected_s: float,
) -> None:  # fmt: skip
    criteria: list[dict[str, float | None]] = [
        {"passed": False, "from_s": 1.0, "to_s": t_s} for t_s in failed_s
    ]
    criteria += [{"passed": True, "from_s": from_s, "to_s": to_s} for from_s, to_s in passed_s]
    criteria += [{"passed": None, "from_s": 0.0, "to_s": 1.0}]
    timeline = {
        "criteria": criteria,
        "events": [{"t_s": t_s} for t_s in events_s],
        "interventions": [{"t_s": t_s} for t_s in silenced_s],
        "failures": [],
    }
    assert _telling_ns(0, 2 * 10**10, timeline) == expected_s * 1e9


def test_the_file_holds_every_message_and_lossless_images(recording: Path, recorded: dict[str, Any]) -> None:
    shared = shared_file(recording)
    held = messages_in(shared.html)
    assert shared.losses == ()
    assert held.keys() == recorded.keys()
    assert all(held[name] == recorded[name] for name in held if name != CAMERA)
    topic = Recording(recording).topics[CAMERA]
    raw = Codec({topic.type_name: topic.definition})
    about = next(
        one for one in json.loads(unpacked(shared.html, "nrp-recording"))["topics"] if one["topic"] == CAMERA
    )
    files = Codec({about["schemaName"]: about["schema"]})
    for (t_ns, file), (t_raw_ns, image) in zip(held[CAMERA], recorded[CAMERA], strict=True):
        pixels = raw.decode(image, topic.type_name)
        decoded = cv2.imdecode(np.asarray(files.decode(file, about["schemaName"]).data), cv2.IMREAD_COLOR_RGB)
        assert t_ns == t_raw_ns
        assert decoded is not None
        assert decoded.tobytes() == bytes(pixels.data)


def test_the_file_does_not_say_where_the_recording_was(recording: Path) -> None:
    about = unpacked(shared_file(recording).html, "nrp-recording").decode()
    assert str(recording.parent) not in about
    assert '"experiment/' in about  # the sources are named as in the recording


def test_topics_beyond_the_size_limit_are_thinned_and_named(
    recording: Path, recorded: dict[str, Any]
) -> None:
    whole = shared_file(recording)
    without = len(whole.html) - sum(
        len(block) for block in re.findall(r'id="nrp-topic-\d+">([^<]*)<', whole.html)
    )
    limit = without + (len(whole.html) - without) // 2 + 20_000
    shared = shared_file(recording, limit)
    assert len(shared.html) <= limit
    held = messages_in(shared.html)
    thinned = [name for name in held if len(held[name]) < len(recorded[name])]
    assert [loss.partition(":")[0] for loss in shared.losses] == thinned != []
    findings = json.loads(unpacked(shared.html, "nrp-recording"))["reports"]["findings"]
    assert set(shared.losses) <= {finding["summary"] for finding in findings}
    assert held[SPIKES] in ([], recorded[SPIKES])  # all or none: they are counted
    assert held["/scene"] == recorded["/scene"]
    with pytest.raises(ExperimentError, match="does not fit"):
        shared_file(recording, without)


def topic(name: str, role: Role) -> RecordedTopic:
    return RecordedTopic(name, "std_msgs/msg/Float64", "", {"role": role})


def test_the_largest_topic_is_halved_until_all_fit() -> None:
    random = np.random.default_rng(1)  # does not compress
    large = Track(topic("/large", Role.SENSOR), [10**8 * n for n in range(64)], [random.bytes(1000)] * 0 + [
        random.bytes(1000) for _ in range(64)
    ])  # fmt: skip
    small = Track(topic("/small", Role.SENSOR), [0, 1], [b"a", b"b"])
    left = fitted([large, small], 40_000)
    assert (left[0].times_ns, left[0].messages) == (large.times_ns[::2], large.messages[::2])
    assert left[1] is small
    assert [track.loss for track in left] == [
        "/large: 1 of 2 messages is in this file, to limit its size", None
    ]  # fmt: skip


def test_a_topic_is_left_out_before_it_has_less_than_one_message_a_second() -> None:
    slow = Track(topic("/slow", Role.SENSOR), [10**9 * n for n in range(9)], [b"x"] * 9)
    assert slow.thinned().messages == []
    assert "not in this file" in (slow.thinned().loss or "")


def test_the_command_writes_the_file_beside_the_recording(recording: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.html"
    words = [sys.executable, "-m", "nrp_core", "share", str(recording), "-o", str(file), "--json"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    about = json.loads(done.stdout)
    assert about == {"file": str(file), "bytes": file.stat().st_size, "losses": []}
    assert file.read_text().startswith("<!doctype html>")
    missing = subprocess.run([*words[:4], "nowhere"], capture_output=True, text=True, check=False)
    assert (missing.returncode, missing.stdout) == (2, "")


@pytest.mark.parametrize("named", [True, False], ids=["named", "own name"])
def test_the_command_replaces_what_exists_on_request_only_and_as_a_whole(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    named: bool,
) -> None:  # fmt: skip
    source = tmp_path / "recorded"
    shutil.copytree(recording, source)
    file = tmp_path / ("run.html" if named else "recorded.html")
    words = ["share", str(source), *(["-o", str(file)] if named else [])]
    file.write_text("precious")
    assert run_app(words) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert file.read_text() == "precious"
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", no_space)
        assert run_app([*words, "--overwrite"]) not in (0, 1)
    assert {path.name: path.is_file() and path.read_text() for path in tmp_path.iterdir()} == {
        source.name: False, file.name: "precious",
    }  # fmt: skip
    assert run_app([*words, "--overwrite"]) == 0
    assert file.read_text().startswith("<!doctype html>")


def no_space(_: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_run_is_shared_as_far_as_it_was_recorded(tmp_path: Path) -> None:
    with cockpit() as opened, opened.visit() as visitor, opened.visit(steers=False) as watcher:
        visitor.subscribe("/cockpit/status")
        with pytest.raises(RefusedError, match="record a part of the run"):
            visitor.call("share")
        visitor.call("record", folder=str(tmp_path / "part"))
        visitor.call("step", n=3)
        visitor.call("record", folder=None)
        assert visitor.status(t_s=0.06, recording=None)["recorded"] == str(tmp_path / "part")
        shared = visitor.call("share")
        assert (shared["name"], shared["losses"]) == ("part.html", [])
        assert len(messages_in(shared["html"])["/husky/cmd_vel"]) == 3
        with pytest.raises(RefusedError, match="not control it"):
            watcher.call("share")
