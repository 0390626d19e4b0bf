//! What goes wrong in a run: it ends as docs/run.md and docs/socket.md say, in time, and leaves nothing
//! behind.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{
    Listening, compilers, ended, hosts, json_of, processes, signal, soon, violation, with_body,
};

const REAL: &[&str] = &["run", "good/good.gen", "--clock", "real", "--socket", "s"];

/// A component with an activity that takes longer than it states: once with 1, for ever with 2.
fn slow() -> Directory {
    Directory::new(&[
        (
            "slow/slow.gen",
            "component slow { version \"1\"; lang \"c\"; ids { long n; };
               task main { period 10 ms; };
               activity work(in long how) { task main;
                 codel<start> slow_work(in how) yield pause::start, ether wcet 1 ms; }; };\n",
        ),
        (
            "slow/codels/slow.c",
            "#include <time.h>
#include \"acslow.h\"
#include \"slow_c_types.h\"
genom_event slow_work(int32_t how, const genom_context self) {
  struct timespec t = { 0, 30000000 };
  nanosleep(&t, NULL);
  return how == 2 ? slow_pause_start : slow_ether;
}
",
        ),
    ])
}

const SLOW: &[&str] = &[
    "run",
    "slow/slow.gen",
    "--clock",
    "real",
    "--socket",
    "s",
    "--bounds",
    "none",
    "--on-violation",
];

/// What is in a directory, sorted.
fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).expect("a directory").flatten();
    let mut all: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    all.sort();
    all
}

/// Starts the program, with nothing to read from it.
fn start(command: &mut Command) -> Child {
    let command = command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the program starts")
}

fn none_is_left(directory: &Directory) {
    soon("the end of hosts", || processes(directory).is_empty().then_some(()));
}

#[test]
fn an_activity_whose_codel_takes_too_long_ends_where_that_is_wanted() {
    if !compilers() {
        return;
    }
    let directory = slow();
    let call = ["call", "--socket", "s", "slow", "work", "{\"how\": 1}"];
    for (wanted, code) in [("report", 0), ("stop-activity", 1)] {
        let arguments = [SLOW, &[wanted]].concat();
        let mut run = Listening::start(&directory, &arguments);
        let called = directory.run(&call);
        assert_eq!(status(&called), code, "{wanted}: {}", stderr(&called));
        let told = stderr(&called).contains("::dotgen::overrun");
        assert_eq!(told, code == 1, "{}", stderr(&called));
        run.signal("-TERM");
        // Both tell of the violation.
        assert_eq!(ended(&mut run.0).code(), Some(1));
    }
}

#[test]
fn a_run_ends_with_the_first_violation_where_that_is_wanted() {
    if !compilers() {
        return;
    }
    let directory = slow();
    let mut run = Listening::start(&directory, &[SLOW, &["stop"]].concat());
    directory.run(&["call", "--socket", "s", "slow", "work", "{\"how\": 1}"]);
    assert_eq!(ended(&mut run.0).code(), Some(1));
    assert!(!directory.path().join("s").exists());
    none_is_left(&directory);
}

#[test]
fn a_client_that_goes_leaves_its_activity_to_itself() {
    if !compilers() {
        return;
    }
    let directory = slow();
    let mut run = Listening::start(&directory, &[SLOW, &["report"]].concat());
    let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    let ask = b"{\"id\": 1, \"call\": \"slow.work\", \"input\": {\"how\": 2}}\n";
    client.write_all(ask).expect("it reads");
    let mut said = String::new();
    let mut lines = BufReader::new(&client);
    lines.read_line(&mut said).expect("it answers");
    assert!(said.contains("accepted"), "{said}");
    drop(client);
    // In the middle of a line.
    let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    client.write_all(b"{\"id\": 1, \"call").expect("it reads");
    drop(client);
    let other = directory.run(&["call", "--socket", "s", "slow", "work", "{\"how\": 1}"]);
    assert_eq!(status(&other), 0, "{}", stderr(&other));
    run.signal("-TERM");
    assert_eq!(ended(&mut run.0).code(), Some(1));
    none_is_left(&directory);
}

#[test]
fn what_is_no_request_is_told_and_the_next_one_is_heard() {
    let directory = with_body("");
    let arguments = [REAL, &["--simulate", "all"]].concat();
    let run = Listening::start(&directory, &arguments);
    let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    let lines = "nonsense\n[]\n{\"id\": 3}\n{\"id\": 4, \"call\": \"good\"}\n{\"id\": 5, \"abort\": 9}\n\
                 {\"id\": 6, \"watch\": \"good/none\"}\n{\"id\": 7, \"call\": \"good.none\"}\n\
                 {\"id\": 8, \"describe\": null}\n";
    client.write_all(lines.as_bytes()).expect("it reads");
    let mut answers = BufReader::new(&client).lines();
    for id in ["null", "null", "3", "4", "5", "6", "7"] {
        let answer = answers.next().expect("an answer").expect("it is text");
        let answer: serde_json::Value = serde_json::from_str(&answer).expect("it is JSON");
        assert_eq!(answer["event"], "error", "{answer}");
        assert_eq!(answer["id"].to_string(), id, "{answer}");
    }
    let last = answers.next().expect("an answer").expect("it is text");
    assert!(last.contains("description"), "{last}");
    drop(run);
}

#[test]
fn a_host_that_is_killed_is_told_and_the_others_go_on() {
    if !compilers() {
        return;
    }
    let directory = slow();
    let mut run = Listening::start(&directory, &[SLOW, &["report"]].concat());
    let call = ["call", "--socket", "s", "slow", "work", "{\"how\": 1}"];
    let called = directory.run(&call);
    assert_eq!(status(&called), 0, "{}", stderr(&called));
    let hosts = hosts(&directory);
    assert_eq!(hosts.len(), 1);
    signal("-KILL", hosts[0]);
    // It is told as soon as it is known.
    let told = |output: &Output| stderr(output).contains("::dotgen::lost");
    let called = soon("the loss", || Some(directory.run(&call)).filter(told));
    assert_eq!(status(&called), 1);
    assert!(stderr(&called).contains("::dotgen::lost"), "{}", stderr(&called));
    run.signal("-TERM");
    assert_eq!(ended(&mut run.0).code(), Some(1));
}

#[test]
fn a_signal_ends_compilers() {
    let directory = with_body("");
    let compiler = directory.path().join("compiler");
    std::fs::write(&compiler, "#!/bin/sh\ntouch started\nsleep 1000\n").expect("written");
    std::fs::set_permissions(&compiler, std::fs::Permissions::from_mode(0o700))
        .expect("its own file");
    std::fs::create_dir(directory.path().join("tmp")).expect("a directory");
    let mut command = directory.command(&["run", "good/good.gen", "--profile", "log"]);
    let command = command.env("CC", &compiler);
    let mut run = start(command.env("TMPDIR", directory.path().join("tmp")));
    let started = directory.path().join("started");
    soon("a compiler", || started.exists().then_some(()));
    signal("-TERM", run.id());
    assert_eq!(ended(&mut run).code(), Some(3));
    assert_eq!(names(&directory.path().join("tmp")), Vec::<String>::new());
    assert_eq!(names(directory.path()), ["bad", "compiler", "good", "started", "tmp"]);
    // What was begun does not count as made.
    let objects = directory.path().join("good/.dotgen/run/good");
    assert!(!objects.join("good-run.so").exists());
}

#[test]
fn a_signal_ends_hosts_that_do_not_begin() {
    if !compilers() {
        return;
    }
    let directory = with_body("");
    let source = directory.read("good/codels/good.c");
    let begin = "__attribute__((constructor)) static void begin(void) {
  extern int creat(const char *, unsigned);
  creat(\"begun\", 0600);
  for (;;) pause();
}\n";
    directory.write("good/codels/good.c", (source + begin).as_bytes());
    for clock in ["virtual", "real"] {
        let mut arguments = vec!["run", "good/good.gen", "--clock", clock];
        arguments.extend(["--socket", "s"].iter().filter(|_| clock == "real"));
        let mut run = start(&mut directory.command(&arguments));
        let begun = directory.path().join("begun");
        soon("a host", || begun.exists().then_some(()));
        std::fs::remove_file(&begun).expect("it is there");
        signal("-TERM", run.id());
        assert_eq!(ended(&mut run).code(), Some(3), "{clock}");
        none_is_left(&directory);
        assert_eq!(names(directory.path()), ["bad", "good"]);
    }
}

#[test]
fn a_signal_ends_a_run_whose_codel_is_blocked() {
    if !compilers() {
        return;
    }
    let directory = with_body(
        "extern int creat(const char *, unsigned); creat(\"blocked\", 0600); for (;;) pause();",
    );
    let arguments = ["run", "bad/bad.gen", "--bounds", "none", "--profile", "log"];
    let mut run = start(&mut directory.command(&arguments));
    let blocked = directory.path().join("blocked");
    soon("the codel", || blocked.exists().then_some(()));
    signal("-HUP", run.id());
    assert_eq!(ended(&mut run).code(), Some(4));
    none_is_left(&directory);
    // What happened until then is told.
    assert!(directory.read("log").contains(" bad_first "));
}

#[test]
fn a_second_signal_leaves_nothing_behind() {
    let directory = with_body("");
    let arguments = [REAL, &["--simulate", "all", "--profile", "log"]].concat();
    let mut run = Listening::start(&directory, &arguments);
    // It hears of both at the same time.
    for name in ["-STOP", "-TERM", "-HUP", "-CONT"] {
        run.signal(name);
    }
    let status = ended(&mut run.0);
    assert!(matches!(status.code(), Some(1 | 3 | 4 | 130)), "{status}");
    let left = names(directory.path());
    let expected: &[&[&str]] = &[&["bad", "good"], &["bad", "good", "log"]];
    assert!(expected.iter().any(|name| left == *name), "{left:?}");
}

#[test]
fn a_log_for_which_there_is_no_room_is_told() {
    let directory = with_body("");
    let words = "run good/good.gen --simulate all --bounds none --runs 3 --profile log";
    let own = directory.command(&[]);
    let mut shell = Command::new("sh");
    shell.current_dir(directory.path());
    // The system refuses to write more, as where a disk is full.
    shell.args(["-c", "ulimit -f 64; exec \"$0\" \"$@\""]);
    shell.arg(own.get_program()).args(words.split(' '));
    let output = shell.output().expect("it runs");
    assert_eq!(status(&output), 2, "{}", stderr(&output));
    assert!(stdout(&output).contains("good.main"), "the runs are told");
    assert!(stderr(&output).contains("cannot write `log`"), "{}", stderr(&output));
    // What was written stays.
    assert_eq!(names(directory.path()), ["bad", "good", "log"]);
    assert!(directory.read("log").len() > 30_000);
}

/// The violation of a run of both components, of which one does something; the other one goes on.
fn lost(body: &str, clock: &str) -> String {
    let directory = with_body(body);
    let mut arguments = vec!["run", "bad/bad.gen", "good/good.gen", "--bounds", "none"];
    arguments.extend(["--until", "500ms", "--format", "json", "--clock", clock]);
    arguments.extend(["--socket", "s"].iter().filter(|_| clock == "real"));
    let report = json_of(&directory.run(&arguments));
    none_is_left(&directory);
    let lost = violation(&report, "lost");
    assert_eq!(lost["component"], "bad", "{body}");
    let jobs = report["tasks"].as_array().expect("a list").iter();
    let mut good = jobs.filter(|job| job["task"] == "good.main");
    let good = good.next().and_then(|job| job["jobs"].as_u64());
    assert!(good > Some(5), "{report:#}");
    lost["why"].as_str().expect("it is text").to_owned()
}

#[test]
fn what_codels_do_to_their_process_ends_their_component_alone() {
    if !compilers() {
        return;
    }
    let close = "for (int it = 3; it < 1000; it++) close(it);";
    let nonsense =
        "for (int it = 3; it < 1000; it++) if (write(it, \"\\377\\377\\377\\377?\", 5)) {}";
    let for_ever = "for (;;) pause();";
    for (body, why) in [
        ("exit(7);".to_owned(), "exit status 7"),
        ("_exit(0);".to_owned(), "exit status 0"),
        ("*(volatile int *)8 = 1;".to_owned(), "SIGSEGV"),
        ("raise(11);".to_owned(), "SIGSEGV"),
        ("raise(7);".to_owned(), "SIGBUS"),
        ("volatile char all[1 << 28]; all[0] = 1; all[1 << 27] = 1;".to_owned(), "SIG"),
        ("kill(getpid(), 9);".to_owned(), "SIGKILL"),
        // It may come to its own end, or be ended.
        (close.to_owned(), "ended"),
        (close.to_owned() + for_ever, "ended"),
        (nonsense.to_owned() + for_ever, "written into it"),
        ("if (fork() == 0) for (;;) pause(); abort();".to_owned(), "SIGABRT"),
    ] {
        let body = format!("extern int kill(int, int), raise(int); {body}");
        let said = lost(&body, "virtual");
        assert!(said.contains(why), "{body}: {said}");
    }
    let said = lost(&(close.to_owned() + for_ever), "real");
    assert!(said.contains("ended"), "{said}");
}

#[test]
fn processes_that_codels_leave_behind_end_with_the_run() {
    if !compilers() {
        return;
    }
    let body = "extern int mkdir(const char *, unsigned);
        mkdir(\"forked\", 0700);
        if (fork() == 0) {
          setsid();
          for (int it = 0; it < 1000; it++) close(it);
          if (fork() == 0) for (;;) pause();
          _exit(0);
        }";
    let directory = with_body(body);
    for clock in ["virtual", "real"] {
        let mut arguments = vec!["run", "bad/bad.gen", "--bounds", "none"];
        arguments.extend(["--until", "500ms", "--clock", clock]);
        arguments.extend(["--socket", "s"].iter().filter(|_| clock == "real"));
        let output = directory.run(&arguments);
        assert!(!stderr(&output).contains("cannot be ended"));
        std::fs::remove_dir(directory.path().join("forked")).expect("it was there");
        none_is_left(&directory);
    }
}

#[test]
fn what_is_no_child_of_a_codel_is_left_alone() {
    if !compilers() {
        return;
    }
    // The shell becomes the run, and the job that it had started loses its parent meanwhile.
    let directory = with_body("");
    let dotgen = env!("CARGO_BIN_EXE_dotgen");
    let script = format!(
        "(until [ -S s ]; do sleep 0.01; done; sleep 60 & echo $! > job) & \
         exec {dotgen} run bad/bad.gen --clock real --socket s --until 1s --bounds none"
    );
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).current_dir(directory.path());
    shell.stdout(Stdio::null()).stderr(Stdio::null());
    // On a busy machine periods are missed.
    let ended = shell.status().expect("a shell").code();
    assert!(matches!(ended, Some(0 | 1)), "{ended:?}");
    let job: u32 = directory.read("job").trim().parse().expect("a number");
    assert!(Path::new(&format!("/proc/{job}/exe")).exists(), "it goes on");
    signal("-KILL", job);
}

#[test]
fn a_host_that_is_stopped_does_not_keep_a_run_from_ending() {
    if !compilers() {
        return;
    }
    let directory = slow();
    let mut run = Listening::start(&directory, &[SLOW, &["report"]].concat());
    let host = soon("a host", || hosts(&directory).first().copied());
    signal("-STOP", host);
    // More than a pipe takes, and from each client no more than it may ask at a time.
    let mut clients = Vec::new();
    for _ in 0..12 {
        let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
        for id in 0..250 {
            let ask =
                format!("{{\"id\": {id}, \"call\": \"slow.work\", \"input\": {{\"how\": 1}}}}\n");
            client.write_all(ask.as_bytes()).expect("it reads");
        }
        clients.push(client);
    }
    run.signal("-TERM");
    assert!(matches!(ended(&mut run.0).code(), Some(1 | 3)));
    none_is_left(&directory);
    assert!(!directory.path().join("s").exists());
}

#[test]
fn an_engine_that_is_killed_leaves_no_host() {
    if !compilers() {
        return;
    }
    let directory = with_body("");
    let arguments = ["run", "bad/bad.gen", "good/good.gen", "--clock", "real", "--socket", "s"];
    let mut run = Listening::start(&directory, &arguments);
    soon("both hosts", || (hosts(&directory).len() == 2).then_some(()));
    run.signal("-KILL");
    ended(&mut run.0);
    none_is_left(&directory);
    // Its socket is in nobody's way.
    let mut run = Listening::start(&directory, &arguments);
    run.signal("-TERM");
    ended(&mut run.0);
    assert_eq!(names(directory.path()), ["bad", "good"]);
}

#[test]
fn what_is_no_event_is_told_to_who_has_asked() {
    if !compilers() {
        return;
    }
    for lang in ["c", "c++"] {
        let source = match lang {
            "c" => {
                "#include \"acodd.h\"
#include \"odd_c_types.h\"
genom_event odd_work(const genom_context self) { return NULL; }
"
            }
            _ => {
                "#include \"acodd.h\"
#include \"odd_cxx_types.h\"
genom::event odd_work(void) { return NULL; }
"
            }
        };
        let extension = if lang == "c" { "c" } else { "cc" };
        let directory = Directory::new(&[
            (
                "odd/odd.gen",
                &format!(
                    "component odd {{ version \"1\"; lang \"{lang}\"; task main {{ period 10 ms; }};
                       activity work() {{ task main; codel<start> odd_work() yield ether wcet 1 ms; }}; }};\n"
                ),
            ),
            (&format!("odd/codels/odd.{extension}"), source),
        ]);
        let arguments = ["run", "odd/odd.gen", "--clock", "real", "--socket", "s"];
        let mut run = Listening::start(&directory, &arguments);
        let called = directory.run(&["call", "--socket", "s", "odd", "work"]);
        assert_eq!(status(&called), 1);
        let said = stderr(&called);
        assert!(said.contains("::genom::bad_transition"), "{lang}: {said}");
        run.signal("-TERM");
        assert_eq!(ended(&mut run.0).code(), Some(1));
    }
}

#[test]
fn a_client_that_does_not_read_or_says_too_much_is_let_go() {
    let directory = with_body("");
    let arguments = [REAL, &["--simulate", "all"]].concat();
    let run = Listening::start(&directory, &arguments);
    let socket = directory.path().join("s");
    // A line without an end is refused before it ends. (The timeout: a test that fails is better than one
    // that waits.)
    let mut client = UnixStream::connect(&socket).expect("it listens");
    let timeout = Some(Duration::from_mins(1));
    client.set_read_timeout(timeout).expect("a timeout");
    client.write_all(&vec![b'x'; 17 << 20]).expect("it is skipped");
    let mut said = String::new();
    BufReader::new(&client).read_line(&mut said).expect("in time");
    assert!(said.contains("too long"), "{said}");
    // Answers that nobody reads.
    let mut client = UnixStream::connect(&socket).expect("it listens");
    client.set_write_timeout(timeout).expect("a timeout");
    let gone = loop {
        match client.write_all(b"{\"id\": 1, \"describe\": null}\n") {
            Ok(()) => {}
            Err(error) => break error.kind(),
        }
    };
    assert_ne!(gone, std::io::ErrorKind::WouldBlock, "it is let go in time");
    let other = directory.run(&["call", "--socket", "s", "good", "none"]);
    assert!(stderr(&other).contains("no service"), "{}", stderr(&other));
    drop(run);
}

#[test]
fn what_stands_where_a_socket_should_be_stays() {
    let directory = with_body("");
    directory.write("s", b"mine");
    directory.write("elsewhere", b"mine");
    std::os::unix::fs::symlink("elsewhere", directory.path().join("link")).expect("a link");
    for (socket, said) in [
        ("s", "cannot listen"),
        ("link", "cannot listen"),
        ("bad/none/there/s", "bad/none"),
        (&"x".repeat(200), "cannot listen"),
    ] {
        let arguments =
            ["run", "good/good.gen", "--clock", "real", "--simulate", "all", "--socket"];
        let output = directory.run(&[&arguments[..], &[socket]].concat());
        assert_eq!(status(&output), 2, "{socket}: {}", stderr(&output));
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    }
    assert_eq!(directory.read("s"), "mine");
    assert_eq!(directory.read("elsewhere"), "mine");
}
