//! What the public template of ROS servers writes without an installation of GenoM3 compiles.
//!
//! The template is not part of this repository, and ROS 1 is not everywhere: without them the test is
//! skipped.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::codels::headers::RUNTIME;
use dotgen_codegen::command::{Environment, Ros2Packages, generate};
use dotgen_codegen::template::console::CapturedConsole;
use dotgen_codegen::template::{Limits, OutputSink, find_tclsh};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs::Vfs;
use dotgen_platform::process;

const SPECIFICATION: &str = "component lamp {
  version \"1.0\"; lang \"c\"; email \"a@example.org\"; require \"genom3 >= 2.99.26\";
  exception e_broken { long why; }, e_dark;
  enum colour { RED, GREEN };
  struct light { colour which; double power; };
  ids { light set; };
  port in light other;
  port out light all;
  task blink {
    period 5 ms;
    codel<start> lampStart(ids out set, port in other, port out all) yield loop;
    codel<loop> lampLoop(ids inout set) yield pause::loop;
    throw e_broken, e_dark;
  };
  attribute power(inout set.power);
  function reset(in long bright = 1, out double said) {
    codel lampReset(in bright, out said); throw e_broken;
  };
  activity shine(in light to) {
    task blink;
    codel<start> lampShine(in to, port out all) yield more;
    codel<more> lampMore(inout ::set) yield pause::more, ether;
    throw e_broken;
    interrupts shine;
  };
};
";

/// Copies a folder; files of formal models are empty in the copy.
fn copy(from: &Path, to: &Path) {
    for entry in
        walkdir::WalkDir::new(from).into_iter().map(|directory| directory.expect("a folder"))
    {
        let to = to.join(entry.path().strip_prefix(from).expect("below"));
        if entry.file_type().is_dir() {
            std::fs::create_dir_all(to).expect("a folder");
        } else if entry.file_name().to_string_lossy().starts_with("BIPGenoM3") {
            std::fs::write(to, "").expect("a file");
        } else {
            std::fs::copy(entry.path(), to).expect("a copy");
        }
    }
}

/// The files with an extension.
fn sources(out: &Path, extension: &str) -> Vec<PathBuf> {
    let all = walkdir::WalkDir::new(out)
        .into_iter()
        .map(|directory| directory.expect("a folder").into_path());
    let of_kind = |path: &PathBuf| path.extension().is_some_and(|name| name == extension);
    all.filter(of_kind).collect()
}

/// Writes the digests of the messages of all services and actions.
fn write_digests(out: &Path) {
    let mut messages = [sources(out, "msg"), sources(out, "srv")].concat();
    for action in sources(out, "action") {
        let name = action.file_stem().expect("a name").to_string_lossy().into_owned();
        for part in
            ["Action", "ActionFeedback", "ActionGoal", "ActionResult", "Feedback", "Goal", "Result"]
        {
            messages.push(out.join(format!("lamp/msg/{name}{part}.msg")));
        }
    }
    for message in messages {
        let name = message.file_stem().expect("a name").to_string_lossy();
        let digest = format!("#define genom_md5_{name} \"0123456789abcdef0123456789abcdef\"\n");
        std::fs::write(format!("{}.md5", message.display()), digest).expect("a file");
    }
}

#[test]
fn a_ros_server_compiles_without_genom() {
    let folder = std::env::var_os("DOTGEN_TEST_ROS_TEMPLATES").map(PathBuf::from);
    let ros = Path::new("/usr/include/ros/ros.h").is_file()
        && Path::new("/usr/include/actionlib/server/action_server.h").is_file();
    let (Some(folder), true, Ok(_)) = (folder, ros, find_tclsh()) else {
        dotgen_loaders::skip(
            "no data: this needs DOTGEN_TEST_ROS_TEMPLATES, the folder with server-ros and common-ros, tclsh, and \
             ROS 1 (libroscpp-dev and libactionlib-dev on Debian)",
        );
        return;
    };
    let place = tempfile::tempdir().expect("a folder");
    let templates = place.path().join("templates");
    copy(&folder, &templates);
    std::fs::write(place.path().join("lamp.gen"), SPECIFICATION).expect("a file");
    let mut console = CapturedConsole::default();
    let cache = place.path().join("cache").display().to_string();
    let mut environment = Environment {
        name: "genom3",
        program: "/bin/genom3".into(),
        variables: &|name| (name == "XDG_CACHE_HOME").then(|| cache.clone()),
        disk: Arc::new(SystemDisk),
        loader: Arc::<Vfs>::default(),
        pictures: Arc::new(|_, _, _, _| Ok(String::new())),
        ros2: Arc::new(|_| Ok(Ros2Packages::default())),
        console: &mut console,
        limits: Limits::default(),
        base: place.path().to_owned(),
        sink: OutputSink::DIRECT,
        processes: process::system(),
        confined: None,
        failed_at: None,
        project_templates: None,
        release: Some(ReleaseChoice {
            release: Release::V2_99_39,
            origin: ReleaseOrigin::Environment,
        }),
    };
    let templates = templates.display().to_string();
    let words = ["-t", &templates, "server-ros", "-C", "out", "lamp.gen"];
    let status = generate(&words.map(str::to_owned), &mut environment);
    assert_eq!((status, console.err.as_str()), (0, ""));
    let out = place.path().join("out");
    for (path, text) in RUNTIME {
        let path = out.join("include").join(path);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
    // What configure and the build make: no tool of theirs is under test.
    std::fs::write(
        out.join("autoconf/acheader.h"),
        "#define PACKAGE_NAME \"lamp\"\n#define PACKAGE_VERSION \"1.0\"\n",
    )
    .expect("a file");
    write_digests(&out);
    let sources = sources(&out, "cc");
    assert!(sources.len() >= 8, "{sources:?}");
    let compiled = Command::new("c++")
        .current_dir(&out)
        .args(["-std=gnu++14", "-fsyntax-only", "-w", "-I.", "-Isrc", "-Iinclude"])
        // Boost has moved the names of placeholders since the template was written.
        .arg("-DBOOST_BIND_GLOBAL_PLACEHOLDERS")
        .args(["-include", "boost/bind.hpp"])
        .args(sources)
        .output()
        .expect("a compiler");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
}
