"""What the documentation site makes of pages, and what it refuses."""

from pathlib import Path, PurePosixPath

import pytest
from pages import on_the_site
from verify import faults


def test_a_link_to_a_source_file_leads_to_a_page_that_shows_it() -> None:
    linked: set[PurePosixPath] = set()
    text = "[one](../../nrp_core/simulation.py), [two](../README.md#how-to)\n"
    page = on_the_site(text, PurePosixPath("docs/howto/use-pynn.md"), linked)
    assert page == "[one](../source/nrp_core/simulation.py.md), [two](../contents.md#how-to)\n"
    assert linked == {PurePosixPath("nrp_core/simulation.py")}


def test_code_keeps_what_looks_like_a_link_and_comments_go() -> None:
    text = "<!-- not run: no network -->\n```sh\necho [a](b.md)\n```\n"
    page = on_the_site(text, PurePosixPath("docs/howto/use-pynn.md"), set())
    assert page == "```sh\necho [a](b.md)\n```\n"


def test_equations_become_mathml_and_code_keeps_its_dollars() -> None:
    text = "From $`x_0`$ on:\n\n```math\n\\frac{a}{b}\n```\n\n```sh\necho $`pwd`$\n```\n"
    page = on_the_site(text, PurePosixPath("docs/howto/use-pynn.md"), set())
    assert page.count("<math ") == page.count("</math>") == 2
    assert "<msub><mi>x</mi>" in page
    assert "<mfrac>" in page
    assert "echo $`pwd`$" in page


def test_bars_in_the_code_of_a_table_are_shown_without_a_backslash() -> None:
    text = "| `--pace max\\|FACTOR`, `a\\|b\\|c` | `x` |\n"
    page = on_the_site(text, PurePosixPath("docs/howto/use-pynn.md"), set())
    assert page == "| `--pace max|FACTOR`, `a|b|c` | `x` |\n"


def test_a_link_to_a_file_that_is_missing_ends_the_build() -> None:
    with pytest.raises(SystemExit, match=r"use-pynn\.md: links to nothing\.md"):
        on_the_site("[a](nothing.md)", PurePosixPath("docs/howto/use-pynn.md"), set())


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('<a href="b.html">', "links to b.html, and there is no such file"),
        ('<a href="#b">', "links to #b, and the page has no such heading"),
        ('<script src="https://example.org/a.js">', "loads https://example.org/a.js"),
        ('<link rel="stylesheet" href="//example.org/a.css">', "loads //example.org/a.css"),
        ('<h1 id="b"></h1><a href="a.html#b"><a href="https://example.org">', None),
    ],
)
def test_the_built_site_is_searched_for_broken_links_and_foreign_files(
    body: str, fault: str | None, tmp_path: Path
) -> None:
    (tmp_path / "a.html").write_text(body)
    assert faults(tmp_path) == ([] if fault is None else [f"a.html: {fault}"])
