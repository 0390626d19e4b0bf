//! The notice: the text of a special comment that templates copy into their output.

use std::path::Path;

use super::tcl;
use crate::disk::Disk;

/// The notices of inputs, one after the other; `None` if they have none.
pub(crate) fn notice_of(disk: &dyn Disk, folder: &Path, inputs: &[String]) -> Option<String> {
    let texts = inputs.iter().filter_map(|input| disk.read(&folder.join(input)).ok());
    let notices: Vec<String> = texts.filter_map(|text| notice(&tcl::decode(&text))).collect();
    (!notices.is_empty()).then(|| notices.concat())
}

/// The first comment of a file that contains the mark `/*/`, up to its end, without the decoration at the
/// start of its lines. `None` if there is none or it is not closed.
pub fn notice(text: &str) -> Option<String> {
    let mut out: Option<String> = None;
    let mut inside = false;
    for line in text.split_inclusive('\n') {
        let mut rest = line.to_owned();
        if !inside {
            let Some(at) = line.find("/*/") else {
                continue;
            };
            inside = true;
            let after = &line[at + 3..];
            // A blank replaces the last character of the mark, to keep columns aligned.
            rest = if after.starts_with('\n') { after.to_owned() } else { format!(" {after}") };
        }
        if let Some(end) = rest.find("*/") {
            rest.truncate(end);
            inside = false;
        }
        let undecorated = rest.trim_start_matches([' ', '\t']);
        if !undecorated.is_empty() {
            let kept = if undecorated.starts_with('*') {
                undecorated.trim_start_matches('*')
            } else {
                &rest
            };
            out.get_or_insert_default().push_str(kept);
        }
        if !inside && out.is_some() {
            break;
        }
    }
    if inside { None } else { out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_line_keeps_its_columns() {
        assert_eq!(notice("/*/ One. */\nx").as_deref(), Some("  One. "));
        assert_eq!(notice("/*/\n * a\n */").as_deref(), Some("\n a\n"));
    }

    #[test]
    fn decoration_is_removed() {
        assert_eq!(
            notice("x\n/*/ a\n *\n ** b\n\tc\n\n */ d").as_deref(),
            Some("  a\n\n b\n\tc\n\n")
        );
        assert_eq!(notice("/* a */"), None);
        assert_eq!(notice("/*/ open\n"), None);
    }
}
