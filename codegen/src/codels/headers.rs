//! The headers with which a C or C++ compiler reads codels without a build: the mapped types of the
//! component, minimal `genom3` headers, and the flags that find them (for clangd).
//!
//! The `genom3` headers declare the names that the C and C++ mappings use. They are written from the
//! description for dotgen, and replace an installation only in editors and tests.

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::FxHashSet;

use super::{
    expected::Expected,
    stub::{NewFile, types_header},
};
use crate::lang::{LangError, Language, MapObject, text};

/// The `genom3` headers, by path below an include directory.
pub const RUNTIME: [(&str, &str); 7] = [
    ("genom3/c/event.h", include_str!("headers/genom3/c/event.h")),
    ("genom3/c/context.h", include_str!("headers/genom3/c/context.h")),
    ("genom3/c/exception.h", include_str!("headers/genom3/c/exception.h")),
    ("genom3/c/idlsequence.h", include_str!("headers/genom3/c/idlsequence.h")),
    ("genom3/c++/event.h", include_str!("headers/genom3/c++/event.h")),
    ("genom3/c++/idlsequence.h", include_str!("headers/genom3/c++/idlsequence.h")),
    ("genom3/c++/idloptional.h", include_str!("headers/genom3/c++/idloptional.h")),
];

/// The flag with which C++ compilers accept `and`, `or` and similar words as names. Modules of GenoM3 may
/// have such names.
const CXX_NAMES: &str = "-fno-operator-names";

/// Words that are operators in C++.
const OPERATORS: [&str; 11] =
    ["and", "and_eq", "bitand", "bitor", "compl", "not", "not_eq", "or", "or_eq", "xor", "xor_eq"];

/// Flags for compilers of C++, if a type of the component has a name that is an operator there.
pub(super) fn flags_of_names(expected: &Expected<'_>) -> Option<String> {
    let spec = expected.spec;
    let mut names = spec.types.keys().filter_map(|ty| spec.full_name(ty));
    let is_operator = |text: &str| text.split("::").any(|part| OPERATORS.contains(&part));
    let found = names.any(|name| is_operator(&name));
    (found && expected.language == Language::Cxx).then(|| CXX_NAMES.to_owned())
}

/// Name of the folder with the `genom3` headers.
const INCLUDE: &str = "include";

/// The headers of a component and `compile_flags.txt`, by path below `folder` (the absolute path of their
/// destination). `flags` are further flags of the compiler, such as those of required packages.
pub fn headers(
    expected: &Expected<'_>,
    folder: &Utf8Path,
    codels: &Utf8Path,
    flags: &[String],
) -> Result<Vec<NewFile>, LangError> {
    let component = expected.component();
    let mut out: Vec<NewFile> = RUNTIME
        .iter()
        .map(|(path, text)| NewFile {
            path: Utf8PathBuf::from(INCLUDE).join(path),
            text: (*text).to_owned(),
        })
        .collect();
    out.push(NewFile { path: types_header(expected).into(), text: types(expected)? });
    out.push(NewFile {
        path: format!("ac{}.h", component.name).into(),
        text: configuration(expected),
    });
    let mut lines = include_flags(folder, codels);
    lines.extend(flags_of_names(expected));
    lines.extend(flags.iter().cloned());
    out.push(NewFile { path: "compile_flags.txt".into(), text: lines.join("\n") + "\n" });
    Ok(out)
}

/// The flags by which compilers find the headers of a folder, and those next to the codels.
pub(super) fn include_flags(folder: &Utf8Path, codels: &Utf8Path) -> Vec<String> {
    let mut out =
        vec![format!("-I{}", folder.join(INCLUDE)), format!("-I{folder}"), format!("-I{codels}")];
    out.extend(codels.parent().map(|root| format!("-I{root}")));
    out
}

/// The mapped types and the prototypes of the codels, as in `genom3 mappings --signature` without the `#line`
/// marks.
pub fn types(expected: &Expected<'_>) -> Result<String, LangError> {
    let all = expected.spec.types.keys().map(MapObject::Type);
    let all: Vec<MapObject> = all.collect();
    let mut out = opaque_types(expected) + &expected.mapper().mapping(&all, false)?;
    // The mapping includes the headers for its own text; the prototypes may need more.
    let runtime: &[&str] = match expected.language {
        Language::Cxx => &[
            "<cerrno>",
            "<cstdint>",
            "<string>",
            "<vector>",
            "\"genom3/c++/event.h\"",
            "\"genom3/c++/idlsequence.h\"",
            "\"genom3/c++/idloptional.h\"",
        ],
        _ => &["<errno.h>", "<stdbool.h>", "<stdint.h>", "\"genom3/c/exception.h\""],
    };
    out.push('\n');
    for header in runtime {
        out += &format!("#include {header}\n");
    }
    let mut prototypes = String::new();
    for function in &expected.functions {
        let signature = function.signature.as_ref();
        let signature = signature.map_err(|error| LangError::error(error.clone()))?;
        prototypes += &format!("{signature};\n");
    }
    out += &match expected.language {
        Language::Cxx => format!("\n{prototypes}"),
        _ => format!(
            "\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n{prototypes}#ifdef __cplusplus\n}}\n#endif\n"
        ),
    };
    Ok(out)
}

/// Declarations of the types whose definition is unknown. They have a body, because other types have members
/// of them.
fn opaque_types(expected: &Expected<'_>) -> String {
    let spec = expected.spec;
    let mapper = expected.mapper();
    let mut seen = FxHashSet::default();
    let mut out = String::new();
    for id in spec.types.keys() {
        let Some(opaque) = spec.opaque(id) else {
            continue;
        };
        let ty = spec.ty(opaque);
        let Ok(name) = mapper.opaque_name(opaque) else {
            continue;
        };
        if expected.has_type(&name) || !seen.insert(name.clone()) {
            continue;
        }
        let guard = text::c_name(&name);
        let said = match (&ty.name, spec.full_name(opaque)) {
            (Some(_), Some(full)) => full.trim_start_matches("::").to_owned(),
            _ => "a type".to_owned(),
        };
        let comment = format!(
            "/* opaque: `{said}` is not declared in any file that was found; see `dotgen deps` */"
        );
        let body = match expected.language {
            Language::Cxx => {
                let modules = ty.scope.iter().filter(|_| ty.name.is_some());
                let modules: Vec<&str> = modules.map(|module| module.name.as_str()).collect();
                let open: String =
                    modules.iter().map(|module| format!("namespace {module} {{ ")).collect();
                let close = " }".repeat(modules.len());
                let own = ty.name.as_deref().unwrap_or(&name);
                format!("{open}struct {own} {{ char opaque; }};{close}")
            }
            _ => format!("typedef struct {name} {{ char opaque; }} {name};"),
        };
        out += &format!(
            "#ifndef _{guard}_c_type\n# define _{guard}_c_type\n{comment}\n{body}\n#endif\n"
        );
    }
    out
}

/// The text that `configure` would write: the identity of the package.
fn configuration(expected: &Expected<'_>) -> String {
    let component = expected.component();
    let name = &component.name;
    let version = component.version.as_deref().unwrap_or("0");
    let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
    let mut out = String::from("/* Written by dotgen in place of the header of configure. */\n");
    let defines = [
        ("PACKAGE", name.as_str()),
        ("PACKAGE_NAME", name.as_str()),
        ("PACKAGE_VERSION", version),
        ("VERSION", version),
    ];
    for (define, value) in defines {
        out += &format!("#ifndef {define}\n# define {define} {}\n#endif\n", quoted(value));
    }
    out
}
