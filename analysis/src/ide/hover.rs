//! What is under the cursor, in a few lines: declaration, type, value, documentation.

mod facts;
mod own;

use dotgen_syntax::{SyntaxKind, SyntaxNode, TextRange, preproc::MacroSite};

use super::{
    FileView, Hover, RangeInfo, SymbolKind,
    goto::value_type,
    render::{self, normalized, one_line},
    resolve::{Target, container_name, meanings_at},
};
use crate::{
    base::{SourceFile, lexed},
    elab::{DefId, DefKind, Definition, Elaborated, Entity},
    model::{Component, TypeKind},
    source_map::bytes,
    unit::define,
};

pub(crate) fn hover(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Hover>> {
    let (range, targets) = meanings_at(view, at)?;
    let mut parts: Vec<String> = Vec::new();
    let mut codels: Vec<(String, String)> = Vec::new();
    for target in &targets {
        if let Target::Definition(id) = target {
            codels.extend(codel(view.elaborated(), *id));
        }
        let part = match target {
            Target::Definition(id) => {
                own::completion(view, range, *id).or_else(|| definition(view, *id))
            }
            Target::Macro(name, site) => macro_hover(view, range, name, site.as_ref()),
            Target::File(file) => Some(format!("`{}`", file.path(view.db))),
        };
        parts.extend(part.filter(|it| !parts.contains(it)));
    }
    if parts.is_empty() {
        return None;
    }
    let mut markdown = parts.join("\n\n---\n\n");
    let unit = crate::unit::roots_of(view.db, view.file);
    if let Some(root) = unit.first().filter(|it| **it != view.file) {
        let name = root.path(view.db).file_name().unwrap_or_default();
        markdown += &format!("\n\n*as included by `{name}`*");
    }
    Some(RangeInfo {
        range: bytes(range),
        info: Hover { markdown, codels },
    })
}

/// The names of component and codel, if it is one.
fn codel(elaborated: &Elaborated, id: DefId) -> Option<(String, String)> {
    let it = elaborated.definitions.get(id.0 as usize)?;
    let component = facts::component_of(elaborated, it)?;
    let found = || (component.name.to_string(), it.name.to_string());
    (it.kind == DefKind::Codel).then(found)
}

pub(crate) fn definition(view: &FileView<'_>, id: DefId) -> Option<String> {
    let elaborated = view.elaborated();
    let it = elaborated.definitions.get(id.0 as usize)?;
    let mut out = code(&declaration_text(view, it)?);
    let mut facts: Vec<String> = Vec::new();
    if let Some(container) = container_name(&elaborated.definitions, it) {
        facts.push(format!("in `{container}`"));
    }
    facts.extend(type_facts(elaborated, it));
    if let Some(file) = elsewhere(view, it) {
        facts.push(format!("from `{file}`"));
    }
    if !facts.is_empty() {
        out += &format!("\n\n{}", facts.join(" · "));
    }
    if let Some(doc) = doc(elaborated, it) {
        out += &format!("\n\n{doc}");
    }
    if let Some(facts) = facts::facts(elaborated, it) {
        out += &format!("\n\n{facts}");
    }
    Some(out)
}

/// The declaration as written, in a standard layout.
fn declaration_text(view: &FileView<'_>, it: &Definition) -> Option<String> {
    let (file, range) = view.place(it.node)?;
    let there = &view_of(view, file)?;
    let kind = SymbolKind::from(it.kind);
    let node = node_at(there, range);
    let text = match (kind, node) {
        (SymbolKind::Component, _) => format!("component {} {{ … }};", it.name),
        (SymbolKind::Interface, _) => format!("interface {} {{ … }};", it.name),
        (SymbolKind::Module, _) => format!("module {} {{ … }};", it.name),
        (SymbolKind::State, _) => format!("state {}", it.name),
        (SymbolKind::Enumerator, _) => it.name.to_string(),
        (SymbolKind::Parameter, Some(node)) if node.kind() == SyntaxKind::NAME => {
            let param = node
                .ancestors()
                .find(|it| it.kind() == SyntaxKind::PATH_PARAM);
            one_line(there, &param.unwrap_or(node))
        }
        (SymbolKind::Codel, Some(node)) => {
            // With the word before it.
            let property = node.parent().filter(|it| {
                matches!(
                    it.kind(),
                    SyntaxKind::CODEL_PROPERTY | SyntaxKind::VALIDATE_PROPERTY
                )
            });
            normalized(there, &property.unwrap_or(node))
        }
        (_, Some(node)) => normalized(there, &node),
        (_, None) => it.name.to_string(),
    };
    Some(text)
}

/// A file as the unit of a view sees it.
fn view_of<'db>(view: &FileView<'db>, file: SourceFile) -> Option<FileView<'db>> {
    let key = match file == view.file {
        true => view.key,
        false => crate::unit::serving_visit(view.db, view.unit, file)?.1,
    };
    Some(FileView {
        db: view.db,
        file,
        unit: view.unit,
        key,
    })
}

/// The outermost node that covers exactly a range.
fn node_at(view: &FileView<'_>, range: TextRange) -> Option<SyntaxNode> {
    let root = view.root();
    if !root.text_range().contains_range(range) || range.is_empty() {
        return None;
    }
    let inner = root.covering_element(range);
    let inner = match inner {
        dotgen_syntax::SyntaxElement::Node(it) => it,
        dotgen_syntax::SyntaxElement::Token(it) => it.parent()?,
    };
    let same = inner
        .ancestors()
        .take_while(|it| it.parent().is_some() && view.node_range(it) == range);
    same.last().or_else(|| {
        // The tree has a node just around it (a body, say): show that.
        Some(inner).filter(|it| it.parent().is_some() && it.kind() != SyntaxKind::BODY)
    })
}

fn type_facts(elaborated: &Elaborated, it: &Definition) -> Vec<String> {
    let spec = &elaborated.spec;
    let Some(ty) = it.ty else {
        return Vec::new();
    };
    let mut out = Vec::new();
    let value_of = match it.kind {
        DefKind::Parameter | DefKind::CodelParameter | DefKind::Local => Some(ty),
        DefKind::Member
        | DefKind::IdsMember
        | DefKind::Const
        | DefKind::Port
        | DefKind::Typedef => value_type(spec, ty),
        DefKind::Struct | DefKind::Union | DefKind::Exception => Some(ty),
        _ => None,
    };
    if let Some(value) = value_of {
        let resolved = render::resolved_type_text(spec, value);
        let declares = matches!(
            it.kind,
            DefKind::Struct | DefKind::Union | DefKind::Exception
        );
        if let Some(resolved) = resolved.filter(|_| !declares) {
            out.push(format!("type `{resolved}`"));
        }
        if let Some(size) = render::packed_size(spec, value).filter(|_| it.kind != DefKind::Const) {
            out.push(format!(
                "{size} byte{} packed",
                if size == 1 { "" } else { "s" }
            ));
        }
    }
    match spec.types.get(ty.0 as usize).map(|it| &it.kind) {
        Some(TypeKind::Const { value, .. }) => {
            out.push(format!("value `{}`", render::value(spec, value)));
        }
        Some(TypeKind::Enumerator { enumeration, value }) => {
            let of = render::type_text(spec, *enumeration);
            out.push(format!("value {value} of enum `{of}`"));
        }
        _ => {}
    }
    out
}

fn doc(elaborated: &Elaborated, it: &Definition) -> Option<String> {
    let components = &elaborated.spec.components;
    let of = |c: u32| -> Option<&Component> { components.get(c as usize) };
    let doc = match it.entity? {
        Entity::Component(c) => of(c)?.doc.clone(),
        Entity::Task(c, i) => of(c)?.tasks.get(i as usize)?.doc.clone(),
        Entity::Port(c, i) => of(c)?.ports.get(i as usize)?.doc.clone(),
        Entity::Service(c, i) => of(c)?.services.get(i as usize)?.doc.clone(),
        Entity::Param(c, i, p) => {
            let service = of(c)?.services.get(i as usize)?;
            service.params.get(p as usize)?.init.as_ref()?.doc.clone()
        }
    };
    doc.filter(|it| !it.is_empty())
}

fn elsewhere(view: &FileView<'_>, it: &Definition) -> Option<String> {
    let (file, _) = view.place(it.src)?;
    if file == view.file {
        return None;
    }
    Some(file.path(view.db).file_name()?.to_owned())
}

fn macro_hover(
    view: &FileView<'_>,
    range: TextRange,
    name: &str,
    site: Option<&MacroSite>,
) -> Option<String> {
    let mut out = match site.and_then(|it| define_text(view, it)) {
        Some(definition) => code(&definition),
        None if site.is_some() => format!("macro `{name}` (predefined or from the command line)"),
        None => format!("`{name}` is not a macro here"),
    };
    if let Some(expansion) = expansion(view, range) {
        out += &format!("\n\nexpands to\n\n{}", code(&expansion));
    }
    Some(out)
}

fn define_text(view: &FileView<'_>, site: &MacroSite) -> Option<String> {
    let file = view
        .db
        .file(camino::Utf8Path::new(site.file.as_ref()?.as_str()));
    let definition = define(view.db, file, site.ordinal)?;
    let text = file.text(view.db);
    let raw = &lexed(view.db, file).raw;
    let mut out = format!("#define {}", definition.name?.text);
    if let Some(params) = &definition.params {
        let mut names: Vec<&str> = params.names.iter().map(|it| it.text.as_str()).collect();
        if params.variadic {
            names.push("...");
        }
        out += &format!("({})", names.join(", "));
    }
    let mut blank = true;
    for i in definition.body.clone() {
        if raw.kind(i as usize).is_trivia() {
            blank = true;
        } else {
            if std::mem::take(&mut blank) {
                out.push(' ');
            }
            out += raw.text(text, i as usize);
        }
    }
    Some(out)
}

/// What the macro call that begins with a name became.
pub(crate) fn expansion(view: &FileView<'_>, name: TextRange) -> Option<String> {
    let root = view.root();
    let token = root.token_at_offset(name.start()).right_biased()?;
    let call = token
        .parent_ancestors()
        .find(|it| it.kind() == SyntaxKind::MACRO_CALL)?;
    if call.text_range().start() != name.start() {
        return None;
    }
    let mut out = String::new();
    for token in view.map().expansion(call.text_range()) {
        if !out.is_empty() && !token.glued {
            out.push(' ');
        }
        out += &token.text;
        if out.len() > 2_000 {
            out.push('…');
            break;
        }
    }
    Some(out)
}

fn code(text: &str) -> String {
    // A fence longer than any in the text.
    let longest = text.split(|it| it != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest.max(2) + 1);
    format!("{fence}genom\n{text}\n{fence}")
}

#[cfg(test)]
mod tests {
    use expect_test::{Expect, expect};

    use crate::test_support::Fixture;

    #[track_caller]
    fn check(text: &str, expected: Expect) {
        let fixture = Fixture::new(text);
        let hover = fixture.analysis().hover(&fixture.at()).unwrap();
        let text = hover.map_or_else(String::new, |it| {
            let text = fixture.text(fixture.at().path.as_str());
            format!("[{}]\n{}\n", &text[it.range], it.info.markdown)
        });
        expected.assert_eq(&text);
    }

    #[test]
    fn types() {
        check(
            "module m { struct s { long x; double /* y */ y[3]; }; };\ntypedef m::s$0 t;\n",
            expect![[r#"
            [s]
            ```genom
            struct s {
              long x;
              double y[3];
            }
            ```

            in `m` · 28 bytes packed
        "#]],
        );
        check(
            "typedef sequence<string<8>, 4> t;\nstruct s { t$0 x; };\n",
            expect![[r#"
            [t]
            ```genom
            typedef sequence<string<8>, 4> t;
            ```

            type `sequence<string<8>, 4>`
        "#]],
        );
        check(
            "enum e { A, B };\nunion u switch (e) { case A: long a; default: float b; };\ntypedef u$0 t;\n",
            expect![[r#"
            [u]
            ```genom
            union u switch(e) {
              case A: long a;
              default: float b;
            }
            ```
        "#]],
        );
        check(
            "enum e { A, B };\nconst e x = B$0;\n",
            expect![[r#"
            [B]
            ```genom
            B
            ```

            in `e` · value 1 of enum `e`
        "#]],
        );
    }

    #[test]
    fn constants_have_values() {
        check(
            "const unsigned long n = 2 * 3;\ntypedef long a[n$0];\n",
            expect![[r#"
            [n]
            ```genom
            const unsigned long n = 2 * 3;
            ```

            type `unsigned long` · value `6`
        "#]],
        );
        check(
            "const double half = 1 / 2.0;\nconst double x = half$0;\n",
            expect![[r#"
            [half]
            ```genom
            const double half = 1 / 2.0;
            ```

            type `double` · value `0.5`
        "#]],
        );
        check(
            "const string s$0 = \"a\" \"b\";\n",
            expect![[r#"
            [s]
            ```genom
            const string s = "a" "b";
            ```

            type `string` · value `"ab"`
        "#]],
        );
    }

    #[test]
    fn declarations_of_components() {
        let text = r#"
struct st { long a, b; };
component c {
  doc "What it is.";
  ids { st v; };
  task t { doc "Main."; period 10ms; };
  port out st p { doc "Out."; };
  attribute set(in v.a = 3 : "the a");
  activity go(in long speed = 2 : "in m/s") {
    doc "Goes.";
    task t;
    codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
  };
};
"#;
        let at = |mark: &str| text.replacen(&mark.replace("$0", ""), mark, 1);
        check(
            &at("component c$0"),
            expect![[r#"
            [c]
            ```genom
            component c { … };
            ```

            What it is.
        "#]],
        );
        check(
            &at("task t$0 {"),
            expect![[r#"
                [t]
                ```genom
                task t {
                  doc "Main.";
                  period 10 ms;
                };
                ```

                in `c`

                Main.

                * runs `go`
            "#]],
        );
        check(
            &at("port out st p$0"),
            expect![[r#"
            [p]
            ```genom
            port out st p {
              doc "Out.";
            };
            ```

            in `c` · type `struct st (2 members)` · 8 bytes packed

            Out.
        "#]],
        );
        check(
            &at("attribute set$0"),
            expect![[r#"
                [set]
                ```genom
                attribute set(in v.a = 3 : "the a");
                ```

                in `c`
            "#]],
        );
        check(
            &at("activity go$0"),
            expect![[r#"
                [go]
                ```genom
                activity go(in long speed = 2 : "in m/s") {
                  doc "Goes.";
                  task t;
                  codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
                };
                ```

                in `c`

                Goes.
            "#]],
        );
        check(
            &at("local in speed$0"),
            expect![[r#"
            [speed]
            ```genom
            in long speed = 2: "in m/s"
            ```

            in `go` · type `long` · 4 bytes packed

            in m/s
        "#]],
        );
        check(
            &at("ids out v$0"),
            expect![[r#"
            [v]
            ```genom
            st v;
            ```

            in `ids` · type `struct st (2 members)` · 8 bytes packed
        "#]],
        );
        check(
            &at("begin$0"),
            expect![[r#"
                [begin]
                ```genom
                codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
                ```

                * activity `go`: called from the start, `begin`, after a pause
            "#]],
        );
        check(
            &at("<start$0"),
            expect![[r#"
                [start]
                ```genom
                state start
                ```

                in `c`

                * activity `go`: from `begin` → `begin` → `pause::start`, `ether`
            "#]],
        );
        check(
            &at("ids$0 {"),
            expect![[r#"
            [ids]
            ```genom
            ids {
              st v;
            };
            ```

            in `c`
        "#]],
        );
    }

    #[test]
    fn macros_and_includes() {
        check(
            "#define N  (4 /* four */ + 1)\ntypedef long a[N$0];\n",
            expect![[r#"
            [N]
            ```genom
            #define N (4 + 1)
            ```

            expands to

            ```genom
            (4 + 1)
            ```
        "#]],
        );
        check(
            "#define F(x, y) sequence<x, y>\ntypedef F$0(long, 3) a;\n",
            expect![[r#"
            [F]
            ```genom
            #define F(x, y) sequence<x, y>
            ```

            expands to

            ```genom
            sequence<long, 3>
            ```
        "#]],
        );
        check(
            "#if __GENOM__$0 > 1\n#endif\n",
            expect![[r#"
            [__GENOM__]
            macro `__GENOM__` (predefined or from the command line)
        "#]],
        );
        check(
            "//- /main.gen\n#include \"t$0.idl\"\n//- /t.idl\n",
            expect![[r#"
            [t.idl]
            `/t.idl`
        "#]],
        );
    }

    #[test]
    fn values_stay_on_their_line() {
        check(
            "struct p { long x; long y[2]; };\ncomponent c { ids { long a; }; function f$0(in p v={1,.y={[1]=2}}:\"where\",out long n) { codel g(out n); }; };\n",
            expect![[r#"
                [f]
                ```genom
                function f(in p v = { 1, .y = { [1] = 2 } } : "where", out long n) {
                  codel g(out n);
                };
                ```

                in `c`
            "#]],
        );
        check(
            "union u switch (long) { case 1: long x; };\ntypedef u$0 t;\n",
            expect![[r#"
                [u]
                ```genom
                union u switch(long) {
                  case 1: long x;
                }
                ```
            "#]],
        );
    }

    #[test]
    fn what_completes_an_interface_shows_itself() {
        let text = r#"
//- /i.gen
interface i {
  function halt() { doc "Stops."; };
  activity go(in long x);
  task t;
};
//- /main.gen
#include "i.gen"
component c {
  provides i;
  ids { long v; };
  task main { period 5 ms; };
  function halt() { doc "At once."; codel f(out v); interrupts go; };
  activity go(in long x) { task main; codel<start> g(in x) yield ether; };
};
component d { provides i; function other() { interrupts halt; }; };
"#;
        let at = |mark: &str| text.replacen(&mark.replace("$0", ""), mark, 1);
        check(
            &at("function halt$0() { doc \"At"),
            expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "At once.";
              codel f(out v);
              interrupts go;
            };
            ```

            in `c` · implements `halt` of the interface `i` from `i.gen`

            Stops.
            At once.
        "#]],
        );
        // Where the component uses it, too.
        check(
            &at("interrupts go$0"),
            expect![[r#"
            [go]
            ```genom
            activity go(in long x) {
              task main;
              codel<start> g(in x) yield ether;
            };
            ```

            in `c` · implements `go` of the interface `i` from `i.gen`

            * interrupted by `halt`
        "#]],
        );
        // A component that says nothing of its own has what the interface says.
        check(
            &at("interrupts halt$0"),
            expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "Stops.";
            };
            ```

            in `i` · from `i.gen`

            Stops.
        "#]],
        );
        check(
            &at("function halt$0() { doc \"Stops"),
            expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "Stops.";
            };
            ```

            in `i`

            Stops.

            *as included by `main.gen`*
        "#]],
        );
    }

    #[test]
    fn headers_name_the_unit_that_shows_them() {
        check(
            "//- /main.gen\n#include \"t.idl\"\n//- /t.idl\ntypedef long t$0;\n",
            expect![[r#"
                [t]
                ```genom
                typedef long t;
                ```

                type `long` · 4 bytes packed

                *as included by `main.gen`*
            "#]],
        );
    }
}
