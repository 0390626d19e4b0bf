//! The interfaces included in dotgen, which replace packages that are not installed.
//!
//! Editors and the codels' compiler need files, so the definitions are written to the user's cache, into a
//! folder with a name derived from their content.

use std::hash::{Hash, Hasher};
use std::sync::OnceLock;

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::FxHasher;

macro_rules! definitions {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../../../interfaces/", $path)))),*]
    };
}

/// Files, by package and path of the include.
const DEFINITIONS: &[(&str, &str)] = definitions![
    "openrobots-idl/or/pose/pose_estimator.gen",
    "openrobots-idl/or/pose/t3d.idl",
    "openrobots-idl/or/robot/rotorcraft.gen",
    "openrobots-idl/or/time/time.idl",
    "openrobots2-idl/or/pose/pose_estimator.gen",
    "openrobots2-idl/or/pose/rb3d.idl",
    "openrobots2-idl/or/pose/rigid_body.gen",
    "openrobots2-idl/or/pose/t3d.idl",
    "openrobots2-idl/or/pose/wrench_estimator.gen",
    "openrobots2-idl/or/robot/rotorcraft.gen",
    "openrobots2-idl/or/robot/uav.gen",
    "openrobots2-idl/or/sensor/joint.gen",
    "openrobots2-idl/or/time/time.idl",
    "vision-idl/or/sensor/calibration.idl",
    "vision-idl/or/sensor/camera.gen",
    "vision-idl/or/sensor/depth.idl",
    "vision-idl/or/sensor/image.idl",
    "vision-idl/or/sensor/pixel.idl",
];

/// Packages, and the packages whose folders each needs.
const PACKAGES: &[(&str, &[&str])] = &[
    ("openrobots-idl", &["openrobots-idl"]),
    ("openrobots2-idl", &["openrobots2-idl"]),
    ("vision-idl", &["vision-idl", "openrobots2-idl"]),
];

/// Prefix of the folder's name in the cache.
const PREFIX: &str = "interfaces-";

/// Returns `true` if dotgen includes the interfaces of a package.
pub fn has(package: &str) -> bool {
    PACKAGES.iter().any(|candidate| candidate.0 == package)
}

/// The folders with the interfaces of a package. None if there are no such interfaces, or if they cannot be
/// written.
pub(super) fn folders_of(package: &str) -> Vec<Utf8PathBuf> {
    let needed = PACKAGES.iter().find(|candidate| candidate.0 == package);
    let folder = needed.and_then(|package| Some((package.1, written()?)));
    let Some((needed, folder)) = folder else {
        return Vec::new();
    };
    needed.iter().map(|package| folder.join(package)).collect()
}

/// The folder of all definitions, written once.
fn written() -> Option<&'static Utf8Path> {
    static FOLDER: OnceLock<Option<Utf8PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = cache()?.join(format!("{PREFIX}{:016x}", content()));
        let write = || write(&folder);
        if is_whole(&folder) || write().is_ok() || is_whole(&folder) { Some(folder) } else { None }
    });
    folder.as_deref()
}

/// The directory of dotgen's caches, by the XDG specification.
fn cache() -> Option<Utf8PathBuf> {
    let absolute = |name: &str| {
        let path = Utf8PathBuf::from(std::env::var(name).ok()?);
        path.is_absolute().then_some(path)
    };
    let base = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")));
    Some(base?.join("dotgen"))
}

/// Returns `true` for a file of these definitions, of this or another version. Edits of such files would be
/// lost.
pub fn is_own(path: &Utf8Path) -> bool {
    let below = cache().and_then(|cache| path.strip_prefix(cache).ok());
    below.is_some_and(|below| below.as_str().starts_with(PREFIX))
}

/// The path in an `#include` of a file of these definitions.
pub fn include_of(path: &Utf8Path) -> Option<&Utf8Path> {
    let mut below = path.strip_prefix(cache()?).ok()?.components();
    let folder = below.next()?;
    if !folder.as_str().starts_with(PREFIX) {
        return None;
    }
    let _package = below.next()?;
    Some(below.as_path())
}

fn content() -> u64 {
    let mut hasher = FxHasher::default();
    DEFINITIONS.hash(&mut hasher);
    hasher.finish()
}

fn is_whole(folder: &Utf8Path) -> bool {
    let mut all = DEFINITIONS.iter();
    all.all(|(path, text)| {
        crate::files::read_regular_to_string(folder.join(path).as_std_path())
            .is_ok_and(|content| content == *text)
    })
}

/// Writes into a temporary folder next to `folder` and renames it, so that `folder` is always complete.
fn write(folder: &Utf8Path) -> std::io::Result<()> {
    let around = folder.parent().unwrap_or(folder);
    std::fs::create_dir_all(around)?;
    let fresh = tempfile::Builder::new().prefix(".interfaces-").tempdir_in(around)?;
    for (path, text) in DEFINITIONS {
        let file = fresh.path().join(path);
        std::fs::create_dir_all(file.parent().unwrap_or(fresh.path()))?;
        std::fs::write(file, text)?;
    }
    if std::fs::rename(fresh.path(), folder).is_err() {
        if is_whole(folder) {
            return Ok(()); // another process was faster
        }
        // A file in the folder was changed. The whole folder is replaced.
        std::fs::rename(folder, fresh.path().join("old"))?;
        std::fs::rename(fresh.path(), folder)?;
        std::fs::remove_dir_all(folder.join("old"))?;
    }
    _ = fresh.keep();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_definitions_are_embedded() {
        let folder = Utf8Path::new(env!("CARGO_MANIFEST_DIR")).join("interfaces");
        let files = walkdir::WalkDir::new(&folder).into_iter();
        let files = files.map(|file| file.expect("an entry").into_path());
        let files = files.filter(|file| {
            file.is_file() && file.extension().is_some_and(|extension| extension != "md")
        });
        let mut found: Vec<String> = files
            .map(|file| Utf8PathBuf::from_path_buf(file).expect("UTF-8"))
            .map(|path| path.strip_prefix(&folder).expect("inside").to_string())
            .collect();
        found.sort();
        let known: Vec<&str> = DEFINITIONS.iter().map(|definition| definition.0).collect();
        assert_eq!(found, known);
        let packages = |text: &&str| has(text.split('/').next().unwrap_or_default());
        assert!(known.iter().all(packages));
    }

    #[test]
    fn a_written_folder_stays_whole_while_others_write() {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let folder = Utf8Path::from_path(folder.path()).expect("UTF-8").join("a");
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..10 {
                        write(&folder).expect("written");
                        assert!(is_whole(&folder));
                    }
                });
            }
        });
        let around = folder.parent().expect("a folder");
        assert_eq!(around.read_dir_utf8().expect("read").count(), 1);
    }

    #[test]
    fn files_in_the_cache_are_known() {
        let cache = cache().expect("a home");
        assert!(is_own(&cache.join("interfaces-0/p/or/a.gen")));
        assert!(!is_own(&cache.join("other/a.gen")));
        assert!(!is_own("/elsewhere/interfaces-0/a.gen".into()));
    }

    #[test]
    fn a_folder_that_was_changed_is_written_anew() {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let folder = Utf8Path::from_path(folder.path()).expect("UTF-8").join("a/b");
        write(&folder).expect("written");
        assert!(is_whole(&folder));
        std::fs::write(folder.join(DEFINITIONS[0].0), "").expect("written");
        assert!(!is_whole(&folder));
        write(&folder).expect("written");
        assert!(is_whole(&folder));
        let left = folder.parent().expect("a folder").read_dir_utf8().expect("read");
        assert_eq!(left.count(), 1);
    }
}
