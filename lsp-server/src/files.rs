//! Files: as analysis sees them, as users have them, and packages.

pub mod disk;
pub(crate) mod history;
pub mod vfs;

/// "permission denied", without the number of the operating system.
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((text, _)) => text.to_lowercase(),
        None => text,
    }
}
