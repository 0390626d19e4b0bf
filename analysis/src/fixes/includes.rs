//! Misspelt paths of included files.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::suggestion::nearest;

use crate::base::Db;

/// Maximum number of directory entries to compare.
const MOST_ENTRIES: usize = 2000;

/// The file nearest to a path, in the first of the directories that has one.
pub(crate) fn near_include<'d>(
    db: &dyn Db,
    directories: impl IntoIterator<Item = &'d Utf8Path>,
    path: &str,
) -> Option<String> {
    directories
        .into_iter()
        .find_map(|directory| below(db, directory, path))
        .filter(|directory| directory != path)
}

/// A path below a directory, with missing parts replaced by the nearest existing ones.
fn below(db: &dyn Db, directory: &Utf8Path, path: &str) -> Option<String> {
    let mut here: Utf8PathBuf = directory.to_owned();
    let mut out: Vec<String> = Vec::new();
    let parts: Vec<&str> = path.split('/').collect();
    for (index, &part) in parts.iter().enumerate() {
        let name = match part {
            "." | ".." => part.to_owned(),
            _ => {
                let is_last = index + 1 == parts.len();
                let entries = db.directory(&here).entries(db).iter().take(MOST_ENTRIES);
                let entries = entries.filter(|entry| entry.is_dir != is_last);
                let names = || entries.clone().map(|entry| entry.name.as_str());
                let exact = names().find(|name| *name == part);
                exact.or_else(|| nearest(part, names()))?.to_owned()
            }
        };
        here.push(&name);
        out.push(name);
    }
    Some(out.join("/"))
}
