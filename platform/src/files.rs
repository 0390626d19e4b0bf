//! Files: reading for analysis, writing for users, and packages.

pub mod disk;
pub mod history;
pub mod vfs;

/// The message of an error, without the error number: "permission denied".
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((text, _)) => text.to_lowercase(),
        None => text,
    }
}
