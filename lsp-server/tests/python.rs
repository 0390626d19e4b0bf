//! The Python client and the stubs of components, as mypy sees them.

use std::path::Path;
use std::process::Command;

#[path = "support/directory.rs"]
mod directory;

use directory::{Directory, status, stderr, stdout};

/// Python with mypy; installed where it is not there and can be.
fn mypy() -> Option<Command> {
    let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mypy");
    let python = |own: &Path| {
        let mut command = Command::new("python3");
        let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python");
        let path = std::env::join_paths([own, &client]).expect("no colons");
        command
            .env("PYTHONPATH", path)
            .env("PYTHONDONTWRITEBYTECODE", "1");
        command.args(["-m", "mypy"]);
        command
    };
    let works = |mut it: Command| {
        it.arg("--version")
            .output()
            .is_ok_and(|it| it.status.success())
    };
    if !works(python(&own)) {
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "install", "--quiet", "--target"]);
        let installed = pip.arg(&own).arg("mypy").output();
        if !installed.is_ok_and(|it| it.status.success()) || !works(python(&own)) {
            eprintln!("SKIPPED: there is no mypy, and it cannot be installed");
            return None;
        }
    }
    Some(python(&own))
}

const USE: &str = "from __future__ import annotations
import dotgen
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from echo import Echo

echo: Echo = dotgen.connect().load(\"echo\")
seen: int = echo.count(n=2)
counting: dotgen.Activity[int] = echo.count(3, ack=True)
seen = counting.wait(timeout=1)
echo.set_gain()
echo.fail(1)
value = echo.mirror(echo.mirror())
name: str = value[\"name\"]
for each in echo.each:
    seen = each
";

#[test]
fn stubs_are_strict_and_find_what_is_wrong() {
    let Some(mut mypy) = mypy() else { return };
    let gen_file = include_str!("hosted/echo.gen").replace("LANG", "c");
    let directory = Directory::new(&[
        ("echo.gen", gen_file.as_str()),
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
    ];
    directory.write(
        "bad.py",
        (USE.to_owned() + &wrong.join("\n") + "\n").as_bytes(),
    );
    let generated = directory.run(&["generate", "python", "echo.gen"]);
    assert_eq!(status(&generated), 0, "{}", stderr(&generated));
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python/dotgen");
    mypy.current_dir(directory.path()).args([
        "--strict",
        "--cache-dir=cache",
        "--no-error-summary",
    ]);
    mypy.args(["good.py", "bad.py", "echo.pyi"]).arg(client);
    let output = mypy.output().expect("it runs");
    let said = stdout(&output);
    let lines: Vec<String> = said
        .lines()
        .filter(|it| it.contains(": error:"))
        .map(|it| it.split(": error:").next().unwrap_or_default().to_owned())
        .collect();
    let mut found: Vec<&String> = lines.iter().collect();
    found.dedup();
    let first = USE.lines().count() + 1;
    let expected: Vec<String> = (first..first + wrong.len())
        .map(|it| format!("bad.py:{it}"))
        .collect();
    assert_eq!(
        found,
        expected.iter().collect::<Vec<_>>(),
        "{said}{}",
        stderr(&output)
    );
}
