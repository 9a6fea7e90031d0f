"""The files of the page."""

from __future__ import annotations

import gzip
import mimetypes
import re
from collections.abc import Iterable
from functools import lru_cache
from http import HTTPStatus
from pathlib import Path

from websockets.datastructures import Headers
from websockets.http11 import Response

from nrp_cockpit.wire.guard import CONTENT_POLICY

STATIC = (Path(__file__).parent.parent / "static").resolve()
_TYPES = {".js": "text/javascript", ".css": "text/css", ".html": "text/html; charset=utf-8",
          ".md": "text/plain; charset=utf-8"}  # fmt: skip
_PACKED = (".js", ".css", ".html", ".svg", ".md")
"""Suffixes of the files that become much smaller."""
_REFUSED = re.compile(r";\s*q=0(\.0*)?\s*$")


def file_response(path: str, folder: Path = STATIC, accepted: Iterable[str] = ()) -> Response:
    """Return the response with a file of the page, or with "not found".

    Args:
        path: the path of the request.
        folder: the folder of the page, without symbolic links.
        accepted: the values of the headers ``Accept-Encoding``: clients that take gzip get text packed.
    """
    if not folder.is_dir():
        return plain(HTTPStatus.NOT_FOUND, "the page has not been built: npm run build, in page/")
    wanted = _file(path, folder)
    if wanted is None:
        return plain(HTTPStatus.NOT_FOUND, "there is no such page")
    kind = _TYPES.get(wanted.suffix) or mimetypes.guess_type(wanted.name)[0] or "application/octet-stream"
    # names in assets/ hold a hash of their content
    keep = "public, max-age=31536000, immutable" if wanted.parent.name == "assets" else "no-cache"
    if wanted.suffix not in _PACKED:
        return _response(HTTPStatus.OK, kind, wanted.read_bytes(), keep)
    body = _packed(wanted, wanted.stat().st_mtime_ns) if _takes_gzip(accepted) else wanted.read_bytes()
    response = _response(HTTPStatus.OK, kind, body, keep)
    response.headers["Vary"] = "Accept-Encoding"
    if _takes_gzip(accepted):
        response.headers["Content-Encoding"] = "gzip"
    return response


def _takes_gzip(accepted: Iterable[str]) -> bool:
    codings = (one.strip().lower() for each in accepted for one in each.split(","))
    return any(one.partition(";")[0].rstrip() == "gzip" and not _REFUSED.search(one) for one in codings)


@lru_cache(maxsize=64)
def _packed(file: Path, _changed_ns: int) -> bytes:
    return gzip.compress(file.read_bytes(), mtime=0)


def _file(path: str, folder: Path) -> Path | None:
    try:
        wanted = (folder / (path.lstrip("/") or "index.html")).resolve()
        inside = wanted.is_relative_to(folder) and wanted.is_file()
    except (OSError, ValueError):  # the name is not valid for a file
        return None
    return wanted if inside and not wanted.name.startswith(".") else None


def plain(status: HTTPStatus, text: str) -> Response:
    """Return a response with one sentence."""
    return _response(status, "text/plain; charset=utf-8", f"{text}\n".encode(), "no-store")


def _response(status: HTTPStatus, kind: str, body: bytes, keep: str) -> Response:
    headers = Headers(
        {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Cache-Control": keep,
            "Content-Security-Policy": CONTENT_POLICY,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Connection": "close",
        }
    )
    return Response(status.value, status.phrase, headers, body)
