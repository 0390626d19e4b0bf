//! URIs and paths.
//!
//! A document that is not a file (`untitled:Untitled-1`, `git:…`) gets a path made of its URI below
//! `/dotgen-virtual`, which contains no files.

use camino::{Utf8Path, Utf8PathBuf};

use crate::protocol::types::Uri;

const VIRTUAL: &str = "/dotgen-virtual";

/// The absolute path of a document.
pub fn to_path(uri: &Uri) -> Utf8PathBuf {
    if uri.scheme().as_str().eq_ignore_ascii_case("file")
        && let Some(path) = uri.to_file_path()
        && let Some(path) = Utf8Path::from_path(&path)
    {
        return dotgen_platform::files::vfs::normalize(path);
    }
    let name = uri.as_str().replace(['/', '\\'], "_");
    Utf8Path::new(VIRTUAL).join(name)
}

/// The URI of a path. For an open document, `crate::session::writer::Snapshot::uri` returns the spelling of
/// its client.
pub fn from_path(path: &Utf8Path) -> Option<Uri> {
    Uri::from_file_path(path.as_std_path())
}

/// True for the path of a document that is not a file.
pub fn is_virtual(path: &Utf8Path) -> bool {
    path.starts_with(VIRTUAL)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(uri: &str) -> String {
        to_path(&uri.parse().expect("a URI")).into_string()
    }

    #[test]
    fn escapes_are_undone_and_dots_resolved() {
        assert_eq!(path("file:///a%20b/./c/../d%C3%A9.gen"), "/a b/dé.gen");
        assert_eq!(path("FILE:///x.gen"), "/x.gen");
    }

    #[test]
    fn documents_that_are_no_files_get_a_path_of_their_own() {
        assert_eq!(path("untitled:Untitled-1"), "/dotgen-virtual/untitled:Untitled-1");
        assert!(is_virtual(&to_path(&"git:/a/b.gen?x".parse().expect("a URI"))));
    }
}
