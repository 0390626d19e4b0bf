//! The table of contents of the manual.

use dotgen_tests::workspace_root;

#[test]
fn the_table_of_contents_lists_every_page_once() {
    let folder = workspace_root().join("docs");
    let contents = std::fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    let mut listed: Vec<&str> = contents
        .lines()
        .filter_map(|line| line.split_once("](")?.1.strip_suffix(')'))
        .collect();
    listed.sort_unstable();
    let files = walkdir::WalkDir::new(&folder).into_iter();
    let mut pages: Vec<String> = files
        .map(|entry| entry.unwrap().into_path())
        .filter(|path| path.extension().is_some_and(|it| it == "md"))
        .map(|path| {
            path.strip_prefix(&folder)
                .unwrap()
                .to_str()
                .unwrap()
                .to_owned()
        })
        .filter(|name| name != "SUMMARY.md")
        .collect();
    pages.sort_unstable();
    assert_eq!(listed, pages);
}
