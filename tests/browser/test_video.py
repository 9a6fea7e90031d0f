"""Videos play in a browser."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest

from nrp_core import Recording
from nrp_core.recording.video import VideoOptions, ViewKind, video

PAGE = """<script>
for (const name of {names}) {{
  const v = document.createElement("video");
  const say = (what) => fetch("/done?" + new URLSearchParams({{name, ...what}}));
  v.muted = true;
  v.addEventListener("error", () => say({{error: v.error.message}}));
  v.addEventListener("ended", () =>
    say({{width: v.videoWidth, height: v.videoHeight, duration: v.duration}}));
  v.src = name;
  document.documentElement.append(v);
  v.play();
}}
</script>"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("walk") / "recording"
    nrp = Path(sys.executable).with_name("nrp")
    command = [str(nrp), "run", "walking_hexapod", "--until", "1s", "--record", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return Recording(folder)


@contextmanager
def served(folder: Path, said: "Queue[dict[str, list[str]]]") -> Iterator[str]:
    class Handler(SimpleHTTPRequestHandler):
        def __init__(self, *args: Any) -> None:
            super().__init__(*args, directory=str(folder))

        def do_GET(self) -> None:
            address = urlsplit(self.path)
            if address.path == "/done":
                said.put(parse_qs(address.query))
                self.send_response(204)
                self.end_headers()
            else:
                super().do_GET()

        def log_message(self, *args: Any) -> None:
            """Stay silent."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def played(folder: Path, *names: str) -> dict[str, dict[str, list[str]]]:
    """Return what a page says of each video when Chromium has played them to their ends."""
    (folder / "page.html").write_text(PAGE.format(names=list(names)))
    said: Queue[dict[str, list[str]]] = Queue()
    with served(folder, said) as address:
        command = [
            "chromium", "--headless", "--no-sandbox", "--disable-gpu",
            f"--user-data-dir={folder / 'profile'}",
            "--autoplay-policy=no-user-gesture-required", f"{address}/page.html", "--remote-debugging-port=0",
        ]  # fmt: skip
        browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            answers = [said.get(timeout=60) for _ in names]
        finally:
            browser.kill()
            browser.wait()
    return {answer["name"][0]: answer for answer in answers}


def test_chromium_plays_videos_to_their_ends_and_no_other_file(recording: Recording, tmp_path: Path) -> None:
    videos = "walk.mp4", "walk.webm"
    for name in videos:
        assert (
            video(recording, tmp_path / name, VideoOptions(view=ViewKind.FOLLOW, width=320, height=240)) == 26
        )
    (tmp_path / "wrong.mp4").write_bytes(bytes(1000))
    said = played(tmp_path, *videos, "wrong.mp4")
    assert "error" in said["wrong.mp4"]
    for name in videos:
        one = said[name]
        assert (one.get("width"), one.get("height")) == (["320"], ["240"]), one
        assert float(one["duration"][0]) == pytest.approx(26 / 25, abs=0.05)
