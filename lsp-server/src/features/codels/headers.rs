//! `dotgen/codelHeaders`: the headers with which clangd understands codels without a build. The client writes
//! them.

use dotgen_analysis::host::{AnalysisHost, Cancellable};
use dotgen_codegen::codels::command;
use serde_json::{Value, json};

use crate::features::codels::judged_actions;
use crate::features::codels::{self, Texts};
use crate::protocol::messages::DocumentParams;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Folder for generated headers, next to the specification.
pub const FOLDER: &str = ".dotgen";

/// Text of the `.gitignore` in that folder: every file in it can be generated again.
pub const IGNORED: &str = "*\n";

/// The headers with their folder, or the errors of the specification. The `compile_flags.txt` of the folder
/// is for clangd's `--compile-commands-dir`.
pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<UserResult<Value>> {
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
    let ignored = (output.join(".gitignore"), IGNORED.to_owned());
    let headers = files.into_iter().map(|file| (output.join(file.path), file.text));
    let mut files = Vec::new();
    for (path, text) in std::iter::once(ignored).chain(headers) {
        if let Some(uri) = snapshot.uri(&path) {
            files.push(json!({ "uri": uri, "text": text }));
        }
    }
    let folder = snapshot.uri(&output);
    Ok(UserResult(Ok(folder.map(|folder| json!({ "folder": folder, "files": files })))))
}
