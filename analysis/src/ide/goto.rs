//! From a name to its declaration, its definition or its type.

use dotgen_syntax::TextRange;

use super::{
    FileView, NavTarget, RangeInfo, call_hierarchy,
    resolve::{Target, definition_target, meanings_at, nav_target},
    view::place,
};
use crate::{
    elab::{DefId, DefKind},
    model::{Spec, TypeId, TypeKind},
    source_map::bytes,
};

/// The definition of the name under the cursor.
pub(crate) fn definition(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Vec<NavTarget>>> {
    let (range, targets) = meanings_at(view, at)?;
    let states = state_targets(view, at, &targets);
    if !states.is_empty() {
        return answer(range, states);
    }
    let found = targets.iter().filter_map(|target| nav_target(view, target));
    answer(range, found.collect())
}

/// The codels of the same task or service that the state under the cursor is bound to. All mentions of a
/// state have one definition, the first.
fn state_targets(view: &FileView<'_>, at: usize, targets: &[Target]) -> Vec<NavTarget> {
    let elaborated = view.elaborated();
    let is_state = |target: &Target| match target {
        Target::Definition(id) => elaborated.definition(*id).kind == DefKind::State,
        _ => false,
    };
    if !targets.iter().any(is_state) {
        return Vec::new();
    }
    let states = call_hierarchy::prepare(view, at).unwrap_or_default();
    let states = states.into_iter().map(|state| NavTarget {
        path: state.path,
        full_range: state.range.clone(),
        focus_range: state.range,
        name: state.name.into(),
        kind: state.kind,
        container: Some(state.key.owner),
    });
    states.collect()
}

/// The first declaration of the name under the cursor: its earliest mention that declares it.
pub(crate) fn declaration(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Vec<NavTarget>>> {
    let (range, targets) = meanings_at(view, at)?;
    let found = targets.iter().filter_map(|target| match target {
        Target::Definition(id) => first_declaration(view, *id),
        _ => nav_target(view, target),
    });
    answer(range, found.collect())
}

/// The definition of the type of the name under the cursor; for a type, its target.
pub(crate) fn type_definition(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Vec<NavTarget>>> {
    let (range, targets) = meanings_at(view, at)?;
    let elaborated = view.elaborated();
    let found = targets.iter().filter_map(|target| match target {
        Target::Definition(id) => {
            let definition = elaborated.definition(*id);
            let ty = definition.ty?;
            let spec = &elaborated.spec;
            let ty = match definition.kind {
                DefKind::Parameter | DefKind::CodelParameter | DefKind::Local => ty,
                _ => value_type(spec, ty)?,
            };
            type_target(view, named_type(spec, ty)?)
        }
        _ => None,
    });
    answer(range, found.collect())
}

fn answer(range: TextRange, mut info: Vec<NavTarget>) -> Option<RangeInfo<Vec<NavTarget>>> {
    let mut kept: Vec<NavTarget> = Vec::new();
    info.retain(|target| {
        let new = !kept.contains(target);
        if new {
            kept.push(target.clone());
        }
        new
    });
    (!info.is_empty()).then(|| RangeInfo { range: bytes(range), info })
}

fn first_declaration(view: &FileView<'_>, id: DefId) -> Option<NavTarget> {
    let target = definition_target(view.db, view.unit, id)?;
    let definition = view.elaborated().definition(id);
    let declarations = view.elaborated().references.iter();
    let first = declarations
        .filter(|declaration| declaration.is_declaration() && declaration.target == id)
        .map(|declaration| declaration.at)
        .chain(std::iter::once(definition.src))
        .min_by_key(|declaration| (declaration.visit, declaration.item, declaration.node))?;
    if first == definition.src {
        return Some(target);
    }
    let (file, range) = place(view.db, view.unit, first)?;
    Some(NavTarget {
        path: file.path(view.db).clone(),
        full_range: bytes(range),
        focus_range: bytes(range),
        ..target
    })
}

/// The type of a type object, or the type it stands for.
pub(super) fn value_type(spec: &Spec, id: TypeId) -> Option<TypeId> {
    Some(match &spec.types.get(id)?.kind {
        TypeKind::StructMember { ty }
        | TypeKind::UnionMember { ty, .. }
        | TypeKind::Const { ty, .. }
        | TypeKind::Typedef { ty } => *ty,
        TypeKind::Enumerator { enumeration, .. } => *enumeration,
        TypeKind::Port { component, port } => {
            let component = spec.components.get(*component)?;
            component.ports.get(*port)?.data
        }
        TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
            (*definition)?
        }
        _ => id,
    })
}

/// The named type inside arrays, sequences and optionals.
fn named_type(spec: &Spec, mut id: TypeId) -> Option<TypeId> {
    for _ in 0..spec.types.len() {
        let ty = spec.types.get(id)?;
        id = match &ty.kind {
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => *element,
            TypeKind::ForwardStruct { definition: Some(definition) }
            | TypeKind::ForwardUnion { definition: Some(definition) } => *definition,
            _ => return ty.name.is_some().then_some(id),
        };
    }
    None
}

fn type_target(view: &FileView<'_>, ty: TypeId) -> Option<NavTarget> {
    let elaborated = view.elaborated();
    let src = elaborated.spec.types.get(ty)?.src;
    let mut candidates = elaborated.definitions.iter();
    let definition = candidates
        .find(|candidate| candidate.ty == Some(ty) && candidate.src == src)
        .or_else(|| {
            elaborated
                .definitions
                .iter()
                .find(|definition| definition.ty == Some(ty) && is_type(definition.kind))
        })?;
    definition_target(view.db, view.unit, definition.id)
}

fn is_type(kind: DefKind) -> bool {
    matches!(
        kind,
        DefKind::Typedef
            | DefKind::Struct
            | DefKind::Union
            | DefKind::Enum
            | DefKind::Exception
            | DefKind::Native
            | DefKind::Ids
    )
}

#[cfg(test)]
mod tests {
    use crate::{
        host::{Analysis, Cancellable},
        ide::{FilePosition, NavTarget, RangeInfo},
        test_support::{Fixture, annotations},
    };

    type Goto = fn(&Analysis, &FilePosition) -> Cancellable<Option<RangeInfo<Vec<NavTarget>>>>;

    /// Checks that the targets are exactly the marked places.
    #[track_caller]
    fn check(goto: Goto, text: &str) {
        let fixture = Fixture::new(text);
        let found = goto(&fixture.analysis(), &fixture.at()).unwrap();
        let mut found: Vec<String> = found
            .map_or_else(Vec::new, |range_info| range_info.info)
            .iter()
            .map(|target| {
                assert!(target.full_range.start <= target.focus_range.start, "{target:?}");
                assert!(target.focus_range.end <= target.full_range.end, "{target:?}");
                format!("{}:{:?}", target.path, target.focus_range)
            })
            .collect();
        found.sort();
        let mut wanted = Vec::new();
        for path in fixture.paths() {
            for (range, _) in annotations(&fixture.text(path.as_str())) {
                wanted.push(format!("{path}:{range:?}"));
            }
        }
        assert_eq!(found, wanted, "{}", fixture.all_diagnostics());
    }

    #[track_caller]
    fn definition(text: &str) {
        check(Analysis::goto_definition, text);
    }

    #[test]
    fn types_constants_and_enumerators() {
        definition("typedef long t;\n//           ^\ntypedef t$0 u;\n");
        definition("const long n = 2;\n//         ^\ntypedef long a[n$0];\n");
        definition("enum e { A, B };\n//          ^\nconst e x = B$0;\n");
        definition("module m { struct s { long x; }; };\n//                ^\ntypedef m::s$0 t;\n");
        definition("module m { struct s { long x; }; };\n//     ^\ntypedef m$0::s t;\n");
    }

    #[test]
    fn through_includes() {
        definition(
            "//- /main.gen
#include \"t.idl\"
typedef m::t$0 u;
//- /t.idl
module m {
  typedef long t;
  //           ^
};
",
        );
    }

    #[test]
    fn include_paths() {
        let fixture = Fixture::new("//- /main.gen\n#include \"t$0.idl\"\n//- /t.idl\n");
        let found = fixture.analysis().goto_definition(&fixture.at()).unwrap().unwrap();
        assert_eq!(found.range, 10..15);
        assert_eq!(found.info[0].path, "/t.idl");
    }

    #[test]
    fn macros() {
        definition("#define N 4\n//      ^\ntypedef long a[N$0];\n");
        definition("#define F(x) x\n//      ^\ntypedef long a[F$0(3)];\n");
        definition("#define N 4\n//      ^\n#ifdef N$0\n#endif\n");
        definition(
            "//- /main.gen\n#include \"m.idl\"\ntypedef long a[N$0];\n//- /m.idl\n#define N 4\n//      ^\n",
        );
    }

    #[test]
    fn arguments_of_macro_calls() {
        definition(
            "typedef long t;
//           ^
#define SEQ(x) sequence<x>
typedef SEQ(t$0) u;
",
        );
        // A name that only the macro contains is at its call.
        definition(
            "typedef long t;
//           ^
#define T t, 3
#define SEQ(x) sequence<T>
typedef SEQ($0) u;
",
        );
    }

    const COMPONENT: &str = "
exception e;
struct s { long x, y; };
interface i { function f(in long a); port out s q; };
component c {
  uses i;
  ids { s v; };
  task t { period 1 ms; };
  port in s p;
  attribute setx(in v.x = 0);
  activity go(in long speed) {
    task t;
    throws e;
    local s tmp;
    validate check(in speed);
    codel<start> begin(ids in v.y, local in speed, local out tmp, port in p) yield step;
    codel<step> again(remote in f, port out q) yield ether;
    interrupts go;
  };
};
";

    #[track_caller]
    fn in_component(use_: &str, declaration: &str) {
        let text = COMPONENT.replace(&use_.replace("$0", ""), use_);
        assert_eq!(text.matches("$0").count(), 1, "{use_}");
        let fixture = Fixture::new(&text);
        let found = fixture.analysis().goto_definition(&fixture.at()).unwrap();
        let found = found.unwrap_or_else(|| panic!("nothing at `{use_}`"));
        let text = fixture.text("/main.gen");
        let start = text.find(declaration).expect("the declaration is there");
        let places: Vec<_> = found.info.iter().map(|target| target.focus_range.clone()).collect();
        let inside = |range: &std::ops::Range<usize>| {
            start <= range.start && range.end <= start + declaration.len()
        };
        assert!(places.iter().any(inside), "`{use_}`: {:?}", found.info);
    }

    #[test]
    fn every_kind_of_name_in_a_component() {
        in_component("uses i$0;", "interface i");
        in_component("task t$0;\n    throws", "task t { period");
        in_component("throws e$0", "exception e");
        in_component("local s$0", "struct s");
        in_component("check(in speed$0", "in long speed");
        in_component("ids in v$0.", "s v;");
        in_component("ids in v.y$0", "x, y");
        in_component("local in speed$0", "in long speed");
        in_component("local out tmp$0", "local s tmp");
        in_component("port in p$0)", "port in s p");
        in_component("remote in f$0", "function f");
        in_component("port out q$0", "port out s q");
        in_component("interrupts go$0", "activity go");
        in_component("codel<step$0>", "codel<step>");
        in_component("yield step$0", "codel<step>");
        in_component("(in v.x$0", "x, y");
    }

    #[test]
    fn declarations_and_types() {
        check(
            Analysis::goto_declaration,
            "struct s;\n//     ^\nstruct s { long x; };\ntypedef s$0 t;\n",
        );
        definition("struct s;\nstruct s { long x; };\n//     ^\ntypedef s$0 t;\n");
        let ty: Goto = Analysis::goto_type_definition;
        check(ty, "typedef long t;\n//           ^\nstruct s { t x$0; };\n");
        check(ty, "struct s { long x; };\n//     ^\nstruct u { sequence<s> x$0; };\n");
        check(ty, "struct s { long x; };\n//     ^\ncomponent c { port in s p$0; };\n");
        check(ty, "enum e { A };\n//   ^\nconst e x$0 = A;\n");
        check(ty, "const long x$0 = 1;\n");
    }

    #[test]
    fn arguments_of_pragmas() {
        definition("interface i { };\n//        ^\n#pragma provides i$0\ncomponent c;\n");
        definition(
            "module m { struct s { long x; }; };
//                ^
#pragma masquerade t m::s$0 \"x\"
",
        );
        definition(
            "#pragma wcet f$0 3 ms
component c {
  task t {
    codel<start> f() yield ether;
    //           ^
  };
};
",
        );
    }

    #[test]
    fn nothing_on_keywords_and_blanks() {
        definition("type$0def long t;\n");
        definition("typedef long t;\n$0\n");
    }
}
