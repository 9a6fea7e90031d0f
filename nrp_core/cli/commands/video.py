"""``nrp video``."""

from __future__ import annotations

from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import (
    Json,
    Overwrite,
    RecordingPath,
    beginning_with,
    open_recording,
    time_s,
    usage_errors,
)
from nrp_core.cli.output import complain, document

if TYPE_CHECKING:
    from nrp_core.recording.video import Vector

VIEWS = ("follow", "above", "free")
RENDERERS = ("shaded", "realistic")
_SIZE = "640x480"


def _cameras(context: typer.Context, incomplete: str) -> list[str]:
    """Return the cameras of the recording before the option; none if it cannot be read."""
    from nrp_core.recording.recording import Recording
    from nrp_core.recording.video.views import camera_names

    with suppress(Exception):
        # the parser leaves the words before an option without its value as they are
        folder = context.params.get("recording") or context.args[0]
        return beginning_with(lambda: camera_names(Recording(folder)))(incomplete)
    return []


def video(
    recording: RecordingPath,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", envvar="NRP_OUTPUT", help="A .mp4 or .webm file."),
    ] = Path("video.mp4"),
    camera: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Show the images of this camera, or topic.",
            autocompletion=_cameras,
        ),
    ] = None,
    view: Annotated[
        str,
        typer.Option(
            metavar="|".join(VIEWS),
            help="The viewpoint of the drawn scene.",
            autocompletion=beginning_with(lambda: VIEWS),
        ),
    ] = "follow",
    robot: Annotated[str | None, typer.Option(metavar="NAME", help="The robot to follow.")] = None,
    eye: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Position of the free view, m.")] = None,
    target: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Target of the free view, m.")] = None,
    speed: Annotated[float, typer.Option(min=0.01, max=1000, help="Speed relative to simulated time.")] = 1.0,
    begin: Annotated[str, typer.Option("--from", metavar="TIME", help="Begin at this time, e.g. 2s.")] = "0s",
    until: Annotated[str | None, typer.Option("--until", metavar="TIME", help="End at this time.")] = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Size of drawn images, pixels; by default 640x480.")
    ] = None,
    renderer: Annotated[
        str,
        typer.Option(
            metavar="|".join(RENDERERS),
            help="How the scene is drawn: with recognisable shapes, or with its lights and shadows.",
            autocompletion=beginning_with(lambda: RENDERERS),
        ),
    ] = "shaded",
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a video of a recorded run: the images of a camera, or the scene from another viewpoint."""
    from math import inf

    from nrp_core.cli.progress import display
    from nrp_core.errors import did_you_mean
    from nrp_core.recording.video import Renderer, VideoOptions, ViewKind, check_target
    from nrp_core.recording.video import video as write

    source = open_recording(recording, "shown")
    with usage_errors("--output"):
        check_target(output, overwrite=overwrite)
    with usage_errors("--view"):
        if view not in (known := [each.value for each in ViewKind]):
            raise ValueError(f"unknown view '{view}'{did_you_mean(view, known)}")
    with usage_errors("--renderer"):
        if renderer not in RENDERERS:
            raise ValueError(f"unknown renderer '{renderer}'{did_you_mean(renderer, RENDERERS)}")
    begin_s = time_s(begin, "--from")
    end_s = inf if until is None else time_s(until, "--until")
    with usage_errors("--until"):
        if end_s <= begin_s:
            raise ValueError(f"expected a time after {begin}, not {until}")
    with usage_errors("--size"):
        width, height = _size(size or _SIZE)
    with usage_errors("--eye"):
        from_where = _vector(eye)
    with usage_errors("--target"):
        to_where = _vector(target)
        if from_where is not None and from_where == to_where:
            raise ValueError("it is the position of the view, so there is no direction to look in")
    _refuse_ignored(
        view, {"--camera": camera, "--robot": robot, "--eye": eye, "--target": target, "--size": size}
    )
    options = VideoOptions(
        camera,
        ViewKind(view),
        speed,
        begin_s,
        end_s,
        width,
        height,
        robot=robot,
        eye=from_where,
        target=to_where,
        renderer=Renderer(renderer),
    )
    with display() as shown:
        shown.begin_task("drawing the first image")
        count = write(
            source,
            output,
            options,
            lambda done, total: shown.count("drawing", done, total),
            overwrite=overwrite,
        )
    if json:
        document({"video": output, "images": count, "complete": source.complete})
    else:
        typer.echo(output)


def _refuse_ignored(view: str, given: dict[str, str | None]) -> None:
    """Refuse an option that another one makes ineffective.

    Raises:
        typer.BadParameter: a view of the scene beside a camera, or a viewpoint that the view does not have.
    """
    used = {"follow": ("--robot",), "above": (), "free": ("--eye", "--target")}[view]
    names = [name for name, value in given.items() if value is not None]
    for name in names:
        if "--camera" in names and (name != "--camera" or view != "follow"):
            raise typer.BadParameter(
                "shows recorded images: leave out --view, --size and the options of a view",
                param_hint="--camera",
            )
        if name not in ("--camera", "--size", *used):
            raise typer.BadParameter(f"has no effect with --view {view}", param_hint=name)


def _size(text: str) -> tuple[int, int]:
    sides = text.split("x")
    if len(sides) != 2 or not all(side.strip().isdigit() and 16 <= int(side) <= 7680 for side in sides):
        raise ValueError(
            f"a size is a width and a height from 16 to 7680 pixels, such as 640x480, not '{text}'"
        )
    width, height = (int(side) + int(side) % 2 for side in sides)
    if (even := f"{width}x{height}") != "x".join(side.strip() for side in sides):
        complain(f"the images are {even} and not {text}: videos need even sizes", label="note")
    return width, height


def _vector(text: str | None) -> Vector | None:
    if text is None:
        return None
    try:
        x, y, z = (float(number) for number in text.split(","))
        if not isfinite(x + y + z):
            raise ValueError
    except ValueError:
        raise ValueError(f"a point is three numbers in m, such as 1,2.5,0.3, not '{text}'") from None
    return x, y, z
