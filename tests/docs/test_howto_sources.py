"""Pages that build a file block by block, and the file itself, do not part."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILT = {
    "write-a-brain-backend.md": ("plugins/nrp-brain-minimal/src/nrp_brain_minimal/brain.py", 200),
    "write-a-world-backend.md": ("plugins/nrp-world-minimal/src/nrp_world_minimal/engine.py", 250),
}
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def written(text: str) -> list[str]:
    """The lines that are not blank."""
    return [line for line in text.splitlines() if line.strip()]


@pytest.mark.parametrize(("page", "file", "most"), [(page, *built) for page, built in BUILT.items()])
def test_the_blocks_of_a_page_in_their_order_are_the_file_that_it_builds(page, file, most):
    source = (ROOT / file).read_text()
    assert written("".join(BLOCK.findall((ROOT / "docs" / "howto" / page).read_text()))) == written(source)
    assert source.count("\n") <= most
