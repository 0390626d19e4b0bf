//! URIs and paths.
//!
//! A document that is not a file (`untitled:Untitled-1`, `git:…`) gets a path made of its URI below
//! `/dotgen-virtual`, which contains no files.

use camino::{Utf8Path, Utf8PathBuf};

use crate::protocol::types::Uri;

const VIRTUAL: &str = "/dotgen-virtual";

/// The absolute path of a document.
pub(crate) fn to_path(uri: &Uri) -> Utf8PathBuf {
    if uri.scheme().as_str().eq_ignore_ascii_case("file")
        && let Some(path) = uri.to_file_path()
        && let Some(path) = Utf8Path::from_path(&path)
    {
        return dotgen_platform::files::vfs::normalize(path);
    }
    let name = uri.as_str().replace(['/', '\\'], "_");
    Utf8Path::new(VIRTUAL).join(name)
}

/// The URI with escapes for the characters that RFC 3986 forbids, if it has any. Clients write names of files
/// into URIs as they are: brackets, spaces, letters beyond ASCII. In the URI of a file, `#` and `?` belong to
/// the name too.
pub fn escaped(text: &str) -> Option<String> {
    let (scheme, rest) = text.split_once(':')?;
    let is_scheme = scheme.starts_with(|first: char| first.is_ascii_alphabetic())
        && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte));
    if !is_scheme {
        return None;
    }
    let is_file = scheme.eq_ignore_ascii_case("file");
    let bytes = rest.as_bytes();
    let hexadecimal = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_hexdigit);
    let mut out = String::with_capacity(text.len());
    out.push_str(scheme);
    out.push(':');
    // A URI has one fragment: a second `#` is not a delimiter.
    let mut fragments = 0;
    for (at, &byte) in bytes.iter().enumerate() {
        let is_allowed = match byte {
            b'%' => hexadecimal(at + 1) && hexadecimal(at + 2),
            b'?' => !is_file,
            b'#' => {
                fragments += 1;
                !is_file && fragments == 1
            }
            _ => byte.is_ascii_alphanumeric() || b"-._~!$&'()*+,;=:@/".contains(&byte),
        };
        if is_allowed { out.push(char::from(byte)) } else { out.push_str(&format!("%{byte:02X}")) }
    }
    (out != text).then_some(out)
}

/// The URI of a path. For an open document, `crate::session::writer::Snapshot::uri` returns the spelling of
/// its client.
pub fn from_path(path: &Utf8Path) -> Option<Uri> {
    Uri::from_file_path(path.as_std_path())
}

/// True for the path of a document that is not a file.
pub(crate) fn is_virtual(path: &Utf8Path) -> bool {
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
    fn raw_characters_are_escaped() {
        for (raw, expected) in [
            ("file:///a/[arm]/é x.gen", "/a/[arm]/é x.gen"),
            ("file:///a#b?c.gen", "/a#b?c.gen"),
            ("file:///100%.gen", "/100%.gen"),
            ("file:///a%5B[.gen", "/a[[.gen"),
        ] {
            let escaped = escaped(raw).expect("it differs");
            assert_eq!(path(&escaped), expected);
            assert_eq!(super::escaped(&escaped), None);
        }
        assert_eq!(escaped("untitled:a b"), Some("untitled:a%20b".to_owned()));
        for valid in ["file:///a%20b.gen", "git:/a.gen?x=%7B%7D#f", "", "::not a uri::", "a b"] {
            assert_eq!(escaped(valid), None, "{valid}");
        }
    }

    #[test]
    fn documents_that_are_no_files_get_a_path_of_their_own() {
        assert_eq!(path("untitled:Untitled-1"), "/dotgen-virtual/untitled:Untitled-1");
        assert!(is_virtual(&to_path(&"git:/a/b.gen?x".parse().expect("a URI"))));
    }
}
