//! Shared objects that a host can run: the codels of a component with their [`glue`].

use camino::Utf8Path;
use dotgen_analysis::model::{ComponentId, Name};
use rustc_hash::FxHashSet;

use super::build::{Build, Packages, Plan, Step, Tools};
use super::folder::Folder;
use super::links::implementations;
use super::stub::NewFile;
use super::{glue, headers};
use crate::lang::Language;

/// The shared object of one component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedObject {
    /// The component, among those of the specification.
    pub component: ComponentId,
    /// The glue, by absolute path.
    pub glue: NewFile,
    /// The step that compiles the glue.
    pub compile: Step,
    /// The step that links, after this one and all steps of the plan.
    pub link: Step,
    /// Codels that it lacks, because no source defines their functions.
    pub missing: FxHashSet<Name>,
}

/// The additional steps to a plan, for each component of its folder.
///
/// # Errors
/// A declaration of a component has no mapping to its language.
pub fn hosted(
    folder: &Folder,
    plan: &Plan,
    place: &Utf8Path,
    tools: &Tools,
    packages: &Packages,
) -> Result<Vec<SharedObject>, String> {
    let build = Build { place, codels: &folder.sources.folder, tools, packages };
    let all = folder.expected();
    let all = all.iter().map(|expected| {
        let functions = expected.functions.iter().map(|function| &function.name);
        let absent = |name: &&Name| implementations(&folder.sources, name).is_empty();
        let missing: FxHashSet<Name> = functions.filter(absent).cloned().collect();
        let text = glue::source(expected, &missing).map_err(|error| error.message)?;
        let name = &expected.component().name;
        let is_cxx = expected.language == Language::Cxx;
        let (compiler, extension) = if is_cxx { (&tools.cxx, "cc") } else { (&tools.c, "c") };
        let path = place.join(format!("{name}-glue.{extension}"));
        let mut command = compiler.clone();
        command.extend(headers::flags_of_names(expected));
        // A user cannot fix the causes of warnings in the glue.
        let compile = build.compile(path.clone(), &format!("{name}-glue"), command, &["-w"]);
        let mut inputs = plan.link.inputs.clone();
        inputs.push(compile.output.clone());
        let linker = if is_cxx {
            tools.cxx.clone()
        } else {
            let words = plan.link.command.iter();
            words.take_while(|word| *word != "-shared").cloned().collect()
        };
        Ok(SharedObject {
            component: expected.component,
            glue: NewFile { path, text },
            link: build.link(&format!("{name}-run"), linker, inputs, &["-lm", "-lpthread"]),
            compile,
            missing,
        })
    });
    all.collect()
}
