//! Programs that dotgen starts: they end with it, and previews reach nothing.
#![cfg(target_os = "linux")]

mod confined;

use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use serde_json::{Value, json};

#[allow(dead_code, reason = "shared with other tests")]
use crate::directory::{Directory, status, stderr, stdout};
use crate::server::Server;

const LAMP: &str = "component lamp { ids { long x; }; };\n";

/// Whether there is Tcl; says so if not.
fn tcl() -> bool {
    let found = ["tclsh8.6", "tclsh"].iter().any(|command| {
        let started = Command::new(command).stdin(Stdio::null()).output();
        started.is_ok()
    });
    if !found {
        dotgen_loaders::skip("no tclsh");
    }
    found
}

/// Whether the system confines; says so if not.
fn confines() -> bool {
    let lsm = std::fs::read_to_string("/sys/kernel/security/lsm").unwrap_or_default();
    let known = lsm.contains("landlock") || lsm.is_empty();
    let seccomp = Path::new("/proc/sys/kernel/seccomp/actions_avail").exists();
    if !(known && seccomp) {
        dotgen_loaders::skip("no Landlock or no seccomp");
    }
    known && seccomp
}

/// A process that is running, to be seen ending.
struct Running(OwnedFd, i32);

impl Running {
    fn new(id: i32) -> Running {
        let pid = Pid::from_raw(id).expect("a process");
        Running(pidfd_open(pid, PidfdFlags::empty()).expect("it runs"), id)
    }

    /// Fails when it does not end.
    fn ends(&self) {
        let patience = Timespec::try_from(Duration::from_secs(30)).expect("a time");
        let mut polled = [PollFd::new(&self.0, PollFlags::IN)];
        let ended = poll(&mut polled, Some(&patience)).expect("it can be watched");
        assert_eq!(ended, 1, "process {} goes on", self.1);
    }
}

/// The processes that a process has started and that run a program with such a word in its command line.
fn children(id: u32, word: &str) -> Vec<i32> {
    let tasks = std::fs::read_dir(format!("/proc/{id}/task")).expect("it runs");
    let mut out = Vec::new();
    for task in tasks.flatten() {
        let list = std::fs::read_to_string(task.path().join("children")).unwrap_or_default();
        out.extend(list.split_whitespace().filter_map(|word| word.parse::<i32>().ok()));
    }
    out.retain(|number| {
        let line = std::fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(word)
    });
    out
}

/// Waits until something is there.
fn until<T>(mut found: impl FnMut() -> Option<T>) -> T {
    let start = std::time::Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(start.elapsed() < Duration::from_mins(1), "it does not come");
        std::thread::yield_now();
    }
}

fn number_in(path: &Path) -> Option<i32> {
    std::fs::read_to_string(path).ok()?.strip_suffix('\n')?.parse().ok()
}

fn entries(path: &Path) -> usize {
    std::fs::read_dir(path).map_or(0, |entry| entry.flatten().count())
}

fn send(process: u32, signal: Signal) {
    let pid = i32::try_from(process).ok().and_then(Pid::from_raw);
    kill_process(pid.expect("a process"), signal).expect("it runs");
}

#[test]
fn a_preview_ends_with_the_server_however_that_ends() {
    if !tcl() {
        return;
    }
    for how in ["input", "term", "kill"] {
        let directory = Directory::new(&[
            ("lamp.gen", LAMP),
            ("dotgen.toml", "template-paths = [\"templates\"]\n"),
            (
                "templates/waits/template.tcl",
                "close [open [dotgen template tmpdir]/there w]\nvwait forever\n",
            ),
        ]);
        let temporary = directory.path().join("tmp");
        std::fs::create_dir(&temporary).expect("a folder");
        let uri = format!("file://{}", directory.path().display());
        let params = json!({ "capabilities": {}, "rootUri": uri,
                             "initializationOptions": { "trusted": true } });
        let mut server = Server::start_with(params, &[("TMPDIR", &temporary)]);
        let argument =
            json!({ "uri": format!("{uri}/lamp.gen"), "template": "waits", "arguments": [] });
        let params = json!({ "command": "dotgen.generate", "arguments": [argument] });
        server.send(json!({ "id": 1, "method": "workspace/executeCommand", "params": params }));
        let folder = until(|| {
            let mut all = std::fs::read_dir(&temporary).ok()?.flatten();
            all.find(|entry| entry.path().join("there").exists()).map(|entry| entry.path())
        });
        let id = server.child.id();
        let shell = children(id, "tclsh");
        assert_eq!(shell.len(), 1);
        let shell = Running::new(shell[0]);
        let helpers: Vec<Running> = children(id, "watch").into_iter().map(Running::new).collect();
        assert_eq!(helpers.len(), 1);
        match how {
            "input" => server.to = None,
            "term" => send(id, Signal::TERM),
            _ => send(id, Signal::KILL),
        }
        server.child.wait().expect("it ends");
        shell.ends();
        helpers[0].ends();
        assert!(!folder.exists(), "{how}");
    }
}

#[test]
fn what_a_template_starts_ends_with_a_killed_command() {
    if !tcl() {
        return;
    }
    let script =
        "set f [open [pwd]/started w]; puts $f [exec sleep 1000 &]; close $f; vwait forever\n";
    let directory =
        Directory::new(&[("lamp.gen", LAMP), ("templates/starts/template.tcl", script)]);
    let arguments = ["generate", "-t", "templates", "starts", "lamp.gen"];
    let mut command = directory.command(&arguments);
    let mut child = command.stdin(Stdio::null()).spawn().expect("it starts");
    let started = directory.path().join("started");
    let grandchild = Running::new(until(|| number_in(&started)));
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    grandchild.ends();
}

#[test]
fn the_package_tool_ends_with_the_server() {
    use std::os::unix::fs::PermissionsExt;
    let directory =
        Directory::new(&[("tool", "#!/bin/sh\nsleep 1000 &\necho $! >\"$TRACE\"\nwait\n")]);
    let (tool, trace) = (directory.path().join("tool"), directory.path().join("trace"));
    std::fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).expect("it runs");
    let params = json!({ "capabilities": {}, "initializationOptions": { "trusted": true } });
    let mut server = Server::start_with(params, &[("PKG_CONFIG", &tool), ("TRACE", &trace)]);
    server.open("#pragma requires \"something\"\n");
    let grandchild = Running::new(until(|| number_in(&trace)));
    server.child.kill().expect("it runs");
    server.child.wait().expect("it ends");
    grandchild.ends();
}

/// A folder with a specification and Tcl or MiniJinja templates.
fn project(templates: &[(&str, &str)]) -> Directory {
    let directory = Directory::new(&[("work/lamp.gen", LAMP)]);
    for (name, text) in templates {
        directory.write(&format!("templates/{name}"), text.as_bytes());
    }
    directory
}

fn generate(directory: &Directory, arguments: &[&str]) -> Output {
    let mut command = directory.command(&["generate", "-t", "../templates"]);
    command.args(arguments).current_dir(directory.path().join("work"));
    command.output().expect("it runs")
}

#[test]
fn a_confined_template_writes_below_the_current_folder() {
    if !tcl() {
        return;
    }
    let directory = project(&[
        (
            "plain/template.tcl",
            "file mkdir sub/empty -x/../../made\n\
             template parse raw \"text\\n\" file sub/a.txt\ntemplate parse raw x file b.sh\n",
        ),
        ("hook/template.tcl", "template parse perm 0755 raw x file .git/hooks/post-commit\n"),
        (
            "caught/template.tcl",
            "catch {template parse perm a+x raw x file run.sh}\ntemplate parse raw x file fine.txt\n",
        ),
        ("linked/template.tcl", "template parse raw x file plain/config\n"),
        ("texts/template.toml", "about = \"x\"\n[[files]]\npath = \".profile\"\nsource = \"t\"\n"),
        ("texts/t", "x"),
        (
            "leaves/template.tcl",
            "template parse raw x file a.txt\ntemplate parse raw x file ../out.txt\n",
        ),
        ("tool/template.tcl", "engine mode merge-if-change\nengine merge-tool touch\n"),
        (
            "minus/template.tcl",
            "file copy -force -- [dotgen template dir]/template.tcl -x/../../made\n",
        ),
        ("reads/template.tcl", "template parse file /etc/hostname file a.txt\n"),
        ("parses/template.tcl", "dotgen parse file /etc/hostname\n"),
    ]);
    let output = generate(&directory, &["--confined", "plain"]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    let written = std::fs::read_to_string(directory.path().join("work/sub/a.txt"));
    assert_eq!(written.expect("a file"), "text\n");
    // A folder without files is not made, wherever it is.
    assert_eq!(entries(&directory.path().join("work/sub")), 1);
    #[cfg(unix)]
    std::os::unix::fs::symlink(".git", directory.path().join("work/plain")).expect("a link");
    std::fs::create_dir(directory.path().join("work/.git")).expect("a folder");
    let work = entries(&directory.path().join("work"));
    for (template, why) in [
        (
            "hook",
            ".git/hooks/post-commit is hidden and executable, and a confined template writes such a file \
             only if you name the file: --allow .git/hooks/post-commit",
        ),
        ("linked", "plain/config is hidden"),
        ("texts", ".profile is hidden"),
        ("leaves", "is outside of"),
        ("tool", "is a program"),
        ("minus", "not allowed in a preview"),
        ("reads", "neither a file of a template nor an input"),
        ("parses", "neither a file of a template nor an input"),
    ] {
        let output = generate(&directory, &["--confined", template, "lamp.gen"]);
        assert_eq!(status(&output), 2, "{template}");
        assert!(stderr(&output).contains(why), "{template}: {}", stderr(&output));
    }
    assert_eq!(entries(directory.path()), 2, "nothing is made outside");
    assert_eq!(entries(&directory.path().join("work")), work, "nor is what came before a failure");
    // What is confirmed by name, and what a template does without what it is refused.
    let allow = ["--confined", "--allow", ".git/hooks/post-commit", "hook"];
    let output = generate(&directory, &allow);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    let hook = directory.path().join("work/.git/hooks/post-commit");
    assert!(hook.exists());
    let output = generate(&directory, &["--confined", "caught"]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    assert!(directory.path().join("work/fine.txt").exists());
    assert!(!directory.path().join("work/run.sh").exists());
    // Without the option a template does what its user can.
    let output = generate(&directory, &["leaves"]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    assert!(directory.path().join("out.txt").exists());
}

#[test]
fn a_confined_template_that_fills_its_folder_is_stopped() {
    if !tcl() {
        return;
    }
    let flood = |size: usize| {
        let text = format!("[string repeat x {size}]");
        format!(
            "while 1 {{ set f [open [dotgen template tmpdir]/[incr i] w]; puts -nonewline $f {text}; close $f }}\n"
        )
    };
    let (large, empty) = (flood(1_000_000), flood(0));
    let directory = project(&[("large/template.tcl", &large), ("empty/template.tcl", &empty)]);
    for template in ["large", "empty"] {
        let output = generate(&directory, &["--confined", template]);
        let text = stderr(&output);
        assert!(text.contains("the template has written more than it may"), "{template}: {text}");
        assert_eq!(status(&output), 2, "{template}");
    }
}

#[test]
fn texts_end_at_their_memory_and_stay_in_their_folders() {
    let double = "{% set ns = namespace(x='xxxxxxxxxxxxxxxx') %}{% for i in range(40) %}{% set ns.x = ns.x \
        ~ ns.x %}{% endfor %}{{ ns.x }}";
    let rule = |path: &str, source: &str| {
        format!("about = \"x\"\n[[files]]\npath = \"{path}\"\nsource = \"{source}\"\n")
    };
    let directory = project(&[
        ("fine/template.toml", &rule("sub/{{ name }}.txt", "t")),
        (
            "fine/t",
            "{{ model.components[0].name }} {{ 0.002 | duration }} {{ json_schema('lamp') | length > 9 }}",
        ),
        ("doubles/template.toml", &rule("a.txt", "t")),
        ("doubles/t", double),
        ("wrong/template.toml", &rule("a.txt", "t")),
        ("wrong/t", "\n{{ nope() }}"),
        ("up/template.toml", &rule("../out.txt", "../fine/t")),
        ("up2/template.toml", &rule("../out.txt", "t")),
        ("up2/t", "x"),
        ("absolute/template.toml", &rule("/tmp/dotgen-out.txt", "t")),
        ("absolute/t", "x"),
        ("links/template.toml", &rule("a.txt", "t")),
        ("through/template.toml", &rule("link/a.txt", "t")),
        ("through/t", "x"),
    ]);
    let link = |to: &str, at: &str| {
        std::os::unix::fs::symlink(to, directory.path().join(at)).expect("a link");
    };
    link("/etc/hostname", "templates/links/t");
    link("..", "work/link");
    let output = generate(&directory, &["fine", "lamp.gen"]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    let written = std::fs::read_to_string(directory.path().join("work/sub/lamp.txt"));
    assert_eq!(written.expect("a file"), "lamp 2 ms True");
    for (template, why) in [
        ("doubles", "t: stopped: rendering took more than 1024 MiB"),
        ("wrong", "t:2: "),
        ("up", "../fine/t is not in the folder of the template"),
        ("up2", "\"../out.txt\" of a result is not below"),
        ("absolute", "\"/tmp/dotgen-out.txt\" of a result is not below"),
        ("links", "t is not in the folder of the template"),
        ("through", "\"link/a.txt\" of a result is not below"),
    ] {
        let output = generate(&directory, &[template, "lamp.gen"]);
        assert_eq!(status(&output), 2, "{template}: {}", stdout(&output));
        assert!(stderr(&output).contains(why), "{template}: {}", stderr(&output));
    }
    assert_eq!(entries(directory.path()), 2);
}

/// Starts something where the kernel has neither Landlock nor seccomp, as far as it can tell.
fn without_support<T: Send>(start: impl FnOnce() -> T + Send) -> T {
    use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};
    // A filter holds for a thread and what it starts.
    std::thread::scope(|scope| {
        let thread = scope.spawn(|| {
            let calls = [libc::SYS_landlock_create_ruleset, libc::SYS_seccomp];
            let rules = calls.iter().map(|call| (*call, Vec::new())).collect();
            let missing = SeccompAction::Errno(libc::ENOSYS.cast_unsigned());
            let machine = std::env::consts::ARCH.try_into().expect("a known machine");
            let filter = SeccompFilter::new(rules, SeccompAction::Allow, missing, machine);
            let program: BpfProgram = filter.and_then(TryInto::try_into).expect("a filter");
            seccompiler::apply_filter(&program).expect("it can be installed");
            start()
        });
        thread.join().expect("no panic")
    })
}

#[test]
fn where_the_system_confines_nothing_it_is_said() {
    if !tcl() || !confines() {
        return;
    }
    let directory = project(&[
        ("plain/template.tcl", "template parse raw text file a.txt\n"),
        (
            "minus/template.tcl",
            "file copy -force -- [dotgen template dir]/template.tcl -x/../../made\n",
        ),
    ]);
    let output = without_support(|| generate(&directory, &["--confined", "plain"]));
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let said = stderr(&output);
    for gap in ["files elsewhere", "starting programs", "opening connections"] {
        assert!(said.contains(gap), "{said}");
    }
    for template in ["minus", "minus2"] {
        let output = without_support(|| generate(&directory, &["--confined", template]));
        assert_eq!(status(&output), 2, "{template}");
    }
    assert_eq!(entries(directory.path()), 2);
}

#[test]
fn a_server_outlives_a_text_that_eats_memory() {
    let directory = Directory::new(&[
        ("lamp.gen", LAMP),
        ("dotgen.toml", "template-paths = [\"templates\"]\n"),
        (
            "templates/eats/template.toml",
            "about = \"x\"\n[[files]]\npath = \"a\"\nsource = \"t\"\n",
        ),
        (
            "templates/eats/t",
            "{% set ns = namespace(x='xx') %}{% for i in range(40) %}{% set ns.x = ns.x ~ ns.x %}{% endfor \
                %}",
        ),
        ("templates/out/template.toml", "about = \"x\"\n[[files]]\npath = \"a\"\nsource = \"t\"\n"),
        ("templates/out/t", "x"),
    ]);
    let uri = format!("file://{}", directory.path().display());
    let params =
        json!({ "capabilities": {}, "rootUri": uri, "initializationOptions": { "trusted": true } });
    let mut server = Server::start_with(params, &[]);
    let mut run = |id: i64, template: &str, arguments: Value| {
        let argument = json!({ "uri": format!("{uri}/lamp.gen"), "template": template,
                               "arguments": arguments, "apply": false });
        let params = json!({ "command": "dotgen.generate", "arguments": [argument] });
        let answer = server.request(id, "workspace/executeCommand", params);
        assert_eq!(answer["result"]["status"], "failed", "{answer}");
        answer["result"]["messages"].as_str().expect("a text").to_owned()
    };
    let messages = run(1, "eats", json!([]));
    assert!(messages.contains("1024 MiB of memory"), "{messages}");
    let outside: PathBuf = directory.path().join("../elsewhere");
    let messages = run(2, "out", json!(["-C", outside.display().to_string()]));
    assert!(messages.contains("is outside of"), "{messages}");
    server.end();
}
