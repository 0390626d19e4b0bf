//! Names of files, comments and `doc` texts that would be something else where they are shown.
#![cfg(unix)]

use serde_json::json;

#[allow(dead_code, reason = "shared with other tests")]
use crate::directory::{Directory, status, stderr, stdout};
use crate::server::Server;

const NAME: &str = "a\u{1b}[31m\u{7}\u{202e}b.gen";

#[test]
fn a_terminal_gets_no_control_characters() {
    let directory = Directory::new(&[
        (
            NAME,
            "#include \"\u{1b}[2J.idl\"\nstruct s { nope x; }; struct s {}; // \u{1b}]0;title\u{7}\n",
        ),
        ("templates/quits/template.tcl", "template fatal \"\\x1b\\[2J failed\"\n"),
    ]);
    for arguments in [
        &["check", NAME][..],
        &["check", "missing\u{1b}[31m.gen"],
        &["verify", NAME],
        &["generate", "docs", NAME],
        &["generate", "-n", NAME],
        &["generate", "docs", "missing\u{1b}[31m.gen"],
        &["generate", "-t", "templates", "quits", NAME],
        &["generate", "no\u{1b}[31mne", NAME],
        &["codels", "check", NAME],
        &["codels", "build", NAME],
        &["run", NAME],
        &["run", "missing\u{1b}[31m.gen"],
    ] {
        let output = directory.run(arguments);
        assert_ne!(status(&output), 0, "{arguments:?}");
        let printed = stdout(&output) + &stderr(&output);
        let harmful = |character: char| {
            character.is_control() && !matches!(character, '\n' | '\t') || character == '\u{202e}'
        };
        let found: Vec<char> = printed.chars().filter(|character| harmful(*character)).collect();
        assert_eq!(found, [], "{arguments:?}: {printed}");
    }
}

#[test]
fn an_editor_gets_no_markdown_of_others() {
    let text = "component c {\n  doc \"<img src=x> [a](command:b) `c` *d*\\n# e\";\n};\n";
    let capabilities = json!({ "textDocument": { "hover": { "contentFormat": ["markdown"] } } });
    let mut server = Server::start_with(json!({ "capabilities": capabilities }), &[]);
    server.open(text);
    let place = json!({ "textDocument": { "uri": "file:///nowhere/arm.gen" },
                        "position": { "line": 0, "character": 10 } });
    let hover = server.request(1, "textDocument/hover", place);
    let shown = hover["result"]["contents"]["value"].as_str().expect("Markdown");
    let doc = "\\<img src=x\\> \\[a\\](command:b) \\`c\\` \\*d\\*";
    assert!(shown.contains(doc), "{shown}");
    server.end();
}
