"""The notebooks: kept without outputs, executed when the site is built, shown and offered with them."""

from __future__ import annotations

import base64
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from pages import on_the_site, write_page
from paths import PAGES, REPOSITORY, ROOT

FOLDER = ROOT / "docs" / "notebooks"
TIME_LIMIT_S = 600


def notebooks() -> list[Callable[[], None]]:
    """Return what executes the notebooks and writes their pages, to be called in any order or at once."""
    return [lambda path=path: _show(path) for path in sorted(FOLDER.glob("*.ipynb"))]  # type: ignore[misc]


def _show(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as folder:
        resources = {"metadata": {"path": folder}}
        client = NotebookClient(notebook, timeout=TIME_LIMIT_S, resources=resources)
        client.extra_arguments = ["--log-level=40"]
        try:
            client.execute()
        except CellExecutionError as error:
            raise SystemExit(f"{path.name}: {error}") from None
    name = PurePosixPath(path.relative_to(ROOT).as_posix())
    title, *rest = [
        on_the_site(cell.source, name, set())
        if cell.cell_type == "markdown"
        else _code(cell, path.stem, index)
        for index, cell in enumerate(notebook.cells)
    ]
    page = PurePosixPath("notebooks", f"{path.stem}.md")
    links = " · ".join([f"[Download this notebook]({path.name}){{ download }}", *_online(name, REPOSITORY)])
    write_page(page, "\n\n".join([title, links, *rest]))
    nbformat.write(notebook, PAGES / "notebooks" / path.name)  # for download, with its outputs


def _online(name: PurePosixPath, repository: str) -> list[str]:
    """Return links that open a notebook in Colab and Binder, if the repository is on GitHub."""
    owner = repository.removeprefix("https://github.com/").rstrip("/")
    if owner in ("", repository):
        return []
    return [
        f"[Colab](https://colab.research.google.com/github/{owner}/blob/main/{name})",
        f"[Binder](https://mybinder.org/v2/gh/{owner}/main?labpath={name})",
    ]


def _code(cell: Any, stem: str, index: int) -> str:
    """Return a cell and its outputs as Markdown."""
    source = cell.source.removeprefix("%%sh\n")
    language = "python" if source == cell.source else "sh"
    parts = [f"```{language}\n{source}\n```"]
    images = PAGES / "notebooks" / stem
    parts += [_output(output, images, f"{index}-{i}") for i, output in enumerate(_joined(cell.outputs))]
    return "\n\n".join(parts)


def _joined(outputs: list[Any]) -> list[Any]:
    """Return outputs with pieces of one stream that follow each other as one.

    Standard error is left out: it says what is compiled, which depends on the machine. A failure raises.
    """
    joined: list[Any] = []
    for output in outputs:
        if output.get("name") == "stderr":
            continue
        if joined and output.get("name") and output.get("name") == joined[-1].get("name"):
            joined[-1].text += output.text
        else:
            joined.append(output)
    return joined


def _output(output: Any, images: Path, name: str) -> str:
    """Return an output as Markdown; an image becomes a file in the folder of the notebook's images."""
    if output.output_type == "stream":
        return _text(output.text)
    data = output.data
    if "image/png" in data:
        images.mkdir(parents=True, exist_ok=True)
        (images / f"{name}.png").write_bytes(base64.b64decode(data["image/png"]))
        return f"![Output of the cell above]({images.name}/{name}.png)"
    if "text/html" in data:
        return f'<div class="notebook-output" markdown="0">\n{data["text/html"].strip()}\n</div>'
    return _text(data["text/plain"])


def _text(text: str) -> str:
    return f"```text {{ .notebook-output }}\n{text.rstrip()}\n```"
