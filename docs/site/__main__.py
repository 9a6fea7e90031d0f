"""Build the documentation site into ``build/site``: ``python docs/site [--reuse] [--serve [PORT]]``."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import matplotlib as mpl
from gallery import FIGURES, figures, write_gallery
from navigation import navigation
from notebooks import notebooks
from pages import write_documents
from paths import PAGES, REPOSITORY, ROOT, SITE
from reference import write_reference
from ruamel.yaml import YAML
from verify import faults

KEPT = ROOT / "build" / "docs-kept"
"""Figures and pages of notebooks of the last build."""


def main() -> None:
    """Build the site, check it, and serve it if asked to."""
    parser = argparse.ArgumentParser(prog="scripts/docs", description="Build the documentation site.")
    parser.add_argument("--reuse", action="store_true", help="take figures and notebooks of the last build")
    parser.add_argument("--serve", nargs="?", const=8000, type=int, metavar="PORT", help="then serve it")
    options = parser.parse_args()
    began = time.monotonic()
    # commands in notebooks are those of this environment, and write for a page, not for a terminal
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    os.environ["TTY_COMPATIBLE"] = "0"
    write_pages(reuse=options.reuse and KEPT.is_dir())
    generate()
    if found := faults(SITE):
        raise SystemExit("\n".join(found))
    count = len(list(SITE.rglob("*.html")))
    print(f"{count} pages in {SITE.relative_to(ROOT)}, {time.monotonic() - began:.0f} s")
    if options.serve is not None:
        serve(options.serve)


def write_pages(*, reuse: bool) -> None:
    """Write everything that the generator reads.

    Args:
        reuse: experiments and notebooks are not run; what the last build made of them is taken.
    """
    shutil.rmtree(PAGES, ignore_errors=True)
    write_documents()
    if reuse:
        shutil.copytree(KEPT, PAGES, dirs_exist_ok=True)
    else:
        run_all([*figures(), *notebooks()])
        keep()
    write_gallery()
    reference = write_reference()
    shutil.copytree(ROOT / "docs" / "site" / "assets", PAGES / "assets")
    # lowers subscripts where the reader has no font for equations
    shutil.copy(Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSerif.ttf"), PAGES / "assets")
    settings = {
        "INHERIT": "../docs/site/mkdocs.yml",
        "docs_dir": "docs",
        "site_dir": "site",
        "nav": navigation(reference),
    }
    if REPOSITORY:
        settings["repo_url"] = REPOSITORY
    YAML().dump(settings, PAGES.parent / "mkdocs.yml")


def run_all(jobs: list[Callable[[], None]]) -> None:
    """Run jobs, each of which keeps one processor busy, on as many as there are."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in [pool.submit(job) for job in jobs]:
            done.result()


def keep() -> None:
    """Keep what experiments and notebooks made, for a build that reuses it."""
    shutil.rmtree(KEPT, ignore_errors=True)
    shutil.copytree(PAGES / "notebooks", KEPT / "notebooks")
    shutil.copytree(FIGURES, KEPT / FIGURES.relative_to(PAGES))


def generate() -> None:
    """Make the site of the pages; any warning of the generator is an error."""
    command = [sys.executable, "-P", "-m", "mkdocs", "--quiet", "build", "--strict", "--clean"]
    command += ["--config-file", str(PAGES.parent / "mkdocs.yml")]
    # the theme announces the end of its support, May 2027, in every build
    if subprocess.run(command, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, check=False).returncode:
        raise SystemExit("the site was not built")


def serve(port: int) -> None:
    """Serve the site on this machine alone."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(SITE))
    with ThreadingHTTPServer(("127.0.0.1", port), handler) as server:
        print(f"http://127.0.0.1:{server.server_port}/")
        server.serve_forever()


if __name__ == "__main__":
    main()
