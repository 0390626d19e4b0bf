//! Templates without Tcl: those of dotgen, and a folder of the user's.

use std::path::Path;
use std::sync::Arc;

use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::command::{Environment, Ros2Packages, generate};
use dotgen_codegen::template::Limits;
use dotgen_codegen::template::console::CapturedConsole;
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs::Vfs;
use dotgen_platform::process;

const SPECIFICATION: &str = "/*/ A lamp. */
component lamp {
  version \"1.2\"; lang \"c\"; doc \"Gives light.\"; requires \"genom3 >= 2.99.26\";
  ids { boolean on; };
  task blink { period 10 ms; codel<start> lampStart(out on) yield ether; };
  function reset(in long level) { codel lampReset(out on); };
};
";

/// Runs the generator in a folder; returns the status and what was printed.
fn run(dir: &Path, args: &[&str]) -> (i32, String, String) {
    // What most tests expect is of this release.
    run_as(Release::V2_99_39, dir, args)
}

fn run_as(release: Release, dir: &Path, args: &[&str]) -> (i32, String, String) {
    run_in(release, dir, None, args)
}

/// Runs with template directories from the settings of a folder.
fn run_in(
    release: Release,
    dir: &Path,
    project: Option<&str>,
    args: &[&str],
) -> (i32, String, String) {
    let mut console = CapturedConsole::default();
    let mut environment = Environment {
        name: "dotgen generate",
        program: "/bin/dotgen".into(),
        variables: &|name| {
            (name == "XDG_CACHE_HOME").then(|| dir.join("cache").display().to_string())
        },
        disk: Arc::new(SystemDisk),
        loader: Arc::<Vfs>::default(),
        ros2: Arc::new(|_| Ok(Ros2Packages::default())),
        pictures: Arc::new(|_, component, owner, form| {
            // What has no machine has no picture.
            let text = format!("{form} of {component}.{owner}");
            Ok(if owner == "reset" { String::new() } else { text })
        }),
        console: &mut console,
        limits: Limits::default(),
        base: std::path::PathBuf::new(),
        sink: dotgen_codegen::template::OutputSink::DIRECT,
        processes: process::system(),
        confined: None,
        failed_at: None,
        project_templates: project.map(|paths| dir.join(paths).display().to_string()),
        release: Some(ReleaseChoice { release, origin: ReleaseOrigin::CommandLine }),
    };
    let dir = dir.display().to_string();
    let args: Vec<String> = args.iter().map(|argument| argument.replace("DIR", &dir)).collect();
    let status = generate(&args, &mut environment);
    let out = String::from_utf8(console.out).unwrap();
    (status, out.replace(&dir, "DIR"), console.err.replace(&dir, "DIR"))
}

fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("lamp.gen"), SPECIFICATION).unwrap();
    dir
}

#[test]
fn the_skeleton_has_the_files_of_the_reference() {
    let dir = folder();
    let (status, out, err) = run(dir.path(), &["skeleton", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let mut files: Vec<&str> = out.lines().collect();
    files.sort_unstable();
    assert_eq!(
        files,
        [
            "creating DIR/Makefile.am",
            "creating DIR/README.adoc",
            "creating DIR/autoconf/ag_templates.m4",
            "creating DIR/bootstrap.sh",
            "creating DIR/codels/Makefile.am",
            "creating DIR/codels/lamp_blink_codels.c",
            "creating DIR/codels/lamp_codels.c",
            "creating DIR/configure.ac",
            "creating DIR/lamp-genom3-uninstalled.pc.in",
            "creating DIR/lamp-genom3.pc.in",
        ]
    );
    let codels = std::fs::read_to_string(dir.path().join("codels/lamp_codels.c")).unwrap();
    assert!(codels.contains("genom_event\nlampReset(bool *on, const genom_context self)\n"));
    // What the user writes stays, and is asked about.
    std::fs::write(dir.path().join("configure.ac"), "mine\n").unwrap();
    let (status, _, err) = run(dir.path(), &["skeleton", "DIR/lamp.gen"]);
    assert_eq!(status, 2);
    assert!(err.starts_with("skeleton: stop: file DIR/configure.ac exists"), "{err}");
}

/// The build files of a release, and of a specification that requires these packages: `configure.ac` and the
/// two files for pkg-config.
fn build_files(release: Release, required: &str) -> [String; 3] {
    let dir = folder();
    let text = SPECIFICATION.replace("requires \"genom3 >= 2.99.26\";", required);
    std::fs::write(dir.path().join("lamp.gen"), text).unwrap();
    let (status, _, err) = run_as(release, dir.path(), &["skeleton", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    ["configure.ac", "lamp-genom3.pc.in", "lamp-genom3-uninstalled.pc.in"]
        .map(|name| std::fs::read_to_string(dir.path().join(name)).unwrap())
}

/// The lines of `configure.ac` about packages.
fn packages_of(configure: &str) -> &str {
    let from = configure.find("# What the component").unwrap();
    configure[from..].split("\n\nAG_TEMPLATES").next().unwrap()
}

#[test]
fn build_files_have_packages_in_variables_since_2_99_44() {
    for release in [Release::V2_99_44, Release::V3] {
        let required = "requires \"openrobots2-idl >= 2.0\", \"genom3 >= 2.99.41\";";
        let [configure, package, uninstalled] = build_files(release, required);
        insta::assert_snapshot!("configure_with_variables", configure);
        let both = "Requires: @requires_SPEC@\n";
        assert!(package.contains(both) && uninstalled.contains(both));
        let required = &format!("{required} codels-requires \"eigen3\", \"urdfdom >= 1.0\";");
        let [configure, package, uninstalled] = build_files(release, required);
        insta::assert_snapshot!("configure_with_variables_of_codels", packages_of(&configure));
        let both = "Libs.private: @codels_requires_LIBS@\n";
        assert!(package.contains(both) && uninstalled.contains(both));
    }
}

#[test]
fn build_files_of_older_releases_name_packages_in_place() {
    let required = "requires \"openrobots2-idl >= 2.0\"; codels-requires \"eigen3\";";
    let [configure, package, uninstalled] = build_files(Release::V2_99_43, required);
    insta::assert_snapshot!("configure_with_packages", packages_of(&configure));
    let both = "Requires: openrobots2-idl >= 2.0\n";
    assert!(package.contains(both) && uninstalled.contains(both), "{package}{uninstalled}");
    let [configure, package, _] = build_files(Release::V2_99_43, "");
    assert!(!configure.contains("codels_requires"), "{configure}");
    assert!(!package.contains("require"), "{package}");
}

#[test]
fn mappings_are_printed() {
    let dir = folder();
    let (status, out, err) = run(dir.path(), &["mappings", "--signature", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert!(out.starts_with("#include") || out.starts_with("/* Generated by genom"));
    assert!(out.contains("#line 6 \"DIR/lamp.gen\"\ngenom_event lampReset("));
    let (status, _, err) = run(dir.path(), &["mappings", "-l", "pascal", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (2, "mappings: unsupported language pascal\n"));
}

#[test]
fn a_folder_of_the_user_is_a_template() {
    let dir = folder();
    let own = dir.path().join("templates/names");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(
        own.join("template.toml"),
        "about = \"names\"\n[[files]]\neach = \"component\"\npath = \"{{ component.name }}.txt\"\nsource = \"names.jinja\"\n",
    )
    .unwrap();
    std::fs::write(
        own.join("names.jinja"),
        "{% for it in component.services %}\n{{ it.name }}\n{% endfor %}\n",
    )
    .unwrap();
    let (status, out, _) = run(dir.path(), &["-t", "DIR/templates", "-l"]);
    assert_eq!(
        (status, out.as_str()),
        (
            0,
            "docs\ndocs-asciidoc\njson-schema\nmappings\nnames\npython\nros2-interfaces\nskeleton\nstubs\n"
        )
    );
    let args = ["-t", "DIR/templates", "names", "-C", "DIR/out", "DIR/lamp.gen"];
    let (status, out, err) = run(dir.path(), &args);
    assert_eq!((status, err.as_str()), (0, ""));
    assert_eq!(out, "creating DIR/out/lamp.txt\n");
    let text = std::fs::read_to_string(dir.path().join("out/lamp.txt")).unwrap();
    assert_eq!(text, "reset\n");
    // An error names the text and the line.
    std::fs::write(own.join("names.jinja"), "a\n{{ component.name | nothing }}\n").unwrap();
    let (status, _, err) = run(dir.path(), &args);
    assert_eq!(status, 2);
    assert!(err.starts_with("names: names.jinja:2: unknown filter"), "{err}");
}

#[test]
fn errors_in_the_specification_are_reported() {
    let dir = folder();
    std::fs::write(dir.path().join("bad.gen"), "struct s { nothing x; };\n").unwrap();
    let (status, out, err) = run(dir.path(), &["docs", "DIR/bad.gen"]);
    assert_eq!((status, out.as_str()), (2, ""));
    assert_eq!(err, "bad.gen:1: unknown type nothing\ndocs: 1 error\n");
    // GenoM3 assumes a missing semicolon and reads on; after another token it stops.
    for (text, end) in [
        ("const long a = 1\nconst long b = 2;\n", "docs: 1 error\n"),
        ("const long a = ;\n", "docs: fatal errors\n"),
        ("#include\n", "docs: fatal errors\n"),
    ] {
        std::fs::write(dir.path().join("bad.gen"), text).unwrap();
        let (_, _, err) = run(dir.path(), &["docs", "DIR/bad.gen"]);
        assert!(err.ends_with(end), "{err}");
    }
    let (status, _, err) = run(dir.path(), &["docs", "DIR/none.gen"]);
    assert_eq!(status, 2);
    assert!(err.contains("DIR/none.gen: No such file or directory"), "{err}");
    let (status, _, err) = run(dir.path(), &["-n", "DIR/bad.gen"]);
    assert_eq!((status, err.lines().count()), (1, 2));
}

#[test]
fn a_semicolon_in_what_is_reported_does_not_cut_the_line() {
    let dir = folder();
    let text = "component c {\n  codels-require \"a; b\", \"a; b\";\n};\n";
    std::fs::write(dir.path().join("twice.gen"), text).unwrap();
    let (_, _, err) = run(dir.path(), &["-n", "DIR/twice.gen"]);
    assert!(
        err.starts_with("twice.gen:2: warning: \"a; b\" is already in this codels-requires list\n"),
        "{err}"
    );
}

#[test]
fn preprocessing_expands_macros_and_includes() {
    let dir = folder();
    std::fs::write(dir.path().join("part.idl"), "#define N 4 /* four */\n").unwrap();
    std::fs::write(
        dir.path().join("all.gen"),
        "#include \"part.idl\"\ntypedef long a[N];\n#if N > 9\nno\n#endif\n#pragma provides x\n",
    )
    .unwrap();
    let (status, out, err) = run(dir.path(), &["-E", "DIR/all.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert!(out.contains("# 1 \"DIR/part.idl\"\n"), "{out}");
    assert!(out.contains("typedef long a[") && out.contains("4];"), "{out}");
    assert!(!out.contains("no\n") && !out.contains("define"), "{out}");
    assert!(out.contains("#pragma provides x"), "{out}");
    std::fs::write(dir.path().join("bad.gen"), "#include \"none\"\n").unwrap();
    let (status, _, err) = run(dir.path(), &["-E", "DIR/bad.gen"]);
    assert_eq!(status, 1);
    assert!(err.starts_with("DIR/bad.gen:1: error: "), "{err}");
}

#[test]
fn stubs_are_the_codels_alone() {
    let dir = folder();
    let (status, out, err) = run(dir.path(), &["stubs", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert_eq!(out, "creating DIR/codels/lamp_blink_codels.c\ncreating DIR/codels/lamp_codels.c\n");
}

#[test]
fn documentation_has_the_state_machines() {
    let dir = folder();
    let (status, _, err) = run(dir.path(), &["docs", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let text = std::fs::read_to_string(dir.path().join("lamp.md")).unwrap();
    insta::assert_snapshot!("docs", text);
    let (status, out, err) = run(dir.path(), &["docs-asciidoc", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert_eq!(out, "creating DIR/lamp.adoc\ncreating DIR/lamp-blink.svg\n");
    let text = std::fs::read_to_string(dir.path().join("lamp.adoc")).unwrap();
    insta::assert_snapshot!("docs-asciidoc", text);
    let picture = std::fs::read_to_string(dir.path().join("lamp-blink.svg")).unwrap();
    assert!(picture.contains("svg of lamp.blink"), "{picture}");
}

const DATA: &str = "module m {
  enum colour { red, green };
  union value switch (colour) { case red: double d; case green: string<6> s; };
  struct all { boolean b; octet o; char c; long long ll; float f; colour col; value v;
               long grid[2][2]; optional<sequence<unsigned short, 3> > few; };
  exception e_bad { short code; };
};
component c {
  version \"1\"; lang \"c\";
  port out m::all state { doc \"All of it.\"; };
  port in m::all wanted;
  function f(in m::all x, in long y = 3 : \"How many\", out m::value z) {
    codel g(in x, in y, out z); throw m::e_bad;
  };
};
";

#[test]
fn the_schema_describes_requests_and_ports() {
    let dir = folder();
    std::fs::write(dir.path().join("data.gen"), DATA).unwrap();
    let (status, _, err) = run(dir.path(), &["json-schema", "DIR/data.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let text = std::fs::read_to_string(dir.path().join("c.schema.json")).unwrap();
    insta::assert_snapshot!("schema", text);
}

#[test]
fn python_knows_the_types_of_services_and_ports() {
    let dir = folder();
    std::fs::write(dir.path().join("data.gen"), DATA).unwrap();
    let (status, _, err) = run(dir.path(), &["python", "DIR/data.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let text = std::fs::read_to_string(dir.path().join("c.pyi")).unwrap();
    insta::assert_snapshot!("python", text);
}

/// The support file is written for the templates of others: what it gives compiles, and reads what it
/// prints.
#[test]
fn json_support_reads_what_it_prints() {
    if let Err(reason) = dotgen_codegen::template::find_tclsh() {
        dotgen_loaders::skip(format_args!("{reason}"));
        return;
    }
    let cc = std::process::Command::new("cc").arg("--version").output();
    if cc.is_err() {
        dotgen_loaders::skip("there is no C compiler `cc`");
        return;
    }
    let dir = folder();
    let own = dir.path().join("templates/json");
    std::fs::create_dir_all(&own).unwrap();
    let script = "dotgen parse file {*}$argv
engine chdir [file dirname [lindex $argv 0]]
template parse string {<\"[language mapping [dotgen types *m::*] false]\">} file types.h
template parse args [list [[dotgen types *m::all] types]] \\
  file [file join [dotgen template builtindir] common/json-types.h] file json.h
";
    std::fs::write(own.join("template.tcl"), script).unwrap();
    // What needs headers of GenoM3 is left out.
    let types = DATA.replace("optional<sequence<unsigned short, 3> > few;", "");
    let types = types.split("  exception").next().unwrap().to_owned() + "};\n";
    std::fs::write(dir.path().join("data.gen"), types).unwrap();
    let (status, _, err) = run(dir.path(), &["-t", "DIR/templates", "json", "DIR/data.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let program = r#"
#include "types.h"
#include "json.h"
int main(int argc, char **argv)
{
  m_all data;
  const char *json = argv[argc - 1];
  char *text = NULL, *end = NULL;
  size_t size = 0;
  memset(&data, 0, sizeof(data));
  if (json_scan_t_m_all(&data, &json) || *json) return 1;
  if (json_print_t_m_all(&text, &end, &size, &data)) return 2;
  fputs(text, stdout);
  return 0;
}
"#;
    std::fs::write(dir.path().join("main.c"), program).unwrap();
    let compiled = std::process::Command::new("cc")
        .current_dir(dir.path())
        .args(["-std=gnu99", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main", "-lm"])
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let print = |json: &str| {
        let done = std::process::Command::new(dir.path().join("main")).arg(json).output().unwrap();
        (done.status.code(), String::from_utf8(done.stdout).unwrap())
    };
    let whole = r#"{"b":true,"o":200,"c":"\"","ll":-9223372036854775808,"f":1.5,"col":"::m::green","v":{"d":"::m::green","u":{"s":"a\u0001"}},"grid":[[1,2],[3,4]]}"#;
    assert_eq!(print(whole), (Some(0), whole.to_owned()));
    // Blanks, short names, elements by index, and missing members are read too.
    let (status, text) = print(r#" { "col" : "green" , "grid" : { "1" : [ 7 ] }, "f": null }"#);
    assert_eq!(status, Some(0));
    assert!(
        text.contains(r#""f":null,"col":"::m::green""#) && text.contains("[[0,0],[7,0]]"),
        "{text}"
    );
    for bad in [
        "",
        "{",
        r#"{"nothing":1}"#,
        r#"{"grid":[[1,2,3]]}"#,
        r#"{"v":{"d":"green","u":{"s":"toolong"}}}"#,
    ] {
        assert_eq!(print(bad).0, Some(1), "{bad}");
    }
}

#[test]
fn templates_of_a_clone_do_not_replace_those_of_dotgen() {
    let dir = folder();
    let own = dir.path().join("templates/docs");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join("template.tcl"), "puts owned\n").unwrap();
    let other = dir.path().join("templates/other");
    std::fs::create_dir_all(&other).unwrap();
    std::fs::write(
        other.join("template.toml"),
        "about = \"x\"\n[[files]]\npath = \"a\"\nsource = \"t\"\n",
    )
    .unwrap();
    std::fs::write(other.join("t"), "x").unwrap();
    let project = |args: &[&str]| run_in(Release::V2_99_39, dir.path(), Some("templates"), args);
    let (status, out, err) = project(&["docs", "-C", "DIR/out", "DIR/lamp.gen"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert_eq!(out, "creating DIR/out/lamp.md\n");
    // Other templates of the folder are confined to the current directory.
    let (status, _, err) = project(&["other", "-C", "DIR/out", "DIR/lamp.gen"]);
    assert_eq!(status, 2);
    assert!(err.contains("DIR/out/a is outside of"), "{err}");
    // A directory of the command line is the user's.
    let args = ["-t", "DIR/templates", "other", "-C", "DIR/out", "DIR/lamp.gen"];
    let (status, _, err) = project(&args);
    assert_eq!((status, err.as_str()), (0, ""));
}

#[cfg(unix)]
#[test]
fn templates_without_tcl_write_nothing_that_acts_later() {
    let dir = folder();
    let template = |name: &str, file: &str| {
        let own = dir.path().join("templates").join(name);
        std::fs::create_dir_all(&own).unwrap();
        let manifest = format!("about = \"x\"\n[[files]]\n{file}\nsource = \"t\"\n");
        std::fs::write(own.join("template.toml"), manifest).unwrap();
        std::fs::write(own.join("t"), "x").unwrap();
    };
    template("hook", "path = \".git/hooks/post-commit\"\npermissions = \"a+x\"");
    template("tasks", "path = \"sub/.vscode/tasks.json\"");
    template("script", "path = \"run.sh\"\npermissions = \"a+x\"");
    template("plain", "path = \".clang-format\"");
    let victim = dir.path().join("victim");
    std::fs::create_dir(&victim).unwrap();
    std::fs::create_dir(dir.path().join("out")).unwrap();
    std::os::unix::fs::symlink("../victim", dir.path().join("out/codels")).unwrap();
    let run = |more: &[&str], name: &str| {
        let args = [&["-t", "DIR/templates"], more, &[name, "-C", "DIR/out", "DIR/lamp.gen"]];
        run(dir.path(), &args.concat())
    };
    for (name, file, why) in [
        ("hook", ".git/hooks/post-commit", "in a folder that controls tools"),
        ("tasks", "sub/.vscode/tasks.json", "in a folder that controls tools"),
        ("script", "run.sh", "executable"),
    ] {
        let (status, _, err) = run(&[], name);
        assert_eq!(status, 2, "{name}");
        assert!(err.contains(&format!("DIR/out/{file} is {why}, and a template")), "{err}");
        assert!(!dir.path().join("out").join(file).exists());
        let (status, _, err) = run(&["--allow", &format!("DIR/out/{file}")], name);
        assert_eq!((status, err.as_str()), (0, ""));
        assert!(dir.path().join("out").join(file).exists());
    }
    let (status, _, err) = run(&[], "plain");
    assert_eq!((status, err.as_str()), (0, ""));
    let (status, _, err) = run(&[], "skeleton");
    assert_eq!(status, 2);
    assert!(err.contains("the link DIR/out/codels leads out of DIR/out"), "{err}");
    assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 0);
}
