//! The arguments of a built-in template: options, then files.

/// The result of reading an option.
pub(super) enum OptionFlow {
    /// Continue with the next word.
    Go,
    /// Stop: help was printed.
    Stop,
}

/// Reads options up to the first word that is not an option; the other words are files. `each` receives an
/// option and a function that returns its value: the text after `=`, or else the next word. `None` if `each`
/// stops.
///
/// # Errors
/// The errors of `each`, and a missing value.
pub(super) fn read(
    args: &[String],
    mut each: impl FnMut(&str, &mut dyn FnMut() -> Result<String, String>) -> Result<OptionFlow, String>,
) -> Result<Option<Vec<String>>, String> {
    let mut words = args.iter();
    while let Some(word) = words.next() {
        if !word.starts_with('-') {
            let files = std::iter::once(word).chain(words);
            return Ok(Some(files.cloned().collect()));
        }
        let (option, value) = match word.split_once('=') {
            Some((option, value)) => (option, Some(value)),
            None => (word.as_str(), None),
        };
        let mut value = || {
            let value = value.or_else(|| words.next().map(String::as_str));
            let value = value.ok_or_else(|| format!("missing argument to {option}"))?;
            Ok(value.to_owned())
        };
        if let OptionFlow::Stop = each(option, &mut value)? {
            return Ok(None);
        }
    }
    Ok(Some(Vec::new()))
}

/// The message for an unknown option.
pub(super) fn unknown(option: &str) -> String {
    format!("unknown option {option}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(args: &[&str]) -> String {
        let args: Vec<String> = args.iter().map(|argument| (*argument).to_owned()).collect();
        let mut out = String::new();
        let files = read(&args, |option, value| {
            match option {
                "-v" | "--value" => out += &format!("{option} {} ", value()?),
                "-f" => out += "-f ",
                "-h" => return Ok(OptionFlow::Stop),
                other => return Err(unknown(other)),
            }
            Ok(OptionFlow::Go)
        });
        match files {
            Ok(files) => format!("{out}{files:?}"),
            Err(error) => error,
        }
    }

    #[test]
    fn options_come_before_files() {
        assert_eq!(shown(&[]), "Some([])");
        assert_eq!(
            shown(&["-v", "a", "--value=b=c", "-f", "x", "-f"]),
            "-v a --value b=c -f Some([\"x\", \"-f\"])"
        );
        assert_eq!(shown(&["-f", "-h", "-x"]), "-f None");
        assert_eq!(shown(&["-x=1"]), "unknown option -x");
        assert_eq!(shown(&["-v"]), "missing argument to -v");
    }
}
