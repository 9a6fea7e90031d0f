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
from nrp_core.recording.video import VideoOptions, View, video

PAGE = """<video id="v" src="{name}" muted></video><script>
const v = document.getElementById("v"), say = (what) => fetch("/done?" + new URLSearchParams(what));
v.addEventListener("error", () => say({{error: v.error.message}}));
v.addEventListener("ended", () => say({{width: v.videoWidth, height: v.videoHeight, duration: v.duration}}));
v.play();
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


def played(folder: Path, name: str) -> dict[str, list[str]]:
    """Return what a page says of a video when Chromium has played it to its end."""
    (folder / "page.html").write_text(PAGE.format(name=name))
    said: Queue[dict[str, list[str]]] = Queue()
    with served(folder, said) as address:
        command = [
            "chromium", "--headless", "--no-sandbox", "--disable-gpu",
            f"--user-data-dir={folder / 'profile'}",
            "--autoplay-policy=no-user-gesture-required", f"{address}/page.html", "--remote-debugging-port=0",
        ]  # fmt: skip
        browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            return said.get(timeout=60)
        finally:
            browser.kill()
            browser.wait()


@pytest.mark.parametrize("name", ["walk.mp4", "walk.webm"])
def test_chromium_plays_a_video_to_its_end(recording: Recording, tmp_path: Path, name: str) -> None:
    count = video(recording, tmp_path / name, VideoOptions(view=View.FOLLOW, width=320, height=240))
    said = played(tmp_path, name)
    assert count == 26
    assert (said.get("width"), said.get("height")) == (["320"], ["240"]), said
    assert float(said["duration"][0]) == pytest.approx(26 / 25, abs=0.05)


def test_a_file_that_is_not_a_video_is_not_played(tmp_path: Path) -> None:
    (tmp_path / "walk.mp4").write_bytes(bytes(1000))
    assert "error" in played(tmp_path, "walk.mp4")
