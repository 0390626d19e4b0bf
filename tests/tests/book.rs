//! The manual: its table of contents, and the links of its pages.

use dotgen_tests::workspace_root;

/// Every Markdown file of the manual but the table of contents, by its path in `docs`, with its text.
fn pages() -> Vec<(String, String)> {
    let folder = workspace_root().join("docs");
    let mut pages: Vec<(String, String)> = walkdir::WalkDir::new(&folder)
        .into_iter()
        .map(|entry| entry.unwrap().into_path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .map(|path| {
            let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
            (name.to_owned(), std::fs::read_to_string(&path).unwrap())
        })
        .filter(|(name, _)| name != "SUMMARY.md")
        .collect();
    pages.sort_unstable();
    pages
}

#[test]
fn the_table_of_contents_lists_every_page_once() {
    let contents = std::fs::read_to_string(workspace_root().join("docs/SUMMARY.md")).unwrap();
    let mut listed: Vec<&str> =
        contents.lines().filter_map(|line| line.split_once("](")?.1.strip_suffix(')')).collect();
    listed.sort_unstable();
    let pages = pages();
    let pages: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(listed, pages);
}

/// The book contains only `docs`: a link to another file of the repository has its whole address.
#[test]
fn relative_links_lead_to_files_of_the_manual() {
    let folder = workspace_root().join("docs");
    let mut dead = Vec::new();
    for (name, text) in pages() {
        let place = folder.join(&name);
        for after in text.split("](").skip(1) {
            let link = after.split_once(')').map_or(after, |(link, _)| link);
            let path = link.split('#').next().unwrap_or_default();
            let is_path = !path.is_empty() && !path.contains([':', ' ', '`', '\n']);
            let target = place.parent().unwrap().join(path);
            let is_ours = target
                .canonicalize()
                .is_ok_and(|path| path.starts_with(folder.canonicalize().unwrap()));
            if is_path && !is_ours {
                dead.push(format!("{name}: {link}"));
            }
        }
    }
    assert!(dead.is_empty(), "{dead:#?}");
}

/// The page of editors shows the configurations in `editors`.
#[test]
fn configurations_of_editors_are_on_their_page() {
    let root = workspace_root();
    let page = std::fs::read_to_string(root.join("docs/editors.md")).unwrap();
    for file in [
        "emacs/genom3-mode.el",
        "helix/languages.toml",
        "neovim/lsp/dotgen.lua",
        "neovim/plugin/dotgen.lua",
    ] {
        let text = std::fs::read_to_string(root.join("editors").join(file)).unwrap();
        assert!(page.contains(&text), "docs/editors.md has another {file}");
    }
}
