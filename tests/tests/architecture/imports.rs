//! Which module of a crate imports which, read from its sources, and the circles among them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module by its path below the crate; the crate itself is empty.
type Module = Vec<String>;

/// The modules of a crate with what they import.
#[derive(Default)]
pub(crate) struct Imports {
    /// What each module names in `use` and in paths, absolute below the crate.
    named: BTreeMap<Module, Vec<Module>>,
    /// What each module calls by a name of its own: the names of its `use`.
    aliases: BTreeMap<Module, BTreeMap<String, Module>>,
}

impl Imports {
    /// Of the crate in a folder. Modules of tests are left out.
    pub(crate) fn of(folder: &Path) -> Imports {
        let source = folder.join("src");
        let mut texts = BTreeMap::new();
        for entry in walkdir::WalkDir::new(&source).into_iter().flatten() {
            let path = entry.path().strip_prefix(&source).expect("below it");
            let Some(name) = path.to_str().and_then(|text| text.strip_suffix(".rs")) else {
                continue;
            };
            let mut module: Module = name.split(['/', '\\']).map(str::to_owned).collect();
            if matches!(name, "lib" | "main") {
                module.clear();
            }
            let of_tests = |text: &String| {
                matches!(text.as_str(), "tests" | "fixture" | "generator" | "test_support")
            };
            if !module.iter().any(of_tests) {
                let text = std::fs::read_to_string(entry.path()).expect("UTF-8");
                *texts.entry(module).or_insert_with(String::new) += &text;
            }
        }
        assert!(!texts.is_empty(), "no sources in {}", folder.display());
        Imports::read(&texts)
    }

    /// Of the texts of the modules of a crate.
    pub(crate) fn read(texts: &BTreeMap<Module, String>) -> Imports {
        let mut out = Imports::default();
        for module in texts.keys() {
            out.named.insert(module.clone(), Vec::new());
        }
        for (module, text) in texts {
            let code = code(text);
            let (uses, rest) = uses(&code);
            let mut named = Vec::new();
            let mut aliases = BTreeMap::new();
            for (path, alias) in uses {
                if let Some(path) = out.absolute(module, &path) {
                    aliases.insert(alias, path.clone());
                    named.push(path);
                }
            }
            named.extend(paths(&rest).filter_map(|path| out.absolute(module, &path)));
            out.named.insert(module.clone(), named);
            out.aliases.insert(module.clone(), aliases);
        }
        out
    }

    /// A path as the crate sees it; `None` for one of another crate.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Module> {
        let mut at = module.to_vec();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => {
                at.clear();
                rest = &rest[1..];
            }
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|path| path == "super") {
                    at.pop();
                    rest = &rest[1..];
                }
            }
            first => {
                let child = [module, &[first.to_owned()]].concat();
                if !self.named.contains_key(&child) {
                    return None;
                }
            }
        }
        at.extend(rest.iter().cloned());
        Some(at)
    }

    /// The module in which something is declared: what a module only passes on is looked for where it comes
    /// from.
    fn home(&self, path: &[String]) -> Module {
        let mut path = path.to_vec();
        // A name that is passed on in a circle has no home.
        for _ in 0..8 {
            let mut length = path.len();
            while !self.named.contains_key(&path[..length]) {
                length -= 1;
            }
            let passed = path.get(length).and_then(|name| {
                let aliases = self.aliases.get(&path[..length])?;
                aliases.get(name).filter(|alias| alias[..] != path[..=length])
            });
            match passed {
                Some(to) => path = [&to[..], &path[length + 1..]].concat(),
                None => return path[..length].to_vec(),
            }
        }
        Module::new()
    }

    /// The imports that tie the modules of a circle together, one in a line: who names what.
    pub(crate) fn ties(&self, folder: &str, circle: &BTreeSet<String>) -> Vec<String> {
        let folder: Module = match folder {
            "" => Module::new(),
            folder => folder.split("::").map(str::to_owned).collect(),
        };
        let mut out = BTreeSet::new();
        for (module, named) in &self.named {
            for path in named {
                let home = self.home(path);
                let in_circle = |names: &[String]| {
                    names.strip_prefix(&folder[..]).and_then(|rest| circle.get(rest.first()?))
                };
                let (from, to) = (in_circle(module), in_circle(&home));
                if from.is_some() && to.is_some() && from != to {
                    out.insert(format!("{} -> {}", module.join("::"), path.join("::")));
                }
            }
        }
        out.into_iter().collect()
    }

    /// The circles: modules of one folder that import each other, they or what is below them. An import
    /// between a module and what is below it is none.
    pub(crate) fn circles(&self) -> Vec<(String, BTreeSet<String>)> {
        type Graph = BTreeMap<String, BTreeSet<String>>;
        let mut folders: BTreeMap<Module, Graph> = BTreeMap::new();
        for (module, named) in &self.named {
            for path in named {
                let home = self.home(path);
                let common = std::iter::zip(module, &home).take_while(|(a, b)| a == b).count();
                if let (Some(from), Some(to)) = (module.get(common), home.get(common)) {
                    let graph = folders.entry(module[..common].to_vec()).or_default();
                    graph.entry(from.clone()).or_default().insert(to.clone());
                }
            }
        }
        let mut out = Vec::new();
        for (folder, graph) in folders {
            let mut seen: BTreeSet<&String> = BTreeSet::new();
            for start in graph.keys() {
                let forth = reached(&graph, start);
                let circle: BTreeSet<String> = forth
                    .into_iter()
                    .filter(|text| reached(&graph, text).contains(start))
                    .cloned()
                    .collect();
                if circle.contains(start) && seen.insert(start) {
                    let known = |pair: &(String, BTreeSet<String>)| {
                        pair.0 == folder.join("::") && pair.1 == circle
                    };
                    if !out.iter().any(known) {
                        out.push((folder.join("::"), circle));
                    }
                }
            }
        }
        out
    }
}

/// Modules of TypeScript that import each other in a circle, each with what it imports.
pub(crate) fn script_import_cycles(folder: &Path) -> Vec<(String, BTreeSet<String>)> {
    let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for entry in walkdir::WalkDir::new(folder).into_iter().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|extension| extension != "ts") {
            continue;
        }
        let text = std::fs::read_to_string(path).expect("UTF-8");
        let directory = path.parent().unwrap_or(folder);
        let imports = text.split(" from './").skip(1).map(|part| (directory, part));
        let above = directory.parent().unwrap_or(folder);
        let above = text.split(" from '../").skip(1).map(|part| (above, part));
        let named = imports.chain(above).filter_map(|(directory, rest)| {
            let (name, _) = rest.split_once('\'')?;
            let file = directory.join(format!("{name}.ts"));
            Some(file.strip_prefix(folder).ok()?.display().to_string())
        });
        let own = path.strip_prefix(folder).expect("below it");
        graph.insert(own.display().to_string(), named.collect());
    }
    assert!(!graph.is_empty(), "no scripts in {}", folder.display());
    let in_circle = |text: &&String| reached(&graph, text).contains(text);
    let names = graph.keys().filter(in_circle);
    names.map(|name| (name.clone(), graph[name].clone())).collect()
}

/// What can be reached from a node by at least one arrow.
fn reached<'g>(graph: &'g BTreeMap<String, BTreeSet<String>>, from: &str) -> BTreeSet<&'g String> {
    let mut out = BTreeSet::new();
    let mut waiting: Vec<&String> = graph.get(from).into_iter().flatten().collect();
    while let Some(node) = waiting.pop() {
        if out.insert(node) {
            waiting.extend(graph.get(node).into_iter().flatten());
        }
    }
    out
}

/// A source without comments, without its tests, and without what stands in strings.
fn code(text: &str) -> String {
    let mut out = String::new();
    let mut tests = false;
    for line in text.lines() {
        // A declaration of a module of tests ends nothing.
        if tests && !line.trim_start().starts_with("mod ") {
            out.push('\n');
        } else if tests && !line.trim_end().ends_with(';') {
            break;
        }
        let attribute = line.trim() == "#[cfg(test)]";
        if !tests && !attribute {
            let code = line.split("//").next().unwrap_or_default();
            let outside = code.split('"').step_by(2);
            out.extend(outside);
            out.push('\n');
        }
        tests = attribute;
    }
    out
}

/// The paths of `use` items with the names that they give, and the rest of the source.
fn uses(code: &str) -> (Vec<(Module, String)>, String) {
    let mut out = Vec::new();
    let mut rest = String::new();
    let mut left = code;
    while let Some(at) = left.find("use ") {
        let word = !left[..at]
            .ends_with(|character: char| character.is_alphanumeric() || character == '_');
        let end = left[at..].find(';').map(|end| at + end);
        let (true, Some(end)) = (word, end) else {
            rest += &left[..at + 4];
            left = &left[at + 4..];
            continue;
        };
        rest += &left[..at];
        tree(&[], left[at + 4..end].trim(), &mut out);
        left = &left[end..];
    }
    rest += left;
    (out, rest)
}

/// The paths of a tree of imports.
fn tree(before: &[String], text: &str, out: &mut Vec<(Module, String)>) {
    let text = text.trim().trim_start_matches("::");
    let (path, group) = match text.split_once('{') {
        Some((path, group)) => (path, group.rsplit_once('}').map(|(group, _)| group)),
        None => (text, None),
    };
    let (path, alias) = match path.split_once(" as ") {
        Some((path, alias)) => (path, Some(alias.trim())),
        None => (path, None),
    };
    let own = path.split("::").map(str::trim).filter(|part| !part.is_empty() && *part != "*");
    let mut full: Module = before.to_vec();
    full.extend(own.map(str::to_owned));
    if full.len() > 1 && full.last().is_some_and(|module| module == "self") {
        full.pop();
    }
    let Some(group) = group else {
        if let Some(name) = alias.map(str::to_owned).or_else(|| full.last().cloned()) {
            out.push((full, name));
        }
        return;
    };
    let (mut depth, mut from) = (0_usize, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                tree(&full, &group[from..at], out);
                from = at + 1;
            }
            _ => {}
        }
    }
    if !group[from..].trim().is_empty() {
        tree(&full, &group[from..], out);
    }
}

/// Paths in code that begin with `crate::` or `super::`.
fn paths(code: &str) -> impl Iterator<Item = Module> {
    let is_path =
        |character: char| character.is_alphanumeric() || character == '_' || character == ':';
    code.split(move |character| !is_path(character)).filter_map(|word| {
        let path: Module = word.split("::").map(str::to_owned).collect();
        let relative = matches!(path[0].as_str(), "crate" | "super") && path.len() > 1;
        relative.then_some(path)
    })
}
