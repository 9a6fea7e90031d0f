"""The transfer functions of an imported experiment as files."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from nrp_core.dsl import Flow, TransferFunction
from nrp_core.errors import ExperimentError
from nrp_core.xml import Element
from nrp_legacy.code import Source
from nrp_legacy.convert.python import Piece, piece_of
from nrp_legacy.documents import is_active, priority_of
from nrp_legacy.functions import part_source
from nrp_legacy.maker import LegacyMaker
from nrp_legacy.shims.graph import LOGS

_NEST_UNITS = ("dc_source", "ac_source", "nc_source", "weight=")
_HELPERS = "shared"
_ALL = "all_functions"


class Functions:
    """The transfer functions of an experiment, each converted to our format if possible, else unchanged.

    Args:
        maker: makes the parts of the original.
        functions: the functions that the original runs, in order.
        kept: the reasons why some stay unchanged, by function name.

    Attributes:
        pieces: the files by their names without suffix, in the order of the document.
    """

    def __init__(
        self, maker: LegacyMaker, functions: Sequence[TransferFunction], kept: Mapping[str, str]
    ) -> None:
        self._maker, self._functions, self._kept = maker, functions, kept
        self._given = vars(maker.names.fresh())
        self.pieces = self._without_orphans(self._read())

    @property
    def needs(self) -> list[str]:
        """The features of the platform that they need."""
        needed = [
            f"{', '.join(self._names(piece)) or stem}: {piece.obstacle}"
            for stem, piece in self.pieces.items()
            if piece.obstacle
        ]
        in_units = [word for word in _NEST_UNITS if any(word in one.text for one in self.pieces.values())]
        if self._maker.bibi.nest_units and in_units:
            needed.append(f"{', '.join(in_units)} are in NEST's units")
        return needed

    @property
    def changes(self) -> list[str]:
        """The differences from the original."""
        named = ((self._names(piece) or [stem], piece) for stem, piece in self.pieces.items())
        return [f"{names[0]}: {change}" for names, piece in named for change in piece.changes]

    @property
    def shared(self) -> set[str]:
        """The names that one file uses and another one defines."""
        return {
            name for stem, piece in self.pieces.items() for name in piece.lacks
            if any(name in other.defines for key, other in self.pieces.items() if key != stem)
        }  # fmt: skip

    def texts(self, *, on_platform: bool) -> dict[str, str]:
        """Return the files, in the order in which an experiment lists them.

        Args:
            on_platform: whether they share one namespace and run in the platform's order.
        """
        if on_platform:
            return {stem: piece.text for stem, piece in self.pieces.items()}
        pieces = self.pieces
        if self.shared:
            text = "\n\n".join(piece.text for piece in pieces.values())
            defined = frozenset[str]().union(*(piece.defines for piece in pieces.values()))
            pieces = {_ALL: Piece(text, (), "", defined, frozenset())}
        place = {function.name: i for i, function in enumerate(self._functions)}
        order = sorted(pieces, key=lambda stem: min(place[name] for name in self._names(pieces[stem])))
        return {stem: pieces[stem].text + self._priorities(pieces[stem], pieces) for stem in order}

    # -- creation

    def _read(self) -> dict[str, Piece]:
        found: dict[str, Piece] = {}
        for element in self._maker.bibi.functions:
            try:
                pieces = self._pieces(element)
            except ExperimentError:
                continue  # the examination reports it
            for piece in pieces:
                names = self._names(piece)
                stem = names[0] if names else f"{_HELPERS}_{len(found)}"
                found[stem] = replace(piece, text=piece.text + _settings(names, element))
        return found

    def _pieces(self, element: Element) -> list[Piece]:
        bibi = self._maker.bibi
        sources = part_source(element, bibi.element, self._maker.library)
        pieces = []
        for source in sources:
            piece = piece_of(source)
            names = self._names(piece)
            obstacle = next((self._kept[name] for name in names if name in self._kept), "")
            if "clientLogger" in source.text and self._has_log_subscriber():
                obstacle = obstacle or "shows messages that state machines wait for"
            given = sorted(name for name in piece.lacks if name in self._given)
            if not piece.obstacle and (obstacle or given):
                piece = piece_of(source, obstacle=obstacle or f"uses {', '.join(given)}")
            pieces.append(piece)
        return pieces

    def _has_log_subscriber(self) -> bool:
        texts = (Source.of_file(path).text for path in self._maker.machines)
        return any("WaitForClientLog" in text or LOGS in text for text in texts)

    def _without_orphans(self, pieces: dict[str, Piece]) -> dict[str, Piece]:
        """Return the files that have a function, or a name that another one uses."""
        wanted = {name for piece in pieces.values() for name in piece.lacks}
        return {stem: piece for stem, piece in pieces.items() if self._names(piece) or wanted & piece.defines}

    def _names(self, piece: Piece) -> list[str]:
        return [one.name for one in self._functions if one.name in piece.defines]

    def _priorities(self, piece: Piece, pieces: Mapping[str, Piece]) -> str:
        """Return priorities, if the order of the files does not give the order of the functions."""
        if not any(len(self._flows(one.defines)) > 1 for one in pieces.values()):
            return ""
        lines = [
            f"{one.name}.priority = {2 * one.priority + (one.flow is Flow.ROBOT_TO_NEURON)}"
            for one in self._functions if one.name in piece.defines
        ]  # fmt: skip
        return "\n" + "\n".join(lines) + "\n"

    def _flows(self, names: Collection[str]) -> set[Flow]:
        return {one.flow for one in self._functions if one.name in names}


def _settings(names: Sequence[str], element: Element) -> str:
    """Return the document's settings of functions, as code."""
    lines = [f"{name}.priority = {priority_of(element)}" for name in names if priority_of(element)]
    lines += [f"{name}.active = False" for name in names if not is_active(element)]
    return "".join(f"\n{line}" for line in lines) + ("\n" if lines else "")


def write_texts(texts: Mapping[str, str], folder: Path) -> None:
    """Write files into a new folder."""
    folder.mkdir(exist_ok=True)
    for stem, text in texts.items():
        (folder / f"{stem}.py").write_text(text, encoding="utf-8")
