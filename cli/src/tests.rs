//! The help of every command, as one text.

/// Adds the help of a command, and of all commands below it.
fn add(command: &clap::Command, path: &str, text: &mut String) {
    let mut command = command.clone().term_width(100);
    text.push_str(&format!("$ {path} --help\n"));
    for line in command.render_long_help().to_string().lines() {
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text.push('\n');
    for inner in command.get_subcommands() {
        if inner.get_name() != "help" && !inner.is_hide_set() {
            add(inner, &format!("{path} {}", inner.get_name()), text);
        }
    }
}

#[test]
fn the_help_of_all_commands() {
    let mut command = crate::help::command();
    command.build();
    let mut text = String::new();
    add(&command, "dotgen", &mut text);
    insta::assert_snapshot!(text);
}
