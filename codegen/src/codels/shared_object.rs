//! Shared objects that a host can run: the codels of a component with their [`glue`].

use camino::Utf8Path;
use dotgen_analysis::model::Name;
use rustc_hash::FxHashSet;

use super::build::{Packages, Plan, Step, Tools};
use super::folder::Folder;
use super::links::implementations;
use super::stub::NewFile;
use super::{glue, headers};
use crate::lang::Language;

/// The shared object of one component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedObject {
    /// The component, among those of the specification.
    pub component: u32,
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
        let object = place.join("objects").join(format!("{name}-glue.o"));
        let codels = &folder.sources.folder;
        let mut command = compiler.clone();
        command.extend(headers::flags_of_names(expected));
        // A user cannot fix the causes of warnings in the glue.
        let level = tools.optimization.flag();
        let flags = ["-c", "-fPIC", "-g", level, "-w", "-MMD", "-MF"];
        command.extend(flags.map(str::to_owned));
        command.push(format!("{object}.d"));
        command.extend(headers::include_flags(place, codels));
        command.extend(packages.compile.iter().cloned());
        command.extend(["-o".to_owned(), object.to_string(), path.to_string()]);
        let compile = Step {
            source: Some(path.clone()),
            inputs: vec![path.clone()],
            output: object.clone(),
            command,
        };
        let output = place.join(format!("{name}-run.so"));
        let mut inputs = plan.link.inputs.clone();
        inputs.push(object);
        let linker = if is_cxx {
            tools.cxx.clone()
        } else {
            let words = plan.link.command.iter();
            words.take_while(|word| *word != "-shared").cloned().collect()
        };
        let mut command: Vec<String> = linker;
        command.extend(["-shared", "-o", output.as_str()].map(str::to_owned));
        command.extend(inputs.iter().map(ToString::to_string));
        command.extend(packages.link.iter().cloned());
        command.extend(["-lm", "-lpthread"].map(str::to_owned));
        Ok(SharedObject {
            component: expected.component,
            glue: NewFile { path, text },
            link: Step { source: None, output, command, inputs },
            compile,
            missing,
        })
    });
    all.collect()
}
