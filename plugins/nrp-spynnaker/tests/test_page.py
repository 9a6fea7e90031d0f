"""The scripts of ``docs/reference/spynnaker-scripts.md`` print what the page says."""

import re
from pathlib import Path

import pytest
from nrp_spynnaker.live import run_script

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "spynnaker-scripts.md").read_text()
BLOCKS = re.findall(r"^```python\n(# (\w+)\.py\n.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
OUTPUT = re.compile(r"```\n\n```text\n(.*?)```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block[1])
def test_a_script_of_the_page_prints_what_follows_it(
    block: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, name = block
    after = OUTPUT.match(PAGE, PAGE.index(text) + len(text))
    (tmp_path / f"{name}.py").write_text(text)
    run_script(tmp_path / f"{name}.py")
    assert capsys.readouterr().out == (after[1] if after else "")


def test_every_row_has_a_section_with_a_script() -> None:
    rows = re.findall(r"^\| \[.+?\]\(#([\w-]+)\) \|", PAGE, re.MULTILINE)
    _, overview, *sections = PAGE.split("\n## ")
    assert overview.startswith("What each call does here\n")
    titles = {title.partition("\n")[0].lower().replace(" ", "-") for title in sections}
    assert len(rows) == len(BLOCKS) == 15
    assert set(rows) == titles
    assert all("--as" not in section and "```python\n# " in section for section in sections)
