"""Text of others does not control the terminal."""

import json
import sys
from pathlib import Path

import pytest
import typer
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.cli.app import run_app
from nrp_core.cli.output import complain, document, plain_streams, visible

HOSTILE = "\x1b]0;OWNED\x07\x1b]52;c;Zm9v\x07\x9b31m\r\x08\u202egpj.exe"


def is_plain(text: str) -> bool:
    return all(one in "\n\t" or (ord(one) >= 0x20 and not 0x7F <= ord(one) < 0xA0) for one in text)


@given(st.text())
def test_a_visible_text_has_no_control_characters_and_others_are_kept(text: str) -> None:
    assert is_plain(visible(text))
    assert is_plain(text) == (visible(text) == text) or not text.isprintable()


def test_the_output_of_a_command_keeps_only_colours(capsys: pytest.CaptureFixture[str]) -> None:
    with plain_streams():
        print(HOSTILE)
        sys.stderr.write(f"{HOSTILE}\n")
        typer.echo(typer.style("name", fg="red") + HOSTILE, color=True)
        typer.echo(HOSTILE, err=True)
        complain(HOSTILE)
    told = capsys.readouterr()
    assert "\x1b[31mname\x1b[0m\\x1b]0;OWNED\\x07" in told.out
    assert is_plain(told.out.replace("\x1b[31m", "").replace("\x1b[0m", ""))
    assert is_plain(told.err)
    assert told.err.count(r"\u202egpj.exe") == 3


def test_a_document_is_the_same_data_without_control_characters(capsys: pytest.CaptureFixture[str]) -> None:
    document({"name": HOSTILE})
    written = capsys.readouterr().out
    assert is_plain(written)
    assert json.loads(written) == {"name": HOSTILE}


@pytest.mark.parametrize("command", ["validate", "inspect", "explain", "replay", "plot"])
def test_a_hostile_name_of_a_file_reaches_the_terminal_as_escapes(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a\x1b]0;OWNED\x07.yaml"
    file.write_text(f"name: {json.dumps(HOSTILE)}\n")
    run_app([command, str(file)])
    told = capsys.readouterr()
    assert is_plain(told.out + told.err)
    assert "OWNED" in told.out + told.err
