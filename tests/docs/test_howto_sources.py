"""Pages that build a file block by block, and the file itself, do not part."""

import re
import subprocess
import sys
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


def test_the_examples_of_the_doors_are_parts_of_the_distribution_that_is_tested():
    lab = ROOT / "tests" / "third_party"
    page = (ROOT / "docs" / "howto" / "extend-the-platform.md").read_text()
    parts = re.findall(
        r"a part of tests/third_party/(\S+) -->\n```\w+\n(.*?)^```$", page, re.MULTILINE | re.DOTALL
    )
    assert len(parts) >= 12
    for file, text in parts:
        assert all(part in (lab / file).read_text() for part in text.strip().split("\n\n\n")), file


PATCH = re.compile(r"<<'EOF'\n(--- a/.*?)^EOF$", re.MULTILINE | re.DOTALL)
PATCHED = "contribute-a-synapse-law.md"


def test_the_patches_of_a_page_fit_the_tree_line_by_line(tmp_path):
    """The page itself runs by hand, as it compiles; ``git`` ignores added lines that stand elsewhere."""
    patches = PATCH.findall((ROOT / "docs" / "howto" / PATCHED).read_text())
    assert len(patches) == 2
    for patch in patches:
        names = re.findall(r"^--- a/(.+)$", patch, re.MULTILINE)
        for name in names:
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text((ROOT / name).read_text())
        command = ["git", "apply", "--unidiff-zero", "-"]
        subprocess.run(command, input=patch, text=True, cwd=tmp_path, check=True)
        for name in names:
            compile((tmp_path / name).read_text(), name, "exec")
            assert ruff(tmp_path / name) == []


def ruff(path):
    """Return the complaints about syntax and names."""
    select = ["--isolated", "--select", "E9,F", "--output-format", "concise"]
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "check", *select, path], capture_output=True, text=True, check=False
    )
    return [line for line in done.stdout.splitlines() if path.name in line]
