//! Edits of the `.gen`.
//!
//! Places come from `Locations`. An edit is made only if the text at the place agrees with the model, so that
//! text from macros is never changed.

use std::{ops::Range, sync::Arc};

use camino::Utf8PathBuf;
use dotgen_analysis::model::{CodelRef, Owner, Src, State, TypeId};
use dotgen_analysis::{lists::append_to_list, spelling::Spelling};

use super::Repairs;
use crate::codels::{edit::Edit, expected::state_text};

/// A place of the specification with the text of its file.
pub(super) struct SpecificationPlace {
    pub(super) path: Utf8PathBuf,
    pub(super) text: Arc<str>,
    pub(super) range: Range<usize>,
}

impl Repairs<'_> {
    /// The place of an item if its text is `wanted`.
    pub(super) fn at(&self, src: Src, wanted: &str) -> Option<SpecificationPlace> {
        let location = self.locations.locate(src)?;
        let text = self.text.read(&location.path)?;
        let here = text.get(location.range.clone())?;
        (here == wanted).then_some(SpecificationPlace {
            path: location.path,
            range: location.range,
            text,
        })
    }

    /// The place of a state, `pause::` included.
    fn state(&self, state: &State) -> Option<SpecificationPlace> {
        let full = state_text(state);
        if let Some(at) = self.at(state.src, &full) {
            return Some(at);
        }
        let mut at = self.at(state.src, &state.name)?;
        if state.paused {
            let before = at.text.get(..at.range.start)?;
            let before = before.trim_end().strip_suffix("::")?.trim_end();
            at.range.start = before.strip_suffix("pause")?.len();
        }
        Some(at)
    }

    pub(super) fn add_yield(&self, at: CodelRef, state: &str) -> Option<Edit> {
        let yields = &self.expected.component().codel(at).yields;
        let last = self.state(yields.last()?)?;
        // Text from a macro does not show the layout of the list.
        let items: Option<Vec<Range<usize>>> = yields
            .iter()
            .map(|state| Some(self.state(state).filter(|place| place.path == last.path)?.range))
            .collect();
        let items = items.unwrap_or_else(|| vec![last.range.clone()]);
        let mut edit = Edit::default();
        for (range, text) in append_to_list(&last.text, &items, state) {
            edit.replace(&last.path, range, text);
        }
        Some(edit)
    }

    pub(super) fn remove_yield(&self, at: CodelRef, index: usize) -> Option<Edit> {
        let yields = &self.expected.component().codel(at).yields;
        let this = self.state(yields.get(index)?)?;
        let range = match index.checked_sub(1) {
            Some(before) => self.state(&yields[before])?.range.end..this.range.end,
            None => this.range.start..self.state(yields.get(1)?)?.range.start,
        };
        // Only a comma may be removed together with the item.
        let around = this.text.get(range.clone())?;
        let rest = around.replacen(this.text.get(this.range.clone())?, "", 1);
        if rest.trim() != "," {
            return None;
        }
        let mut edit = Edit::default();
        edit.replace(&this.path, range, "");
        Some(edit)
    }

    /// The exception in the spelling of the component.
    pub(super) fn exception_name(&self, exception: TypeId) -> String {
        let component = &self.expected.component().name;
        let full = self.expected.spec.full_name(exception).unwrap_or_default();
        let full = full.trim_start_matches("::");
        let own = full.strip_prefix(component.as_str());
        own.and_then(|rest| rest.strip_prefix("::")).unwrap_or(full).to_owned()
    }

    pub(super) fn add_throw(&self, owner: Owner, exception: TypeId) -> Option<Edit> {
        let (at, body) = self.body(owner)?;
        let name = self.exception_name(exception);
        let mut edit = Edit::default();
        let items = property_items(&at.text, body.clone(), &["throw", "throws"]);
        if items.is_empty() {
            self.add_property(&at, body, &format!("throw {name};"), &mut edit);
        }
        for (range, text) in append_to_list(&at.text, &items, &name) {
            edit.replace(&at.path, range, text);
        }
        Some(edit)
    }

    /// The name of a task or service, and the range between its braces.
    pub(super) fn body(&self, owner: Owner) -> Option<(SpecificationPlace, Range<usize>)> {
        let component = self.expected.component();
        let (src, name) = match owner {
            Owner::Task(index) => {
                let task = &component.tasks[index];
                (task.src, &task.name)
            }
            Owner::Service(index) => {
                let service = &component.services[index];
                (service.src, &service.name)
            }
        };
        let at = self.at(src, name)?;
        let body = body_after(&at.text, at.range.end)?;
        Some((at, body))
    }

    /// Adds a property as the last one of a body.
    pub(super) fn add_property(
        &self,
        at: &SpecificationPlace,
        body: Range<usize>,
        text: &str,
        edit: &mut Edit,
    ) {
        let text = Spelling::of(&at.text).apply(text);
        let content = at.text.get(body.clone()).unwrap_or_default();
        let last = content.trim_end();
        let here = body.start + last.len();
        if !content.contains('\n') {
            edit.replace(&at.path, here..here, format!(" {text}"));
            return;
        }
        // Indented as the last line of the body, or by two more than the declaration.
        let line = last
            .lines()
            .rev()
            .find(|line| !line.trim().is_empty() && line.starts_with([' ', '\t']));
        let before = at.text.get(..at.range.start).unwrap_or_default();
        let own = before.rsplit('\n').next().unwrap_or_default();
        let blanks = |text: &str| -> String {
            text.chars().take_while(|c| matches!(c, ' ' | '\t')).collect()
        };
        let first =
            content.lines().find(|line| !line.trim().is_empty() && line.starts_with([' ', '\t']));
        let indent = first.or(line).map_or_else(|| format!("{}  ", blanks(own)), blanks);
        edit.replace(&at.path, here..here, format!("\n{indent}{text}"));
    }

    pub(super) fn rename_codel(&self, from: &str, to: &str) -> Option<Edit> {
        let mut edit = Edit::default();
        for component in &self.expected.spec.components {
            for at in component.all_codels() {
                let codel = component.codel(at);
                if codel.name == from {
                    let at = self.at(codel.src, from)?;
                    edit.replace(&at.path, at.range, to);
                }
            }
        }
        (!edit.is_empty()).then_some(edit)
    }
}

/// The part of a text after an offset, token by token: comments, strings and directives are skipped.
struct Scan<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Iterator for Scan<'t> {
    type Item = (usize, &'t str);

    fn next(&mut self) -> Option<(usize, &'t str)> {
        loop {
            let rest = self.text.get(self.at..)?;
            let first = rest.chars().next()?;
            let skip = if rest.starts_with("/*") {
                rest.find("*/").map_or(rest.len(), |end| end + 2)
            } else if rest.starts_with("//") || first == '#' {
                rest.find('\n').unwrap_or(rest.len())
            } else if first == '"' || first == '\'' {
                let mut escaped = false;
                let end = rest[1..].find(|c| {
                    let end = c == first && !escaped;
                    escaped = c == '\\' && !escaped;
                    end
                });
                end.map_or(rest.len(), |end| end + 2)
            } else if first.is_whitespace() {
                first.len_utf8()
            } else {
                let word = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
                let len = rest.find(|c| !word(c)).unwrap_or(rest.len()).max(first.len_utf8());
                let start = self.at;
                self.at += len;
                return Some((start, &rest[..len]));
            };
            self.at += skip;
        }
    }
}

/// The range between the braces after an offset; `None` if a `;` comes first.
fn body_after(text: &str, from: usize) -> Option<Range<usize>> {
    let (mut parentheses, mut depth, mut start) = (0i32, 0i32, 0);
    for (at, token) in (Scan { text, at: from }) {
        match token {
            "(" => parentheses += 1,
            ")" => parentheses -= 1,
            "{" if parentheses == 0 => {
                if depth == 0 {
                    start = at + 1;
                }
                depth += 1;
            }
            "}" if parentheses == 0 => {
                depth -= 1;
                if depth == 0 {
                    return Some(start..at);
                }
                if depth < 0 {
                    return None;
                }
            }
            ";" if depth == 0 && parentheses == 0 => return None,
            _ => {}
        }
    }
    None
}

/// The range between the parentheses after the name of a codel, and those of the parameters in it. `None` if
/// something else comes first.
pub(super) fn parameter_list(text: &str, from: usize) -> Option<(Range<usize>, Vec<Range<usize>>)> {
    let (mut start, mut next, mut items) = (None, true, Vec::<Range<usize>>::new());
    for (at, token) in (Scan { text, at: from }) {
        match (token, start) {
            ("(", None) => start = Some(at + 1),
            (")", Some(start)) => return Some((start..at, items)),
            (_, None) | ("(" | "{" | "}" | ";", _) => return None,
            (",", _) => next = true,
            _ => {
                let end = at + token.len();
                match items.last_mut().filter(|_| !next) {
                    Some(item) => item.end = end,
                    None => items.push(at..end),
                }
                next = false;
            }
        }
    }
    None
}

/// The values in the list of the last of some properties in a body.
fn property_items(text: &str, body: Range<usize>, names: &[&str]) -> Vec<Range<usize>> {
    let text = text.get(..body.end).unwrap_or_default();
    let (mut first, mut inside, mut next) = (true, false, true);
    let (mut found, mut items): (Vec<Range<usize>>, Vec<Range<usize>>) = Default::default();
    for (at, token) in (Scan { text, at: body.start }) {
        match token {
            ";" => {
                if inside {
                    found = std::mem::take(&mut items);
                }
                (first, inside) = (true, false);
            }
            _ if first => {
                (inside, next) = (names.contains(&token), true);
                first = false;
            }
            "," => next = true,
            _ if inside => {
                let end = at + token.len();
                match items.last_mut().filter(|_| !next) {
                    Some(item) => item.end = end,
                    None => items.push(at..end),
                }
                next = false;
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_found_past_comments_and_parameters() {
        let text = "task t /* { */ (in long a = {1}) { doc \"}\"; // }\n codel<a> f() yield b; };";
        let body = body_after(text, 6).unwrap();
        assert_eq!(&text[body], " doc \"}\"; // }\n codel<a> f() yield b; ");
        assert_eq!(body_after("t; task u { }", 1), None);
        assert_eq!(body_after("t {", 1), None);
    }

    #[test]
    fn the_values_of_a_property_are_found() {
        let text = "{ doc \"throw x;\"; throw a,\n  b::c /* c */ ; codel f(); }";
        let body = 1..text.len() - 1;
        let items = property_items(text, body.clone(), &["throw"]);
        let items: Vec<&str> =
            items.into_iter().map(|property_item| &text[property_item]).collect();
        assert_eq!(items, ["a", "b::c"]);
        assert!(property_items(text, body, &["validate"]).is_empty());
    }
}
