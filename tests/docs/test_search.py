"""The search of the site leads from the words of a user to the answer.

The index has the fields, boosts and score of the theme's own search, ``search.js`` of Material for MkDocs,
on the sections of the Markdown files.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import lunr
import pytest
from lunr import get_default_builder
from lunr.index import Index
from paths import documents, is_searched

ROOT = Path(__file__).parents[2]
HEADING = re.compile(r"^#{1,6} (.+)$", re.MULTILINE)
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
ANSWERS = "docs/howto/i-want-to.md"
FIRST = 5
"""The number of pages that a reader looks at."""

QUERIES = {
    "which neuron fired when": "see-which-neuron-fired-when",
    "record one cell": "record-one-cell",
    "record subset of neurons": "record-one-cell",
    "plot membrane voltage": "plot-the-membrane-voltage",
    "video headless server": "make-a-video",
    "export csv matlab": "export-data",
    "debug print transfer function": "print-values",
    "figure for a paper": "make-a-figure",
    "push a body": "push-a-body",
    "apply force": "push-a-body",
    "reset robot between trials": "reset-the-robot",
    "robot fell over": "notice-a-fall",
    "notice a fall": "notice-a-fall",
    "check that it moved": "check-that-it-moved",
    "stop early": "stop-a-run-early",
    "save learned weights": "store-and-load",
    "load weights": "store-and-load",
    "freeze weights": "freeze-weights",
    "reward dopamine": "give-the-brain-a-reward",
    "own brain on the fly": "put-my-own-brain",
    "lesion neurons": "silence-or-lesion",
    "change parameter without editing": "change-a-parameter",
    "use nest": "use-nest",
    "urdf": "use-my-own-robot",
    "add camera lidar": "add-a-camera",
    "obstacle": "put-a-box",
    "two robots": "control-two-robots",
    "gravity friction": "change-gravity",
    "rviz ros": "connect-ros",
    "reinforcement learning": "train-with",
    "windows": "run-it-on-windows",
    "macos": "run-it-on-windows",
    "slurm cluster": "run-on-a-cluster",
    "many seeds": "run-many-seeds",
    "run faster gpu": "run-faster",
    "repeat exactly": "repeat-a-run",
    "compare two runs": "compare-two-runs",
    "uninstall": "install-offline",
}


def sections(document: PurePosixPath) -> Iterator[dict[str, str]]:
    """Yield the sections of a page: that of its title stands for the page."""
    parts = HEADING.split(FENCE.sub("", (ROOT / document).read_text()))
    for number, (title, text) in enumerate(zip(parts[1::2], parts[2::2], strict=True)):
        anchor = re.sub(r"[^\w\- ]", "", title).strip().lower().replace(" ", "-")
        yield {"location": f"{document}#{anchor}" if number else str(document), "title": title, "text": text}


@pytest.fixture(scope="module")
def index() -> Index:
    builder = get_default_builder()
    builder.pipeline.remove(lunr.stemmer.stemmer)
    builder.search_pipeline.remove(lunr.stemmer.stemmer)
    builder.ref("location")
    builder.b(0)
    builder.field("title", boost=1000)
    builder.field("text")
    for document in filter(is_searched, documents()):
        for section in sections(document):
            builder.add(section)
    return builder.build()


def found(index: Index, query: str) -> list[str]:
    """Return the sections that the site lists, best first."""
    terms = query.lower().split()
    scored = []
    for hit in index.search(" ".join(f"{term}*" for term in terms)):
        matched = sum(any(word.startswith(term) for word in hit["match_data"].metadata) for term in terms)
        boost = ("#" not in hit["ref"]) + matched / len(terms)
        scored.append((hit["score"] * (1 + boost**2), hit["ref"]))
    return [ref for _, ref in sorted(scored, reverse=True)]


@pytest.mark.parametrize("query", QUERIES)
def test_the_words_of_a_user_lead_to_an_answer(index: Index, query: str) -> None:
    refs = found(index, query)
    pages = list(dict.fromkeys(ref.partition("#")[0] for ref in refs))
    assert ANSWERS in pages[:FIRST]
    answer = next(ref for ref in refs if ref.startswith(f"{ANSWERS}#"))
    assert answer.startswith(f"{ANSWERS}#{QUERIES[query]}")


def test_decisions_and_tables_of_results_are_not_searched(index: Index) -> None:
    assert found(index, "decision")
    assert not [ref for ref in found(index, "decision") if ref.startswith("docs/decisions")]
    assert not is_searched(PurePosixPath("docs/reference/robots.md"))
    assert is_searched(PurePosixPath("docs/reference/scenes.md"))
