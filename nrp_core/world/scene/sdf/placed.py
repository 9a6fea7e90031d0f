"""Models and lights as they are used: in place, or by ``<include>``."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_core.world.scene.pose import Pose
from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.sdf.frames import Frames, read_pose
from nrp_core.world.scene.sdf.source import Source
from nrp_core.world.scene.xml_tree import Element


@dataclass(frozen=True, slots=True)
class Placed:
    """A ``<model>`` or ``<light>`` and how it is used.

    Args:
        element: the model or light.
        source: the file that it stands in.
        user: the element that places it: itself or an ``<include>``.
        merged: whether its parts become parts of the model around it.
    """

    element: Element
    source: Source
    user: Element
    merged: bool = False

    @property
    def name(self) -> str:
        """Its name; an ``<include>`` may give it another one than its file."""
        included = self.user is not self.element
        return (self.user.word("name") if included else "") or self.element.attribute("name")

    @property
    def static(self) -> bool:
        """Whether it never moves."""
        return self.user.flag("static", self.element.flag("static", False))

    @property
    def plugins(self) -> list[Element]:
        """Its plugins, those of the ``<include>`` among them."""
        return list(dict.fromkeys([*self.element.all("plugin"), *self.user.all("plugin")]))

    def pose(self, default: str, own: Frames | None = None) -> tuple[Pose, str]:
        """Return where it is placed, and the frame that this is relative to.

        Args:
            default: what the pose is relative to where it does not say.
            own: the frames of the model, one of which may be what is placed.
        """
        placing = self.user if self.user.find("pose") else self.element
        pose, relative_to = read_pose(placing, default)
        anchor = self.user.word("placement_frame") or self.element.attributes.get("placement_frame")
        if anchor and own:
            pose = pose @ own.pose(anchor, placing).inverse()
        return pose, relative_to


def read_placed(parent: Element, source: Source, reading: Reading, *tags: str) -> list[Placed]:
    """Return what an element holds of some kinds, in the order of the file.

    Args:
        parent: a world, a model or a whole file.
        source: the file that it stands in.
        reading: what is carried along.
        tags: the kinds, ``model`` and ``light``; other contents of included files are left out.
    """
    placed: list[Placed] = []
    for child in parent.all("include", *tags):
        if child.tag == "include":
            included = source.include(child, reading)
            found = included.root.all(*tags)
            placed += [Placed(element, included, child, child.is_set("merge")) for element in found]
        else:
            placed.append(Placed(child, source, child))
    return placed
