"""Commands that other packages add."""

import json
import re
from collections.abc import Callable
from typing import Any

import pytest
from golden import Golden

Nrp = Callable[..., Any]
Install = Callable[..., None]

FUNCTION = """
import json as js
from typing import Annotated
import typer

def greet(name: str, json: bool = False) -> None:
    \"\"\"Greet somebody.\"\"\"
    print(js.dumps({"hello": name}) if json else f"hello {name}")
"""
APP = """
import typer

app = typer.Typer()

@app.command()
def one() -> None:
    print("one")

@app.command()
def two() -> None:
    raise typer.Exit(7)
"""


def test_a_function_becomes_a_command(nrp: Nrp, install: Install) -> None:
    install("greeter", "[nrp_core.commands]\ngreet = greeter:greet\n", FUNCTION)
    assert nrp("greet", "you").out == "hello you\n"
    assert json.loads(nrp("greet", "you", "--json").out) == {"hello": "you"}


def test_an_app_becomes_a_family_of_commands(nrp: Nrp, install: Install) -> None:
    install("family", "[nrp_core.commands]\nfamily = family:app\n", APP)
    assert nrp("family", "one").out == "one\n"
    assert nrp("family", "two").code == 7


def test_the_help_text_names_added_commands_without_importing_them(nrp: Nrp, install: Install) -> None:
    install("broken_tool", "[nrp_core.commands]\nmend = broken_tool:mend\n", "raise ImportError('no')")
    done = nrp("--help")
    assert done.code == 0
    assert re.search(r"mend +added by broken_tool \(broken_tool 1\.0\)", done.out)


def test_a_broken_command_is_one_clear_error_when_it_is_called(
    nrp: Nrp, install: Install, golden: Golden
) -> None:
    install("broken_tool", "[nrp_core.commands]\nmend = broken_tool:mend\n", "raise ImportError('no')")
    done = nrp("mend")
    assert done.code == 4
    assert "broken_tool 1.0 (broken_tool:mend)" in done.err
    golden(done.err)


def test_commands_of_the_core_cannot_be_replaced(
    nrp: Nrp, install: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("greeter", "[nrp_core.commands]\nschema = greeter:greet\n", FUNCTION)
    assert "$schema" in nrp("schema", "experiment").out
    assert "added by greeter" not in nrp("--help").out


def test_commands_of_this_distribution_are_summarised_though_they_are_added_like_any_other(nrp: Nrp) -> None:
    done = nrp("--help")
    assert re.search(r"(?m)^  import +Convert an experiment of another platform", done.out)
    assert "Commands of other packages" not in done.out
