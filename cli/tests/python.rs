//! What Python's tools say: mypy of the client and of the stubs of components, the packages of MCAP and
//! Perfetto of recordings and traces.

use std::path::Path;
use std::process::Command;

use crate::directory::{Directory, status, stderr, stdout};

/// Python with packages; they are installed where they are not there and can be.
pub(crate) fn python(packages: &[&str], import: &str) -> Option<Command> {
    let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join(packages.join("-"));
    let python = || {
        let mut command = Command::new("python3");
        let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python");
        let path = std::env::join_paths([&own, &client]).expect("no colons");
        command.env("PYTHONPATH", path).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    };
    let works = || {
        let output = python().args(["-c", import]).output();
        output.is_ok_and(|output| output.status.success())
    };
    if !works() {
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "install", "--quiet", "--target"]);
        let installed = pip.arg(&own).args(packages).output();
        if !installed.is_ok_and(|output| output.status.success()) || !works() {
            let packages = packages.join(", ");
            dotgen_loaders::skip(format_args!(
                "there is no {packages} for Python, and it cannot be installed"
            ));
            return None;
        }
    }
    Some(python())
}

const USE: &str = "from __future__ import annotations
import dotgen
from typing import Optional, TYPE_CHECKING
if TYPE_CHECKING:
    from echo import Echo
    from reader import Reader

echo: Echo = dotgen.connect().load(\"echo\")
seen: int = echo.count(n=2)
counting: dotgen.Activity[int] = echo.count(3, ack=True)
seen = counting.wait(timeout=1)
partial: Optional[int] = counting.result
echo.count(3, ack=True, callback=lambda activity: print(activity.status), timeout=1)
echo.set_gain()
echo.fail(1)
value = echo.mirror(echo.mirror())
name: str = value[\"name\"]
for each in echo.each:
    seen = each
reader: Reader = dotgen.connect().load(\"reader\")
reader.trail.write([{\"x\": 1, \"y\": 2}])
reader.each.write(3, instance=\"a\")
for violation in dotgen.connect().violations():
    name = violation[\"what\"]
";

#[test]
fn stubs_are_strict_and_find_what_is_wrong() {
    let Some(mut mypy) = python(&["mypy"], "import mypy.api") else {
        return;
    };
    mypy.args(["-m", "mypy"]);
    let gen_file = include_str!("hosted/echo.gen").replace("LANG", "c");
    let directory = Directory::new(&[
        ("echo.gen", gen_file.as_str()),
        ("reader.gen", &include_str!("hosted/reader.gen").replace("LANG", "c") as &str),
        ("types.idl", include_str!("hosted/types.idl")),
        ("good.py", USE),
    ]);
    let wrong = [
        "echo.count(n='many')",
        "echo.count(m=1)",
        "echo.counts()",
        "echo.set_gain(1, 2)",
        "text: str = echo.count()",
        "value['nobody']",
        "value['c'] = 'MAUVE'",
        "echo.each()['b']",
        "echo.count(callback=1)",
        "words: str = counting.result",
        "reader.trail.write([{'x': 'far', 'y': 2}])",
        "reader.each.write('many', 'a')",
        "reader.each()",
    ];
    directory.write("bad.py", (USE.to_owned() + &wrong.join("\n") + "\n").as_bytes());
    for name in ["echo.gen", "reader.gen"] {
        let generated = directory.run(&["generate", "python", name]);
        assert_eq!(status(&generated), 0, "{}", stderr(&generated));
    }
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python/dotgen");
    mypy.current_dir(directory.path()).args([
        "--strict",
        "--cache-dir=cache",
        "--no-error-summary",
    ]);
    mypy.args(["good.py", "bad.py", "echo.pyi", "reader.pyi"]).arg(client);
    let output = mypy.output().expect("it runs");
    let said = stdout(&output);
    let lines: Vec<String> = said
        .lines()
        .filter(|line| line.contains(": error:"))
        .map(|line| line.split(": error:").next().unwrap_or_default().to_owned())
        .collect();
    let mut found: Vec<&String> = lines.iter().collect();
    found.dedup();
    let first = USE.lines().count() + 1;
    let expected: Vec<String> =
        (first..first + wrong.len()).map(|line| format!("bad.py:{line}")).collect();
    assert_eq!(found, expected.iter().collect::<Vec<_>>(), "{said}{}", stderr(&output));
}

/// Reads a recording and a trace of the pump, strictly.
const READ: &str = "import json
from google.protobuf import unknown_fields
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from perfetto.protos.perfetto.trace import perfetto_trace_pb2 as protos

with open('run.mcap', 'rb') as file:
    kinds = {type(it).__name__ for it in StreamReader(file, validate_crcs=True).records}
assert {'Header', 'Message', 'DataEnd', 'Statistics', 'Footer'} <= kinds, kinds
with open('run.mcap', 'rb') as file:
    reader = make_reader(file, validate_crcs=True)
    summary = reader.get_summary()
    count = 0
    for schema, channel, message in reader.iter_messages():
        assert channel.message_encoding == 'json' and schema.encoding == 'jsonschema'
        json.loads(schema.data), json.loads(message.data)
        count += 1
    assert count == summary.statistics.message_count > 100, count

def unknown(message):
    count = len(unknown_fields.UnknownFieldSet(message))
    for field, value in message.ListFields():
        if field.message_type is not None:
            values = [value] if isinstance(value, type(message)) or hasattr(value, 'ListFields') else value
            count += sum(unknown(it) for it in values)
    return count

trace = protos.Trace()
with open('run.pftrace', 'rb') as file:
    trace.ParseFromString(file.read())
assert unknown(trace) == 0
tracks, open_slices, times = set(), {}, {}
for packet in trace.packet:
    if packet.HasField('track_descriptor'):
        track = packet.track_descriptor
        assert not track.HasField('parent_uuid') or track.parent_uuid in tracks
        tracks.add(track.uuid)
    if packet.HasField('track_event'):
        event = packet.track_event
        track = event.track_uuid
        assert track in tracks
        assert times.get(track, 0) <= packet.timestamp
        times[track] = packet.timestamp
        if event.type == event.TYPE_SLICE_BEGIN:
            open_slices[track] = open_slices.get(track, 0) + 1
        elif event.type == event.TYPE_SLICE_END:
            open_slices[track] -= 1
            assert open_slices[track] >= 0
assert len(tracks) > 4 and not any(open_slices.values()), open_slices
";

#[test]
fn recordings_and_traces_are_read_by_the_packages_of_their_formats() {
    let packages = ["mcap", "perfetto", "protobuf"];
    let import = "import mcap.reader, perfetto.protos.perfetto.trace.perfetto_trace_pb2";
    let Some(mut python) = python(&packages, import) else {
        return;
    };
    let directory = Directory::new(&[("read.py", READ)]);
    let pump = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/pump/pump.scn");
    let pump = pump.to_str().expect("it is text");
    let words = ["--until", "2s", "--record", "run.mcap", "--trace", "run.pftrace"];
    let run = directory.run(&[&["run", pump, "--bounds", "none"], &words[..]].concat());
    assert_eq!(status(&run), 0, "{}", stderr(&run));
    let output = python.arg("read.py").current_dir(directory.path()).output();
    let output = output.expect("it runs");
    assert!(output.status.success(), "{}", stderr(&output));
}
