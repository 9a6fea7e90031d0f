"""HTML files with a page and its data in themselves."""

from __future__ import annotations

import base64
import hashlib
import html
from collections.abc import Mapping
from pathlib import Path

from nrp_cockpit.wire.files import STATIC
from nrp_core.errors import NrpError

_PAGE = STATIC / "shared"
_POLICY = (
    "default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src blob: data:; "
    "base-uri 'none'; form-action 'none'"
)
"""Nothing is loaded from anywhere, and no other script runs."""


def html_page(title: str, blocks: Mapping[str, bytes]) -> str:
    """Return an HTML file with the page and its data.

    Args:
        title: the title.
        blocks: the data by the ids of the elements that hold them, in base64.

    Raises:
        NrpError: the page has not been built.
    """
    style, script = _built("page.css"), _in_html(_built("page.js"))
    licenses = _in_html(_built("licenses.md"))
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    data = "\n".join(
        f'<script type="text/plain" id="{name}">{base64.b64encode(block).decode()}</script>'
        for name, block in blocks.items()
    )
    return f"""<!doctype html>
<html lang="en" class="theme-light">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY.format(digest=digest)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{html.escape(title)}</title>
<style>{style}</style>
</head>
<body>
<div id="root"></div>
{data}
<script type="text/plain" id="licenses">{licenses}</script>
<script type="module">{script}</script>
</body>
</html>
"""


def _built(name: str, folder: Path = _PAGE) -> str:
    try:
        return (folder / name).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise NrpError(f"{folder}: the page has not been built: npm run build, in page/") from None


def _in_html(script: str) -> str:
    """Return a script without the texts that would end or hide it in HTML; in its strings nothing changes."""
    return script.replace("</script", "<\\/script").replace("<!--", "<\\!--")
