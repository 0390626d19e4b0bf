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
    let mut pages: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".md") && name != "SUMMARY.md")
        .collect();
    pages.push("diagnostics/README.md".to_owned());
    pages.sort_unstable();
    assert_eq!(listed, pages);
}
