//! Whole components with codels that the tests write for them: what published components have no copy of
//! here.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{AnalysisHost, Change, Config};
use dotgen_analysis::model::{ParamDir, Spec, TypeId, TypeKind};
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::Files;
use dotgen_codegen::codels::stub::{StubOptions, Stubs};
use dotgen_codegen::lang::{Language, PassingMode, param_types};

use crate::codels::support::{shared, workspace};

/// Texts in the place of files, over the disk if wanted.
#[derive(Debug, Clone)]
pub(crate) struct Overlay {
    pub(crate) texts: BTreeMap<Utf8PathBuf, String>,
    pub(crate) disk: bool,
}

impl Default for Overlay {
    fn default() -> Overlay {
        Overlay { texts: BTreeMap::new(), disk: true }
    }
}

impl Files for Overlay {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        match self.texts.get(path) {
            Some(text) => Some(text.as_str().into()),
            None if self.disk => std::fs::read_to_string(path).ok().map(Arc::from),
            None => None,
        }
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let below = self.texts.keys().filter_map(|key| key.strip_prefix(folder).ok());
        let mut out: Vec<Utf8PathBuf> = below.map(Utf8Path::to_owned).collect();
        if self.disk
            && let Ok(entries) = folder.read_dir_utf8()
        {
            out.extend(entries.flatten().map(|entry| Utf8PathBuf::from(entry.file_name())));
            return Some(out);
        }
        (!out.is_empty()).then_some(out)
    }
}

/// A host over some texts.
pub(crate) fn host_over(files: Arc<Overlay>, include_dirs: Vec<Utf8PathBuf>) -> AnalysisHost {
    let mut host = AnalysisHost::new(files);
    let config = Config { include_dirs, ..Config::default() };
    host.apply(Change { config: Some(config), ..Change::default() });
    host
}

/// Specifications below a folder, each with the folders that its includes are found in.
fn specifications(folder: &Utf8Path, more: &[Utf8PathBuf]) -> Vec<(Utf8PathBuf, Vec<Utf8PathBuf>)> {
    let mut out = Vec::new();
    let walk = walkdir::WalkDir::new(folder).sort_by_file_name();
    for entry in walk.into_iter().flatten() {
        let Ok(path) = Utf8PathBuf::from_path_buf(entry.into_path()) else {
            continue;
        };
        if path.extension() == Some("gen") {
            let around: Vec<&Utf8Path> = path.ancestors().skip(1).take(2).collect();
            let own = around.iter().flat_map(|ancestor| {
                [ancestor.to_path_buf(), ancestor.join("idl"), ancestor.join("include")]
            });
            let includes = own.chain(more.iter().cloned()).collect();
            out.push((path, includes));
        }
    }
    out
}

/// The examples of the project.
pub(crate) fn examples() -> Vec<(Utf8PathBuf, Vec<Utf8PathBuf>)> {
    specifications(&workspace().join("examples"), &[])
}

/// Published components, where they lie beside the project.
pub(crate) fn published() -> Vec<(Utf8PathBuf, Vec<Utf8PathBuf>)> {
    let Some(shared) = shared() else {
        return Vec::new();
    };
    let corpus = shared.join("corpus/components");
    let mut all = specifications(&corpus, &[corpus.join("standins")]);
    all.retain(|specification| !specification.0.starts_with(corpus.join("standins")));
    all
}

/// The sources of a component, by name: the stubs of the skeleton, whose bodies read every member of
/// what they are given and mention every event that they may return.
pub(crate) fn codels(expected: &Expected<'_>) -> BTreeMap<Utf8PathBuf, String> {
    let options = StubOptions {
        use_parameters: true,
        compile_as_cxx: expected.language == Language::Cxx,
        ..StubOptions::default()
    };
    let stubs = Stubs::new(expected, &options);
    let Ok(files) = stubs.all_files() else {
        return BTreeMap::new();
    };
    let mut out = BTreeMap::new();
    for file in files {
        let mut text = file.text;
        for function in &expected.functions {
            let Some(&at) = function.uses.first() else {
                continue;
            };
            let codel = expected.component().codel(at);
            let Ok(stub) = stubs.function(at) else {
                continue;
            };
            let mut body = String::new();
            for param in &codel.params {
                let ty = param_types(expected.spec, expected.component, param).1;
                let passing = match param.dir {
                    ParamDir::Out | ParamDir::Inout => PassingMode::Reference,
                    _ => PassingMode::Value,
                };
                let Ok(value) = expected.mapper().dereference(ty, passing, &param.name) else {
                    continue;
                };
                for member in members(expected, ty) {
                    body += &format!("  (void)(({value}){member});\n");
                }
            }
            for state in &codel.yields {
                body += &format!("  if (0) return {};\n", expected.spelling(state.event));
            }
            for exception in expected.throws_of(at.owner) {
                body += &raised(expected, exception);
            }
            let written = stub.replacen(
                "  /* skeleton sample: insert your code */\n",
                &format!("  /* written by a test */\n{body}"),
                1,
            );
            text = text.replacen(&stub, &written, 1);
        }
        if out.is_empty() {
            text += &reader(expected);
        }
        let name = file.path.file_name().unwrap_or_default();
        out.insert(name.into(), text);
    }
    out
}

/// A statement that raises an exception.
fn raised(expected: &Expected<'_>, exception: TypeId) -> String {
    let name = expected.spelling(exception);
    let members = match &expected.spec.ty(exception).kind {
        TypeKind::Exception { members } => members.as_slice(),
        _ => return String::new(),
    };
    match expected.language {
        Language::Cxx => format!("  if (0) throw {name}();\n"),
        _ if members.is_empty() => format!("  if (0) return {name}(self);\n"),
        _ => format!("  if (0) {{ {name}_detail d; return {name}(&d, self); }}\n"),
    }
}

/// A function that reads every member of the `ids`.
fn reader(expected: &Expected<'_>) -> String {
    let Some(ids) = expected.component().ids else {
        return String::new();
    };
    let ty = expected.spelling(ids);
    let (parameter, arrow) = match expected.language {
        Language::Cxx => (format!("const {ty} &all"), "all"),
        _ => (format!("const {ty} *all"), "(*all)"),
    };
    let mut out = format!("\nvoid read_all({parameter});\nvoid read_all({parameter})\n{{\n");
    for member in members(expected, ids) {
        out += &format!("  (void)({arrow}{member});\n");
    }
    out + "}\n"
}

/// How the members of a value are reached, two levels deep.
fn members(expected: &Expected<'_>, ty: TypeId) -> Vec<String> {
    let names = |ty: TypeId| -> Vec<(String, TypeId)> {
        let spec: &Spec = expected.spec;
        match &spec.ty(spec.resolve_alias(ty)).kind {
            TypeKind::Struct { members } => {
                let all = members.iter().filter_map(|&member| {
                    let name = spec.ty(member).name.as_ref()?;
                    let TypeKind::StructMember { ty } = spec.ty(member).kind else {
                        return None;
                    };
                    Some((format!(".{name}"), ty))
                });
                all.collect()
            }
            _ => Vec::new(),
        }
    };
    let mut out = Vec::new();
    for (path, ty) in names(ty) {
        out.extend(names(ty).into_iter().map(|name| format!("{path}{}", name.0)));
        out.push(path);
    }
    out
}
