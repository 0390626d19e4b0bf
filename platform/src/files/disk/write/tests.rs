use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;

/// A folder with two files and a link to the second, and the new content: of both, and of a new file in a new
/// folder.
struct Fixture {
    directory: tempfile::TempDir,
    files: Vec<NewContent>,
}

const BEFORE: [(&str, &str); 2] = [("a.c", "old a\n"), ("b.c", "old b\n")];

fn fixture() -> Fixture {
    let directory = tempfile::tempdir().unwrap();
    for (name, text) in BEFORE {
        std::fs::write(directory.path().join(name), text).unwrap();
    }
    let new = |name: &str| {
        NewContent::new(directory.path().join(name), format!("new {name}\n").into_bytes())
    };
    let files = vec![new("a.c"), new("b.c"), new("sub/c.c")];
    Fixture { directory, files }
}

/// Every file below a folder with its content, and the number of leftovers.
fn contents(directory: &Path) -> (BTreeMap<String, String>, usize) {
    let mut leftovers = 0;
    let mut files = BTreeMap::new();
    for entry in walkdir::WalkDir::new(directory).into_iter().flatten() {
        let name = entry.path().strip_prefix(directory).unwrap().display().to_string();
        if entry.file_type().is_file() {
            if name.ends_with(SUFFIX) {
                leftovers += 1;
            } else {
                drop(files.insert(name, std::fs::read_to_string(entry.path()).unwrap()));
            }
        }
    }
    (files, leftovers)
}

fn map(files: &[(&str, &str)]) -> BTreeMap<String, String> {
    files.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect()
}

/// The last group of moves.
#[derive(Default)]
struct Kept(Vec<Move>);

impl Finisher for Kept {
    fn register_moves(&mut self, moves: Vec<Move>) {
        self.0 = moves;
    }
}

fn written(files: &[NewContent], hook: Hook<'_>) -> Result<(), WriteError> {
    write(files, &mut Kept::default(), hook)
}

/// The steps of writing a fixture.
fn steps(fixture: &Fixture) -> Vec<Step> {
    let mut all = Vec::new();
    let done = written(&fixture.files, &mut |step| {
        all.push(step);
        Ok(())
    });
    done.unwrap();
    all
}

#[test]
fn all_files_are_written_and_nothing_else_stays() {
    let fixture = fixture();
    let all = steps(&fixture);
    assert_eq!(all.iter().filter(|step| **step == Step::Replace).count(), 3);
    let after = map(&[("a.c", "new a.c\n"), ("b.c", "new b.c\n"), ("sub/c.c", "new sub/c.c\n")]);
    assert_eq!(contents(fixture.directory.path()), (after, 0));
}

#[test]
fn a_step_that_fails_leaves_everything_as_it_was() {
    let count = steps(&fixture()).len();
    for fails in 0..count {
        let fixture = fixture();
        let (mut at, mut failed) = (0, None);
        let done = written(&fixture.files, &mut |step| {
            at += 1;
            if at - 1 != fails {
                return Ok(());
            }
            failed = Some(step);
            Err(ErrorKind::StorageFull.into())
        });
        // By then everything is in place; a second name remains.
        if failed == Some(Step::Forget) {
            assert!(done.is_ok());
            continue;
        }
        let error = done.expect_err("it has failed").to_string();
        assert!(error.ends_with("; none of the 3 files was changed"), "{error}");
        assert_eq!(contents(fixture.directory.path()), (map(&BEFORE), 0), "{failed:?}");
        assert!(!fixture.directory.path().join("sub").exists(), "{failed:?}");
    }
}

#[test]
fn what_cannot_be_put_back_is_named() {
    let fixture = fixture();
    let mut replaced = 0;
    let done = written(&fixture.files, &mut |step| match step {
        Step::Replace if replaced == 1 => Err(ErrorKind::StorageFull.into()),
        Step::Replace => {
            replaced += 1;
            Ok(())
        }
        Step::PutBack => Err(ErrorKind::PermissionDenied.into()),
        _ => Ok(()),
    });
    let error = done.expect_err("it has failed");
    assert_eq!(error.changed.len(), 1);
    let text = error.to_string();
    assert!(text.contains("b.c`: no storage space; `"), "{text}");
    assert!(
        text.contains("a.c` was changed before and cannot be put back: what it was is in `"),
        "{text}"
    );
}

/// Simulates a kill by a panic in the hook: nothing is cleaned up, and locks are released. Returns the
/// registered moves. If `fails` is given, that step fails.
fn killed_at(fixture: &Fixture, step: usize, fails: Option<usize>) -> Vec<Move> {
    let mut at = 0;
    let mut kept = Kept::default();
    let killed = catch_unwind(AssertUnwindSafe(|| {
        write(&fixture.files, &mut kept, &mut |_| {
            at += 1;
            assert!(at - 1 != step, "killed");
            if Some(at - 1) == fails { Err(ErrorKind::StorageFull.into()) } else { Ok(()) }
        })
    }));
    assert!(killed.is_err());
    kept.0
}

/// All of them, or none.
#[test]
fn after_a_kill_at_any_step_the_helper_finishes() {
    let all = steps(&fixture());
    let after = map(&[("a.c", "new a.c\n"), ("b.c", "new b.c\n"), ("sub/c.c", "new sub/c.c\n")]);
    let replaces = |to: usize| all[..to].iter().filter(|step| **step == Step::Replace).count();
    for (step, killed) in all.iter().enumerate() {
        let fixture = fixture();
        process::carry_out(&killed_at(&fixture, step, None));
        let (files, _) = contents(fixture.directory.path());
        let expected =
            if *killed == Step::Replace || replaces(step) > 0 { &after } else { &map(&BEFORE) };
        assert_eq!(&files, expected, "{step}: {killed:?}");
    }
}

/// A failed write is undone, even if the process is killed while it undoes it.
#[test]
fn after_a_kill_while_files_are_put_back_the_helper_finishes() {
    let all = steps(&fixture());
    let last = all.iter().rposition(|step| *step == Step::Replace).unwrap();
    for step in last + 1..last + 3 {
        let fixture = fixture();
        process::carry_out(&killed_at(&fixture, step, Some(last)));
        assert_eq!(contents(fixture.directory.path()), (map(&BEFORE), 0), "{step}");
    }
}

#[test]
fn files_are_whole_after_a_kill_at_any_step_and_the_next_write_cleans_up() {
    let count = steps(&fixture()).len();
    let mut seen = 0;
    for step in 0..count {
        let fixture = fixture();
        killed_at(&fixture, step, None);
        let (files, leftovers) = contents(fixture.directory.path());
        seen += leftovers;
        for (name, old) in BEFORE {
            assert!(
                files[name] == old || files[name] == format!("new {name}\n"),
                "{step}: {files:?}"
            );
        }
        if let Some(new) = files.get("sub/c.c") {
            assert_eq!(new, "new sub/c.c\n");
        }
        cleaned_up(&fixture, step);
    }
    assert!(seen > count / 2, "kills leave something behind: {seen}");
}

/// Writes in a separate process, which is killed with SIGKILL before a step.
#[cfg(unix)]
#[test]
fn kill_9_at_any_step() {
    const STEP: &str = "DOTGEN_TEST_KILLED_AT";
    const FOLDER: &str = "DOTGEN_TEST_FOLDER";
    let bytes = |name: &str| format!("new {name}\n").repeat(10_000).into_bytes();
    if let (Ok(step), Ok(folder)) = (std::env::var(STEP), std::env::var(FOLDER)) {
        let mut left: usize = step.parse().unwrap();
        let files: Vec<NewContent> = (BEFORE.iter())
            .map(|(name, _)| NewContent::new(Path::new(&folder).join(name), bytes(name)))
            .collect();
        let _ = written(&files, &mut |_| {
            if left == 0 {
                let own = std::process::id().to_string();
                let _ = std::process::Command::new("kill").args(["-9", &own]).status();
            }
            left -= 1;
            Ok(())
        });
        return;
    }
    for step in [0, 1, 2, 3, 5, 7, 8, 9, 10, 11, 12] {
        let fixture = fixture();
        let (_, module) = module_path!().split_once("::").unwrap();
        let name = format!("{module}::kill_9_at_any_step");
        let status = std::process::Command::new(std::env::current_exe().unwrap())
            .args([&name, "--exact", "--quiet"])
            .env(STEP, step.to_string())
            .env(FOLDER, fixture.directory.path())
            .stdout(std::process::Stdio::null())
            .status();
        assert!(!status.unwrap().success(), "{step}: it is killed");
        for (name, old) in BEFORE {
            let now = std::fs::read(fixture.directory.path().join(name)).unwrap();
            assert!(now == old.as_bytes() || now == bytes(name), "{step}: {name}");
        }
        cleaned_up(&fixture, step);
    }
}

/// Checks that the next write removes leftovers. A process that another test starts holds these locks until
/// it runs its own program, so several writes may be needed.
fn cleaned_up(fixture: &Fixture, step: usize) {
    let leftovers = || contents(fixture.directory.path()).1;
    for _ in 0..200 {
        written(&fixture.files, &mut |_| Ok(())).unwrap();
        if leftovers() == 0 {
            return;
        }
    }
    panic!("{step}: {} files are left over", leftovers());
}

#[test]
fn files_of_a_writer_that_lives_are_not_cleaned_up() {
    let fixture = fixture();
    let mut inner = None;
    let done = written(&fixture.files, &mut |step| {
        if step == Step::Sync && inner.is_none() {
            // Another writer in the same folder, during this write.
            inner = Some(contents(fixture.directory.path()).1);
            written(&fixture.files[1..2], &mut |_| Ok(())).unwrap();
            assert_eq!(Some(contents(fixture.directory.path()).1), inner);
        }
        Ok(())
    });
    done.unwrap();
    assert_eq!(inner, Some(1));
}

#[cfg(unix)]
#[test]
fn mode_stays_links_are_followed_and_permissions_are_given() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let fixture = fixture();
    let at = |name: &str| fixture.directory.path().join(name);
    let mode = |name: &str| at(name).metadata().unwrap().permissions().mode() & 0o7777;
    std::fs::set_permissions(at("a.c"), PermissionsExt::from_mode(0o640)).unwrap();
    std::fs::create_dir(at("links")).unwrap();
    symlink("../a.c", at("links/a")).unwrap();
    symlink("links/a", at("again")).unwrap();
    symlink("nothing.c", at("dangling")).unwrap();
    let new = |name: &str, mode| NewContent { mode, ..NewContent::new(at(name), b"x".to_vec()) };
    let files = [new("again", None), new("dangling", Some(0o755)), new("b.c", Some(0o600))];
    written(&files, &mut |_| Ok(())).unwrap();
    assert_eq!(std::fs::read(at("a.c")).unwrap(), b"x");
    assert_eq!((mode("a.c"), mode("nothing.c"), mode("b.c")), (0o640, 0o755, 0o600));
    assert!(at("again").is_symlink() && at("dangling").is_symlink());
    symlink("loop", at("loop")).unwrap();
    let error = written(&[new("loop", None)], &mut |_| Ok(())).unwrap_err().to_string();
    assert!(error.contains("too many links"), "{error}");
}

#[test]
fn directories_in_the_way_are_told() {
    let fixture = fixture();
    let at = |name: &str| NewContent::new(fixture.directory.path().join(name), Vec::new());
    std::fs::create_dir(fixture.directory.path().join("d")).unwrap();
    let refused = |name: &str| written(&[at(name)], &mut |_| Ok(())).unwrap_err().to_string();
    assert!(refused("d").ends_with("d`: is a directory"), "{}", refused("d"));
    let below = refused("a.c/x.c");
    assert!(below.contains("not a directory"), "{below}");
}

#[test]
fn a_file_that_was_changed_meanwhile_is_left() {
    for several in [false, true] {
        let mut fixture = fixture();
        let at = |name: &str| fixture.directory.path().join(name);
        let [a, c] = [at("a.c"), at("sub/c.c")];
        for file in &mut fixture.files {
            file.before = std::fs::read(&file.path).ok().into();
        }
        for changed in [&a, &c] {
            let mut files = fixture.files.clone();
            if !several {
                files.retain(|file| file.path == *changed);
            }
            // Another program writes the file between the read and the rename.
            let done = written(&files, &mut |step| {
                if step == Step::Replace {
                    std::fs::write(changed, "other\n").unwrap();
                }
                Ok(())
            });
            let error = done.unwrap_err();
            assert_eq!(error.path, *changed);
            assert!(error.to_string().contains("changed by another program"), "{error}");
            let (mut found, leftovers) = contents(fixture.directory.path());
            let name = changed.strip_prefix(fixture.directory.path()).unwrap();
            assert_eq!(found.remove(&*name.to_string_lossy()).as_deref(), Some("other\n"));
            assert_eq!(leftovers, 0);
            if several {
                assert_eq!(found.get("b.c").map(String::as_str), Some("old b\n"));
            }
            if changed == &a {
                std::fs::write(changed, "old a\n").unwrap();
            } else {
                std::fs::remove_file(changed).unwrap();
            }
        }
        written(&fixture.files, &mut |_| Ok(())).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_out_of_the_folder() {
    let directory = tempfile::tempdir().unwrap();
    let root = directory.path().join("root");
    let victim = directory.path().join("victim");
    std::fs::create_dir(&root).unwrap();
    std::fs::create_dir(&victim).unwrap();
    std::fs::write(victim.join("a"), "old").unwrap();
    std::os::unix::fs::symlink("../victim", root.join("codels")).unwrap();
    std::os::unix::fs::symlink("../victim/a", root.join("a")).unwrap();
    let mut file = NewContent::new(root.join("codels/new/a"), b"new".to_vec());
    file.within = vec![root.clone()];
    for (path, link) in [("codels/new/a", "codels"), ("codels/a", "codels"), ("a", "a")] {
        file.path = root.join(path);
        let error = written(std::slice::from_ref(&file), &mut |_| Ok(())).unwrap_err().to_string();
        let named = format!("the link `{}` leads out", root.join(link).display());
        assert!(error.contains(&named), "{error}");
    }
    file.path = root.join("../victim/a");
    let error = written(std::slice::from_ref(&file), &mut |_| Ok(())).unwrap_err().to_string();
    assert!(error.contains("it is outside of"), "{error}");
    assert_eq!(contents(&victim), (map(&[("a", "old")]), 0));
    // A path that the user named may lead anywhere.
    file.within.clear();
    file.path = root.join("a");
    written(&[file], &mut |_| Ok(())).unwrap();
    assert_eq!(contents(&victim), (map(&[("a", "new")]), 0));
}
