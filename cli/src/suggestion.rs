//! Suggestions for options that do not exist.

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use dotgen_syntax::suggestion::nearest;

use super::Cli;

/// Adds a similar option to the error of the command line. Clap's own similarity finds no transposed letters
/// in short words.
pub(super) fn add_suggestion(mut error: Error) -> Error {
    if error.kind() != ErrorKind::UnknownArgument || error.get(ContextKind::SuggestedArg).is_some()
    {
        return error;
    }
    let Some(ContextValue::String(wrong)) = error.get(ContextKind::InvalidArg) else {
        return error;
    };
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.filter_map(|argument| argument.into_string().ok());
    let Some(near) = near(wrong, arguments) else {
        return error;
    };
    error.remove(ContextKind::Suggested);
    error.insert(ContextKind::SuggestedArg, ContextValue::String(near));
    error
}

/// Returns the option of the subcommand in the arguments that is nearest to a wrong one.
fn near(wrong: &str, arguments: impl Iterator<Item = String>) -> Option<String> {
    let wrong = wrong.strip_prefix("--")?;
    let mut command = Cli::command();
    command.build();
    let mut command = &command;
    for word in arguments {
        command = command.find_subcommand(&word).unwrap_or(command);
    }
    let shown = command.get_arguments().filter(|argument| !argument.is_hide_set());
    let options: Vec<&str> = shown.filter_map(|argument| argument.get_long()).collect();
    nearest(wrong, options).map(|text| format!("--{text}"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn transposed_letters_are_found() {
        let near = |wrong: &str, words: &[&str]| {
            super::near(wrong, words.iter().map(|word| (*word).to_owned()))
        };
        assert_eq!(near("--fxi", &["check", "lamp"]).as_deref(), Some("--fix"));
        assert_eq!(near("--dryrun", &["codels", "stub"]).as_deref(), Some("--dry-run"));
        assert_eq!(near("--colour", &["check"]).as_deref(), Some("--color"));
        assert_eq!(near("--frobnicate", &["check"]), None);
    }
}
