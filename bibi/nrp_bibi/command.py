"""``nrp generate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import Json, Overwrite, require_writable
from nrp_core.cli.output import NO, complain, document

if TYPE_CHECKING:
    from nrp_bibi.model.functions import Bibi


def generate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A BIBI file; with --reverse, a Python file.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write to this file.")] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Write nothing; fail if an output is missing or out of date."),
    ] = False,
    reverse: Annotated[bool, typer.Option("--reverse", help="Make a model from Python.")] = False,
    diagram: Annotated[
        Path | None, typer.Option("--diagram", metavar="FILE.svg", help="Draw the model to this file.")
    ] = None,
    imports: Annotated[bool, typer.Option(help="Begin with import statements (optional).")] = True,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Turn a BIBI model into Python, Python into a model, and draw either as a diagram."""
    text = _text(file, reverse=reverse, imports=imports)
    wanted = {} if output is None else {output: text}
    if diagram is not None:
        wanted[diagram] = _drawing(file, reverse=reverse)
    stale = [path for path in wanted if not path.is_file() or path.read_text("utf-8") != wanted[path]]
    if not check:
        from nrp_core.utilities import replace_file

        for path in stale:
            require_writable(path, "--output" if path == output else "--diagram", overwrite=overwrite)
        for path in stale:
            replace_file(path, wanted[path])
    if json:
        document({"file": file, "text": text, "outputs": list(wanted), "changed": stale})
    elif not (wanted or check):
        typer.echo(text, nl=False)
    for path in stale if check and not json else ():
        complain(f"{path} differs from the output for {file}; run without --check to write it")
    raise typer.Exit(NO if check and stale else 0)


def _text(file: Path, *, reverse: bool, imports: bool) -> str:
    from nrp_bibi.generation.transformation import generate as generated
    from nrp_bibi.writer import bibi_text

    model = _model(file, reverse=reverse)
    return bibi_text(model) if reverse else generated(model, file, with_imports=imports)


def _drawing(file: Path, *, reverse: bool) -> str:
    from nrp_bibi.diagram import diagram

    return diagram(_model(file, reverse=reverse), file)


def _model(file: Path, *, reverse: bool) -> Bibi:
    from nrp_bibi.reader import read_bibi
    from nrp_bibi.reverse import reverse_file

    if file.suffix == ".py" and not reverse:
        raise typer.BadParameter(f"{file} is a Python file; use --reverse", param_hint="FILE")
    return reverse_file(file) if reverse else read_bibi(file)
