"""``nrp demo``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from nrp_cockpit.command import cockpit


class Demo(StrEnum):
    """The experiments that need only this distribution and start within a few seconds."""

    HUSKY = "husky"
    FLY = "fly"


_EXPERIMENTS = {Demo.HUSKY: "braitenberg_husky", Demo.FLY: "fly"}


def demo(
    which: Annotated[
        Demo, typer.Argument(metavar="WHICH", help="husky: a robot that drives to red; fly: a fly at sugar.")
    ] = Demo.HUSKY,
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 takes any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
) -> None:
    """Show a robot with a spiking brain in the browser, running.

    The first line on standard output is the address of the page. Ctrl-C ends the run.
    """
    cockpit(_EXPERIMENTS[which], port=port, browser=browser, play=True)
