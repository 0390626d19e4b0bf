"""Runs a script of genomix without any change.

    python3 -m dotgen.genomix SCRIPT [ARGUMENT ...]
    python3 -i -m dotgen.genomix SCRIPT         # then call its functions: setup(), start()
"""

from __future__ import annotations

import pathlib
import sys
from typing import Any

from dotgen import genomix
from dotgen.genomix import event


def main(names: dict[str, Any]) -> None:
    """Executes the script that the command line names. There, `import genomix` is `dotgen.genomix`."""
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        raise SystemExit("usage: python3 -m dotgen.genomix SCRIPT [ARGUMENT ...]")
    sys.modules["genomix"] = genomix
    sys.modules["genomix.event"] = event
    sys.argv = sys.argv[1:]
    script = pathlib.Path(sys.argv[0])
    try:
        text = script.read_bytes()
    except OSError as error:
        raise SystemExit(f"{script}: {error.strerror}") from None
    sys.path.insert(0, str(script.resolve().parent))
    names["__file__"] = str(script)
    exec(compile(text, str(script), "exec"), names)


if __name__ == "__main__":
    main(globals())
