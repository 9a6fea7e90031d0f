"""The moving picture at the top of the README: ``python docs/site/opening.py`` writes it.

It runs the fly with its own wiring and with rewired synapses, films both recordings with ``nrp video``, and
puts them side by side over the rates of the cells that make a fly walk and eat.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from bisect import bisect_right
from collections.abc import Iterator
from pathlib import Path

import cv2
from matplotlib import get_data_path
from PIL import Image, ImageDraw, ImageFont

PICTURE = Path(__file__).parents[1] / "images" / "fly-rewired.webp"
FLIES = {"fly": "with its wiring", "fly/rewired": "the same fly, rewired"}
BARS = {"walks": ("pace", "#2a6f97"), "eats": ("eat", "#d55e00")}
"""The functions whose devices have the rates, and the colour of each bar."""
SPEED, FRAMES_PER_S = 0.25, 12.5
VIEW = "--view", "free", "--eye=6.5e-3,-11.5e-3,4.8e-3", "--target=6.5e-3,0,-0.8e-3"
WIDTH, HEIGHT, BELOW, GAP = 420, 160, 76, 12
FILM, ABOVE = 230, 20
"""Height of the film and of its sky that is cut off, pixels; what is below the picture is, too."""
MOST_HZ = 100.0
CAPTION = (
    "nrp run fly   and   nrp run fly/rewired   at a quarter of real time; the wiring of both is synthetic"
)


def main() -> None:
    """Run both flies, and write the picture."""
    with tempfile.TemporaryDirectory() as folder:
        films = [list(_film(name, Path(folder, str(place)))) for place, name in enumerate(FLIES)]
    pages = [_page(pair) for pair in zip(*films, strict=True)]
    still = pages[-1:] * int(FRAMES_PER_S)  # the last image stays for a second
    pages[0].save(
        PICTURE, save_all=True, append_images=[*pages[1:], *still], duration=round(1000 / FRAMES_PER_S),
        loop=0, quality=60, method=6,
    )  # fmt: skip
    print(f"{PICTURE}: {len(pages) / FRAMES_PER_S + 1:.0f} s, {PICTURE.stat().st_size / 1e6:.1f} MB")


def _film(name: str, recording: Path) -> Iterator[Image.Image]:
    """Run a fly, and yield the images of its film with the bars below."""
    film = recording.with_suffix(".mp4")
    _nrp("run", name, "--record", str(recording), wrong=name != "fly")
    _nrp("video", str(recording), *VIEW, "--speed", str(SPEED), "--size", f"{WIDTH}x{FILM}", "-o", str(film))
    tables = recording.with_name(f"{recording.name}-csv")
    _nrp("export", str(recording), "--format", "csv", "-o", str(tables))
    rates = {bar: _rates(tables, of) for bar, (of, _) in BARS.items()}
    video = cv2.VideoCapture(str(film))
    every = round(video.get(cv2.CAP_PROP_FPS) / FRAMES_PER_S)
    for number in range(int(video.get(cv2.CAP_PROP_FRAME_COUNT))):
        _, image = video.read()
        if number % every == 0:
            t_s = number / every / FRAMES_PER_S * SPEED
            scene = Image.fromarray(cv2.cvtColor(image[ABOVE : ABOVE + HEIGHT], cv2.COLOR_BGR2RGB))
            yield _panel(scene, FLIES[name], {bar: _rate(of, t_s) for bar, of in rates.items()})


def _rates(tables: Path, function: str) -> list[list[tuple[float, float]]]:
    """Return the times, s, and rates, Hz, of the left and the right cells of a function."""
    found = []
    for side in ("left", "right"):
        with (tables / f"brain.devices.{function}.{side}.rate.csv").open(
            encoding="utf-8", newline=""
        ) as file:
            found.append([(float(t_s), float(rate_hz)) for t_s, rate_hz in list(csv.reader(file))[1:]])
    return found


def _rate(sides: list[list[tuple[float, float]]], t_s: float) -> float:
    """Return the mean rate of both sides at a time, Hz."""
    return sum(rows[max(bisect_right(rows, (t_s, float("inf"))) - 1, 0)][1] for rows in sides) / len(sides)


def _panel(scene: Image.Image, title: str, rates: dict[str, float]) -> Image.Image:
    panel = Image.new("RGB", (WIDTH, HEIGHT + BELOW), "white")
    panel.paste(scene)
    draw = ImageDraw.Draw(panel)
    draw.text((8, 6), title, "#222222", _font(16))
    left, full = 56, WIDTH - 130
    for row, (bar, (_, color)) in enumerate(BARS.items()):
        y = HEIGHT + 14 + 32 * row
        draw.text((0, y), bar, "#222222", _font(15))
        draw.rectangle((left, y, left + full, y + 18), "#eeeeee")
        draw.rectangle((left, y, left + full * min(rates[bar] / MOST_HZ, 1.0), y + 18), color)
        draw.text((left + full + 8, y), f"{rates[bar]:.0f} Hz", "#222222", _font(15))
    return panel


def _page(panels: tuple[Image.Image, ...]) -> Image.Image:
    page = Image.new("RGB", (2 * WIDTH + GAP, HEIGHT + BELOW + 26), "white")
    for place, panel in enumerate(panels):
        page.paste(panel, (place * (WIDTH + GAP), 0))
    ImageDraw.Draw(page).text((0, HEIGHT + BELOW + 4), CAPTION, "#555555", _font(14))
    return page


def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(Path(get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")), size)


def _nrp(*words: str, wrong: bool = False) -> None:
    command = [str(Path(sys.executable).parent / "nrp"), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != int(wrong):
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    main()
