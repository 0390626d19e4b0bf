"""JSON outputs of the program, against their schemas in `docs`."""

import json
import os
import shutil
import socket
import subprocess

import jsonschema
import pytest

from hosted import ROOT, lay_out

# Schemas, and the commands whose outputs they describe; `-` for what the fixture writes.
OUTPUTS = [
    ("certificate", "-"),
    ("check", "check drift quadcopter --format json"),
    ("check", "codels check drift --format json"),
    ("deps", "deps quadcopter --format json"),
    ("diagram", "diagram fsm pump --format json"),
    ("diagram", "diagram system quadcopter --format json"),
    ("diagram", "diagram locks pump --format json"),
    ("model", "model pump/pump.gen"),
    ("monitor", "monitor run.log pump/pump.scn --format json"),
    ("monitor", "monitor run.log run.log pump/pump.scn --bounds none --format json"),
    ("monitor", "monitor run.log other/pump.gen --format json"),
    ("query", "query start pump --format json"),
    ("replay", "replay run.mcap pump/pump.scn --format json"),
    ("replay", "replay run.mcap other/pump.scn --format json"),
    ("run", "run --simulate all --until 1s pump/pump.scn --format json"),
    ("run", "run --simulate all --until 1s pump/pump.gen motor/motor.gen --format json"),
    ("run", "run --simulate all --until 2s late/pump.scn --format json"),
    ("trace", "-"),
    ("verify", "verify pump/pump.scn --format json"),
    ("verify", "verify late/pump.scn --sensitivity --format json"),
    ("verify", "verify motor/motor.gen --sensitivity --timeout 2 --format json"),
    ("verify", "verify pump/pump.scn pump/pump.gen --max-states 10 --format json"),
    ("wcet-import", "wcet import real.log echo/echo.gen --dry-run --format json"),
    ("wcet-stats", "wcet stats run.log --format json"),
]


# A check that is proved with invariants.
APART = """scenario apart {
  use "pump.gen";
  check always not (pump.control.main.exec and pump.report.start.exec);
}
"""


def dotgen(folder, arguments):
    command = [os.environ["DOTGEN"], *arguments.split()]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Examples, with logs, a recording and a trace of runs. The model of `other` is faster, that of `late` violated."""
    folder = tmp_path_factory.mktemp("outputs")
    for name in ["drift", "motor", "pump", "quadcopter"]:
        shutil.copytree(ROOT / "examples" / name, folder / name)
    for name, file, old, new in [
        ("other", "pump.gen", "wcet 4 ms", "wcet 2 ms"),
        ("late", "pump.scn", "<= 9 ms", "<= 2 ms"),
    ]:
        shutil.copytree(ROOT / "examples/pump", folder / name)
        text = (folder / name / file).read_text()
        assert old in text
        (folder / name / file).write_text(text.replace(old, new))
    (folder / "pump/apart.scn").write_text(APART)
    dotgen(folder, "verify pump/apart.scn --certificate certificate.json")
    lay_out(folder, "echo")
    files = "--profile run.log --record run.mcap --trace trace.json"
    runs = [f"pump/pump.scn --simulate all {files}", "echo/echo.gen --clock real --profile real.log"]
    for run in runs:
        dotgen(folder, f"run --until 500ms --bounds none {run}")
    return folder


def schema(name):
    return json.loads((ROOT / f"docs/{name}.schema.json").read_text())


def closed(part):
    """The schema without permission for further members."""
    if isinstance(part, list):
        return [closed(it) for it in part]
    if not isinstance(part, dict):
        return part
    part = {key: closed(it) for key, it in part.items()}
    is_object = part.get("type") == "object" and "properties" in part
    return {"additionalProperties": False, **part} if is_object else part


@pytest.mark.parametrize("name, arguments", OUTPUTS)
def test_output_has_a_version_and_only_members_of_its_schema(folder, name, arguments):
    text = (folder / f"{name}.json").read_text() if arguments == "-" else dotgen(folder, arguments).stdout
    document = json.loads(text)
    jsonschema.validate(document, closed(schema(name)))
    if name == "model":
        return  # Its keys are those of the language reference, which has no version.
    for it in document if isinstance(document, list) else [document]:
        assert {"version", "format"} & it.keys(), "an output has a version"


# Requests to a run, each with the event of the last of its replies that is awaited.
REQUESTS = [
    ({"describe": None}, "description"),
    ({"progress": None}, "progress"),
    ({"profile": None}, "ran"),
    ({"watch": "echo/trail", "newest": True}, "data"),
    ({"read": "echo/each"}, "data"),
    ({"call": "echo.count"}, "done"),
    ({"call": "echo.fail", "input": {"code": 1}}, "failed"),
    ({"call": "echo.connect_port", "input": {"local": "a", "remote": "b"}}, "failed"),
    ({"call": "echo.nothing"}, "error"),
    ({"write": "echo/trail", "value": []}, "error"),
    ({"abort": 99}, "error"),
]


def test_every_reply_at_the_socket_has_a_version_and_only_members_of_its_schema(folder):
    arguments = "run echo/echo.gen --clock real --bounds none --socket s"
    command = [os.environ["DOTGEN"], *arguments.split()]
    run = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)
    validator = jsonschema.Draft202012Validator(closed(schema("socket")))
    try:
        assert any("listening" in line for line in run.stderr)
        client = socket.socket(socket.AF_UNIX)
        client.connect(str(folder / "s"))
        replies = map(json.loads, client.makefile())
        for number, (request, last) in enumerate(REQUESTS):
            client.sendall(json.dumps({"id": number, **request}).encode() + b"\n")
            for reply in replies:
                validator.validate(reply)
                if reply["id"] == number and reply["event"] in [last, "error"]:
                    assert reply["event"] == last, reply
                    break
    finally:
        run.terminate()
        run.communicate()


def test_every_schema_is_tested():
    names = {it.name.split(".")[0] for it in (ROOT / "docs").glob("*.schema.json")}
    assert names == {name for name, _ in OUTPUTS} | {"dotgen", "socket"}, "dotgen.schema.json is about settings"
