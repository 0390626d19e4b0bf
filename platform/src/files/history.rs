//! The times at which files got their present text: from git if the file is as committed, else from its time
//! stamp.

use std::ffi::OsString;
use std::time::{Duration, Instant, SystemTime};

use camino::Utf8Path;
use dotgen_codegen::process::Process;

use crate::process;

/// The time at which a file on disk got its text; `None` if it is unknown.
///
/// In a fresh clone every file has the time stamp of the clone. A file that is as committed got its text with
/// the last commit that changed it. The git commands only read objects. They refresh no index, run no hook
/// and no filter, and use no network, whatever the settings of the repository are.
///
/// Without the right to start programs, git is not asked: the workspace is not trusted.
pub fn changed(path: &Utf8Path, may_run: bool) -> Option<SystemTime> {
    let committed = may_run.then(|| committed(path)).flatten();
    committed.or_else(|| std::fs::metadata(path).ok()?.modified().ok())
}

/// The time of the last commit that changed a file, in whole seconds, if the file still has that text.
fn committed(path: &Utf8Path) -> Option<SystemTime> {
    let (folder, name) = (path.parent()?, path.file_name()?);
    let blob = git(folder, &["cat-file", "blob", &format!("HEAD:./{name}")])?;
    if super::read_regular(path.as_std_path()).ok()? != blob {
        return None;
    }
    let question = ["rev-list", "-1", "--timestamp", "HEAD", "--"];
    let file = format!("./{name}");
    let answer = git(folder, &[&question[..], &[file.as_str()]].concat())?;
    let seconds = String::from_utf8(answer).ok()?;
    let seconds = seconds.split(' ').next()?.parse().ok()?;
    SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds))
}

/// Options of git, whatever the repository sets: no folder of the work tree is taken for a repository, and
/// missing objects of a partial clone are not fetched.
const OPTIONS: [&str; 7] = [
    "-c",
    "safe.bareRepository=explicit",
    "-c",
    "protocol.allow=never",
    "-c",
    "protocol.ext.allow=never",
    "--literal-pathspecs",
];

/// The time after which git is killed.
const LIMIT: Duration = Duration::from_secs(10);

/// The output of git in a folder; `None` if git is not installed, fails or prints nothing.
fn git(folder: &Utf8Path, question: &[&str]) -> Option<Vec<u8>> {
    let mut words: Vec<OsString> = vec!["-C".into(), folder.into()];
    words.extend(OPTIONS.map(Into::into));
    words.extend(question.iter().map(Into::into));
    let environment =
        [("GIT_NO_LAZY_FETCH", "1".to_owned()), ("GIT_OPTIONAL_LOCKS", "0".to_owned())];
    answer(process::ask("git", words, &environment).ok()?, LIMIT)
}

/// The output of a program; `None` if it fails. It is killed after the limit.
fn answer(mut process: Process, limit: Duration) -> Option<Vec<u8>> {
    let started = Instant::now();
    let ended = process.wait_with_outputs_unless(&|| started.elapsed() > limit);
    let (status, printed, _) = ended.ok()?;
    status.success().then_some(printed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    fn run(folder: &Utf8Path, words: &[&str]) {
        let run = Command::new("git")
            .arg("-C")
            .arg(folder)
            .args(["-c", "user.name=a", "-c", "user.email=a@b"])
            .args(words)
            .env("GIT_COMMITTER_DATE", "@1000000 +0000")
            .env("GIT_AUTHOR_DATE", "@1000000 +0000")
            .output();
        let output = run.expect("git runs");
        assert!(output.status.success(), "{output:?}");
    }

    #[test]
    fn a_file_is_as_old_as_its_commit_until_it_is_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Utf8Path::from_path(folder.path()).expect("UTF-8");
        let file = folder.join("a.gen");
        std::fs::write(&file, "component a {};\n").expect("written");
        let stamp =
            || std::fs::metadata(&file).and_then(|metadata| metadata.modified()).expect("a time");
        assert_eq!(changed(&file, true), Some(stamp()), "no repository");
        run(folder, &["init", "-q"]);
        assert_eq!(changed(&file, true), Some(stamp()), "no commit");
        run(folder, &["add", "a.gen"]);
        run(folder, &["commit", "-q", "-m", "a"]);
        let then = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000);
        assert_eq!(changed(&file, true), Some(then));
        std::fs::write(&file, "component a { };\n").expect("written");
        assert_eq!(changed(&file, true), Some(stamp()), "not committed");
        assert_eq!(changed(&folder.join("b.gen"), true), None, "not there");
    }

    #[test]
    fn nothing_is_started_without_the_right() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Utf8Path::from_path(folder.path()).expect("UTF-8");
        run(folder, &["init", "-q"]);
        let file = folder.join("a.gen");
        std::fs::write(&file, "component a {};\n").expect("written");
        run(folder, &["add", "a.gen"]);
        run(folder, &["commit", "-q", "-m", "a"]);
        let committed = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000);
        assert_eq!(changed(&file, true), Some(committed));
        assert!(changed(&file, false) > Some(committed));
    }

    #[test]
    fn a_program_that_does_not_end_is_killed() {
        let process =
            process::ask("tail", vec!["-f".into(), "/dev/null".into()], &[]).expect("started");
        assert_eq!(answer(process, Duration::ZERO), None);
    }
}
