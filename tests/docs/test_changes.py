"""Fragments of the changelog make a section of it, and say one thing each."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
KINDS = {
    kind["directory"]
    for kind in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["towncrier"]["type"]
}
FRAGMENTS = sorted(
    set((ROOT / "changes").iterdir()) - {ROOT / "changes" / name for name in ("README.md", "template.jinja")}
)


def fault(name: str, text: str) -> str | None:
    """Return what is wrong with a fragment."""
    match = re.fullmatch(r"\+[a-z0-9-]+\.(\w+)\.md", name)
    if match is None:
        return "its name is not +WORDS.KIND.md"
    if match[1] not in KINDS:
        return f"its kind is not one of {', '.join(sorted(KINDS))}"
    if not re.match(r"[A-Z`*]", text) or not text.endswith(".\n"):
        return "it is not made of sentences"
    if re.search(r"^(#|- |\* )|\n\n", text, re.MULTILINE):
        return "it has a heading, a list or several paragraphs"
    return None


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda path: path.name)
def test_a_fragment_is_well_formed(fragment: Path) -> None:
    assert fault(fragment.name, fragment.read_text()) is None


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("site.added.md", "A site.\n"),
        ("+site.feature.md", "A site.\n"),
        ("+site.added.md", "a site\n"),
        ("+site.added.md", "A site.\n\n- A list.\n"),
    ],
)
def test_a_malformed_fragment_is_found(name: str, text: str) -> None:
    assert fault(name, text)


def test_a_release_moves_the_fragments_into_the_changelog(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path)
    shutil.copytree(ROOT / "changes", tmp_path / "changes")
    (tmp_path / "changes" / "+other.fixed.md").write_text("It turns\nleft.\n")
    before = (ROOT / "CHANGELOG.md").read_text()
    command = [
        sys.executable,
        "-m",
        "towncrier",
        "build",
        "--yes",
        "--version",
        "9.9",
        "--date",
        "2030-01-01",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    after = (tmp_path / "CHANGELOG.md").read_text()
    start, end = before.split("<!-- changes -->\n")
    assert after.startswith(f"{start}<!-- changes -->\n\n## 9.9 (2030-01-01)\n")
    fixed = after.split("### Fixed\n\n")[1].split("\n\n")[0]  # among those that wait for a release now
    assert "- It turns\n  left.\n" in f"{fixed}\n"
    assert after.endswith(end)
    assert {path.name for path in (tmp_path / "changes").iterdir()} == {"README.md", "template.jinja"}


def test_a_section_written_by_hand_is_dated_and_takes_the_place_of_the_fragments(tmp_path: Path) -> None:
    recipe = "packaging/conda/recipe.yaml"
    for name in (
        "pyproject.toml",
        "CITATION.cff",
        "scripts/release",
        "plugins/nrp-lab/pyproject.toml",
        recipe,
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "changes").mkdir()
    (tmp_path / "changes" / "+other.fixed.md").write_text("It turns left.\n")
    (tmp_path / "CHANGELOG.md").write_text("<!-- changes -->\n\n## 9.9.0 (not released)\n\nIt turns.\n")

    def git(*arguments: str) -> None:
        own = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *own, *arguments], cwd=tmp_path, check=True)

    git("init", "--quiet")
    git("add", ".")
    git("commit", "--quiet", "--no-verify", "-m", "Begin")
    done = subprocess.run(
        ["bash", "scripts/release", "9.9.0"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    citation = (tmp_path / "CITATION.cff").read_text()
    today = citation.split("date-released: ")[1].split("\n")[0]
    assert (tmp_path / "CHANGELOG.md").read_text() == f"<!-- changes -->\n\n## 9.9.0 ({today})\n\nIt turns.\n"
    assert not (tmp_path / "changes").exists()
    projects = [tmp_path / "pyproject.toml", tmp_path / "plugins/nrp-lab/pyproject.toml"]
    versions = [tomllib.loads(path.read_text())["project"]["version"] for path in projects]
    assert [*versions, citation.split("\nversion: ")[1].split("\n")[0]] == ["9.9.0"] * 3
    assert (tmp_path / recipe).read_text().count('\n  version: "9.9.0"\n') == 1
