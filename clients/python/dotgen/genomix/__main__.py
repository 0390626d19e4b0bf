"""Runs a script of genomix without any change: `python3 -m dotgen.genomix SCRIPT [ARGUMENT ...]`."""

from __future__ import annotations

import pathlib
import runpy
import sys

from dotgen import genomix
from dotgen.genomix import event


def main() -> None:
    """Runs the script that the command line names. There, `import genomix` is `dotgen.genomix`."""
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        raise SystemExit("usage: python3 -m dotgen.genomix SCRIPT [ARGUMENT ...]")
    sys.modules["genomix"] = genomix
    sys.modules["genomix.event"] = event
    script = sys.argv[1]
    sys.argv = sys.argv[1:]
    sys.path.insert(0, str(pathlib.Path(script).resolve().parent))
    runpy.run_path(script, run_name="__main__")


if __name__ == "__main__":
    main()
