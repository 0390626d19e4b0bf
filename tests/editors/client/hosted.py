"""Components that run with codels of their own: those of the server's tests."""

import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[3]
HOSTED = ROOT / "cli/tests/hosted"


def lay_out(folder: pathlib.Path, name: str) -> None:
    """A component with codels in C, in a folder of its name."""
    component = folder / name
    (component / "codels").mkdir(parents=True)
    specification = (HOSTED / f"{name}.gen").read_text().replace("LANG", "c")
    (component / f"{name}.gen").write_text(specification)
    (component / "types.idl").write_text((HOSTED / "types.idl").read_text())
    (component / f"codels/{name}.c").write_text((HOSTED / f"{name}.c").read_text())
