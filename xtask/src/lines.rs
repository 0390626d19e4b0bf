//! `cargo xtask lines`: lines of Rust by crate, without tests.

use std::path::Path;

use anyhow::Result;

/// Prints the lines of each crate of the workspace.
pub(crate) fn lines() -> Result<bool> {
    let mut total = 0;
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(xtask::root().join("Cargo.toml"))
        .no_deps()
        .exec()?;
    for package in &metadata.packages {
        let Some(folder) = package.manifest_path.parent() else {
            continue;
        };
        let lines = of_folder(folder.join("src").as_std_path())?;
        println!("{lines:>7}  {}", folder.strip_prefix(xtask::root()).unwrap_or(folder));
        total += lines;
    }
    println!("{total:>7}  total");
    Ok(true)
}

fn of_folder(folder: &Path) -> Result<usize> {
    let mut lines = 0;
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            lines += of_folder(&path)?;
        } else if name.ends_with(".rs") && name != "tests.rs" {
            lines += without_tests(&std::fs::read_to_string(&path)?);
        }
    }
    Ok(lines)
}

/// The lines before the tests, which are the last module of a file.
fn without_tests(text: &str) -> usize {
    let tests = text.find("\n#[cfg(test)]\nmod tests {");
    text[..tests.unwrap_or(text.len())].lines().count()
}

#[cfg(test)]
mod tests {
    use super::without_tests;

    #[test]
    fn only_the_module_of_tests_is_left_out() {
        let text = "mod a;\n#[cfg(test)]\nmod b;\nfn f() {}\n#[cfg(test)]\nmod tests {\n}\n";
        assert_eq!(without_tests(text), 4);
        assert_eq!(without_tests("mod a;\n"), 1);
    }
}
