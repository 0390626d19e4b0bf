//! `dotgen/codelHeaders`: the headers with which clangd understands codels without a build. The client writes
//! them.

use dotgen_analysis::host::{AnalysisHost, Cancellable};
use dotgen_codegen::codels::command;
use serde::{Deserialize, Serialize};

use crate::features::codels::judged_actions;
use crate::features::codels::{self, Texts};
use crate::protocol::messages::DocumentParams;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Folder for generated headers, next to the specification.
pub const FOLDER: &str = ".dotgen";

/// Text of the `.gitignore` in that folder: every file in it can be generated again.
pub const IGNORED: &str = "*\n";

/// A file to be written.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct HeaderFile {
    /// Its path.
    uri: Uri,
    /// The whole text.
    text: String,
}

/// Answer of `dotgen/codelHeaders`.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct CodelHeaders {
    /// The folder of all files. Its `compile_flags.txt` is for clangd's `--compile-commands-dir`.
    folder: Uri,
    /// In order of paths.
    files: Vec<HeaderFile>,
}

/// The headers, or the errors of the specification.
pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<crate::protocol::user_result::UserResult<CodelHeaders>> {
    use crate::protocol::user_result::UserResult;
    let mut specification = None;
    for compared in codels::around(snapshot, &subject.path)? {
        specification = compared.folders().next().map(|folder| folder.specification.clone());
    }
    let specification = match (specification, snapshot.is_code(&subject.path)) {
        (Some(specification), _) => specification,
        (None, false) => subject.path.clone(),
        (None, true) => return Ok(UserResult::default()),
    };
    let Some(base) = specification.parent() else {
        return Ok(UserResult::default());
    };
    let output = base.join(FOLDER);
    let mut host: AnalysisHost = judged_actions::private_host(snapshot)?;
    let texts = Texts::new(snapshot);
    let mut project = judged_actions::project(&mut host, snapshot, &texts, &subject.path);
    let files = match command::headers(&mut project, &specification, &output, &[]) {
        Ok(files) => files,
        Err(why) => return Ok(UserResult(Err(why))),
    };
    drop(project);
    texts.check()?;
    let files = files.into_iter().filter_map(|file| {
        Some(HeaderFile { uri: snapshot.uri(&output.join(file.path))?, text: file.text })
    });
    let ignored = HeaderFile {
        uri: match snapshot.uri(&output.join(".gitignore")) {
            Some(uri) => uri,
            None => return Ok(UserResult::default()),
        },
        text: IGNORED.to_owned(),
    };
    let files = std::iter::once(ignored).chain(files).collect();
    let answer = snapshot.uri(&output).map(|folder| CodelHeaders { folder, files });
    Ok(UserResult(Ok(answer)))
}
