"""Turn the repository's Markdown files into pages whose links hold on the site.

The files are written for a code host. There a link may lead to any file; on the site
a linked source file gets a page that shows it.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import PurePosixPath

from latex2mathml.converter import convert
from paths import PAGES, ROOT, documents, is_searched, page_of, source_page_of

GALLERY = PurePosixPath("docs", "gallery.md")
_FENCE = re.compile(r"^(```+|~~~+).*?^\1\s*$", re.MULTILINE | re.DOTALL)
_EQUATION = re.compile(r"```math\n(.*)\n```\s*", re.DOTALL)
_FORMULA = re.compile(r"\$`(.+?)`\$")
_CODE_IN_ROW = re.compile(r"(?<=`)[^`\n]*\\\|[^`\n]*(?=`)")
_LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
_COMMENT = re.compile(r"^<!--.*?-->\n", re.MULTILINE)
_LANGUAGES = {".py": "python", ".yaml": "yaml", ".sdf": "xml", ".toml": "toml", ".cff": "yaml", ".sh": "sh"}


def write_page(page: PurePosixPath, text: str) -> None:
    """Write a page, which makes its folder."""
    target = PAGES / page
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(text)


def write_documents() -> None:
    """Write every Markdown file as a page, with its images and the source files that it links to."""
    shutil.copytree(ROOT / "docs" / "images", PAGES / "images")
    linked: set[PurePosixPath] = set()
    for document in documents():
        page = page_of(document)
        assert page is not None
        front = "" if is_searched(document) else "---\nsearch:\n  exclude: true\n---\n"
        write_page(page, front + on_the_site((ROOT / document).read_text(), document, linked))
    for file in sorted(linked):
        _write_source(file)


def on_the_site(text: str, document: PurePosixPath, linked: set[PurePosixPath]) -> str:
    """Return a document with its links changed to those of the site, equations in MathML, without comments.

    Equations are written as code hosts show them: blocks of ``math``, and ``$`x`$`` in a sentence.

    Args:
        text: of the document.
        document: its path in the repository; a notebook counts as one.
        linked: receives the source files that it links to.
    """
    parts, end = [], 0
    for fence in _FENCE.finditer(text):
        equation = _EQUATION.fullmatch(fence[0])
        code = f"{convert(equation[1], display='block')}\n\n" if equation else fence[0]
        parts += [_relink(text[end : fence.start()], document, linked), code]
        end = fence.end()
    return "".join([*parts, _relink(text[end:], document, linked)])


def _relink(text: str, document: PurePosixPath, linked: set[PurePosixPath]) -> str:
    def changed(match: re.Match[str]) -> str:
        target, mark, heading = match[1].partition("#")
        if "://" in match[1] or not target:
            return match[1]
        return _link(document, target, linked) + mark + heading

    text = _FORMULA.sub(lambda match: convert(match[1]), _COMMENT.sub("", text))
    # code hosts need the backslash in a table; the generator would show it
    text = _CODE_IN_ROW.sub(lambda match: match[0].replace(r"\|", "|"), text)
    return _LINK.sub(changed, text)


def _link(document: PurePosixPath, target: str, linked: set[PurePosixPath]) -> str:
    """Return the link of the site for a link of the repository."""
    here = page_of(document)
    assert here is not None
    file = PurePosixPath(os.path.normpath(document.parent / target))
    if not (ROOT / file).exists() and file != GALLERY:
        raise SystemExit(f"{document}: links to {target}, which does not exist")
    if (ROOT / file / "README.md").is_file():
        file /= "README.md"
    page = page_of(file)
    if page is None:
        linked.add(file)
        page = source_page_of(file)
    return os.path.relpath(page, here.parent)


def _write_source(file: PurePosixPath) -> None:
    """Write the page that shows a source file, or lists a folder."""
    path = ROOT / file
    if path.is_dir():
        names = sorted(each.name for each in path.iterdir() if not each.name.startswith(("_", ".")))
        body = "\n".join(f"- `{name}`" for name in names)
    else:
        body = f"~~~~~~ {{ .{_LANGUAGES.get(path.suffix, 'text')} linenums=1 }}\n{path.read_text()}\n~~~~~~"
    front = "---\nsearch:\n  exclude: true\nhide: [toc]\n---\n"
    write_page(source_page_of(file), f"{front}# `{file}`\n\n{body}\n")
