//! `cargo xtask docs`: the pictures of the documentation, drawn from the examples.

use anyhow::{Context, Result};

use xtask::extension::{self, Profile};
use xtask::run::{self, step};

/// Draws every picture in `docs/pictures/list.txt`.
pub(crate) fn docs() -> Result<()> {
    let server = extension::build_server(Profile::Dev)?;
    let directory = xtask::root().join("docs/pictures");
    let list = std::fs::read_to_string(directory.join("list.txt"))?;
    let mut count = 0;
    for line in list.lines().filter(|line| !line.starts_with('#')) {
        let (file, how) = line
            .split_once(": ")
            .with_context(|| format!("docs/pictures/list.txt: no `: ` in `{line}`"))?;
        let output = directory.join(file);
        let output = output.to_string_lossy();
        let mut arguments = vec!["diagram"];
        arguments.extend(how.split_whitespace());
        arguments.extend(["-o", &*output]);
        let program = server.to_string_lossy();
        run::capture(run::command(xtask::root(), &program, &arguments))?;
        count += 1;
    }
    step(&format!("Drew {count} pictures in docs/pictures"));
    Ok(())
}
