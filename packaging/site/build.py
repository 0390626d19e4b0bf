"""Builds the documentation site: `python packaging/site/build.py OUT`.

Copies docs/ and the README into a temporary folder and runs MkDocs there. Links to files outside of docs/
become links to the repository. The environment variable REPOSITORY has its address.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REPOSITORY = os.environ.get("REPOSITORY", "https://github.com/OWNER/dotgen")
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")


def link(place: Path, home: bool, match: re.Match[str]) -> str:
    """Returns a link of the page that is at `place` in the repository, as it is on the site."""
    before, path, anchor, after = match[1], match[2], match[3] or "", match[4]
    if "://" in path or path.startswith("mailto:"):
        return match[0]
    target = (place.parent / path).resolve()
    if not target.exists():
        return match[0]
    if target == ROOT / "README.md":
        return before + os.path.relpath(ROOT / "docs/index.md", place.parent) + anchor + after
    if target.is_relative_to(ROOT / "docs") and target.is_file():
        return before + os.path.relpath(target, ROOT / "docs" if home else place.parent) + anchor + after
    kind = "tree" if target.is_dir() else "blob"
    return f"{before}{REPOSITORY}/{kind}/main/{target.relative_to(ROOT).as_posix()}{anchor}{after}"


def page(source: Path, goal: Path, home: bool = False) -> None:
    """Writes a page, with its links changed outside of examples."""
    parts = re.split(r"(^ *```.*?^ *```$)", source.read_text("utf-8"), flags=re.M | re.S)
    for at in range(0, len(parts), 2):
        parts[at] = LINK.sub(lambda match: link(source, home, match), parts[at])
    goal.parent.mkdir(parents=True, exist_ok=True)
    goal.write_text("".join(parts), "utf-8")


def main() -> int:
    out = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        pages = Path(folder) / "pages"
        shutil.copytree(ROOT / "docs", pages)
        for source in (ROOT / "docs").rglob("*.md"):
            page(source, pages / source.relative_to(ROOT / "docs"))
        page(ROOT / "README.md", pages / "index.md", home=True)
        shutil.copy(ROOT / "packaging/site/mkdocs.yml", folder)
        command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(out)]
        return subprocess.run(command, cwd=folder, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
