//! `dotgen run --systemd`: a unit that starts the same run with the machine.

use std::ffi::OsString;

use dotgen_hosting::realtime;

/// The option itself, which the unit leaves out.
const OPTION: &str = "--systemd";

/// Returns the unit of a run of this program with these arguments, in the current folder.
///
/// # Errors
/// The program or the folder has no path as text.
pub(super) fn unit(
    title: &str,
    arguments: impl Iterator<Item = OsString>,
) -> anyhow::Result<String> {
    let program = std::env::current_exe()?;
    let folder = std::env::current_dir()?;
    let mut words = vec![quoted(&text(program.into())?)];
    for argument in arguments.filter(|argument| argument != OPTION) {
        words.push(quoted(&text(argument)?));
    }
    Ok(format!(
        "[Unit]\n\
         Description=GenoM3 components: {title}\n\
         After=network-online.target\n\
         Wants=network-online.target\n\
         \n\
         [Service]\n\
         User={user}\n\
         WorkingDirectory={folder}\n\
         ExecStart={command}\n\
         # 3: the run was stopped; 2: nothing can be run.\n\
         SuccessExitStatus=3\n\
         Restart=on-failure\n\
         RestartPreventExitStatus=2\n\
         # Real-time priority and locked memory for codels.\n\
         LimitRTPRIO={priority}\n\
         LimitMEMLOCK=infinity\n\
         \n\
         [Install]\n\
         WantedBy=multi-user.target\n",
        title = escaped(&text(title.into())?),
        user = rustix::process::getuid().as_raw(),
        folder = escaped(&text(folder.into())?),
        command = words.join(" "),
        priority = realtime::ENGINE_PRIORITY,
    ))
}

fn text(argument: OsString) -> anyhow::Result<String> {
    match argument.into_string() {
        Ok(text) if !text.contains(char::is_control) => Ok(text),
        Ok(text) => anyhow::bail!(
            "{text:?} has a line end or another control character: a unit cannot contain it"
        ),
        Err(argument) => anyhow::bail!("{argument:?} is not UTF-8: a unit cannot contain it"),
    }
}

/// A word of a command line, as systemd reads it: `%` and `$` stand for themselves.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    let word = escaped(word).replace('\\', "\\\\").replace('"', "\\\"").replace('$', "$$");
    format!("\"{word}\"")
}

fn escaped(text: &str) -> String {
    text.replace('%', "%%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_whole() {
        assert_eq!(quoted("pump.scn"), "pump.scn");
        assert_eq!(quoted("pump.fill={\"height\": 2}"), "\"pump.fill={\\\"height\\\": 2}\"");
        assert_eq!(quoted("a $b 5%"), "\"a $$b 5%%\"");
        assert_eq!(quoted(""), "\"\"");
    }
}
