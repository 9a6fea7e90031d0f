"""Drafts of files: edited copies that a run uses while the files remain unchanged."""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import Any


class Drafts:
    """Keeps drafts in a temporary folder until it is closed. Any thread may use it."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="nrp-cockpit-", ignore_cleanup_errors=True)
        self._originals: dict[str, str] = {}  # is never changed, only replaced
        self._replacing = threading.Lock()

    def write(self, path: Path, text: str) -> Path:
        """Write a draft of a file and return it.

        Its folder has links to the file's neighbours, so that imports work.
        """
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        for sibling in path.resolve().parent.iterdir():
            if sibling.name != path.name:
                (folder / sibling.name).symlink_to(sibling)
        draft = folder / path.name
        draft.write_text(text, encoding="utf-8")
        with self._replacing:
            self._originals = {**self._originals, str(draft): str(path)}
        return draft

    def remove(self, paths: Iterable[Path]) -> None:
        """Remove those of these files that are drafts; they must not be in use."""
        with self._replacing:
            gone = self._originals.keys() & {str(path) for path in paths}
            self._originals = {draft: path for draft, path in self._originals.items() if draft not in gone}
        for draft in gone:
            shutil.rmtree(Path(draft).parent, ignore_errors=True)

    def in_place(self, value: Any) -> Any:
        """Return data with the names of drafts replaced by those of their files."""
        match value:
            case str() if self._folder.name in value:
                for draft, original in self._originals.items():
                    value = value.replace(draft, original)
            case dict():
                return {key: self.in_place(item) for key, item in value.items()}
            case list():
                return [self.in_place(item) for item in value]
        return value

    def close(self) -> None:
        """Remove all drafts."""
        self._folder.cleanup()
