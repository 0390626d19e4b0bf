//! The files of execution times of a problem: the files that the scenario names, and `NAME.wcet` next to each
//! specification `NAME.gen`.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::FileContent;
use dotgen_analysis::model::Spec;
use dotgen_syntax::suggestion::nearest;
use dotgen_timing::scn::ast::Item;
use dotgen_timing::scn::times::{self, GivenTime, TimesFile};

use super::Problem;
use super::problem::{error, unreadable};
use dotgen_platform::files::vfs;

impl Problem {
    /// Reads the files of execution times. A file that the scenario names and that cannot be used is an
    /// error. A name without a codel is a warning.
    pub(super) fn read_times(&mut self, read: &impl Fn(&Utf8Path) -> FileContent) {
        let directory = self.path.parent().unwrap_or(&self.path).to_owned();
        for item in self.scenario.items.clone() {
            let Item::Times(file) = item else { continue };
            let path = vfs::normalize(&directory.join(&file.value));
            match content(read(&path)) {
                Ok(text) => {
                    let (name, range) = (file.value, file.range);
                    self.add_times(
                        path,
                        &text,
                        TimesFile { name, range, beside: None, times: Vec::new() },
                    );
                }
                Err(why) => {
                    self.errors.push(unreadable(&self.path, &self.text, file.range, &why));
                }
            }
        }
        for index in 0..self.units.len() {
            let Some(path) = self.units[index].files.first() else { continue };
            let path = path.with_extension(times::EXTENSION);
            let name = path.file_name().unwrap_or_default().to_owned();
            if self.times.contains(&path) {
                continue;
            }
            let read = read(&path);
            // A file that no scenario names need not exist.
            if matches!(read, FileContent::Missing | FileContent::Directory) {
                continue;
            }
            match content(read) {
                Ok(text) => {
                    let beside = Some(index);
                    let file = TimesFile { name, range: 0..0, beside, times: Vec::new() };
                    self.add_times(path, &text, file);
                }
                Err(why) => {
                    let found = error("scn-times", &path, 0..0, why);
                    self.leave_out(found);
                    self.times.push(path);
                }
            }
        }
    }

    /// Reports a file that no scenario names and that cannot be used.
    fn leave_out(&mut self, found: Diagnostic) {
        let mut message = found.message.clone();
        message.advise("the file is left out");
        self.warnings.push(Diagnostic { severity: Severity::Warning, message, ..found });
    }

    fn add_times(&mut self, path: Utf8PathBuf, text: &str, mut file: TimesFile) {
        match times::parse(text) {
            Ok(times) => file.times = times,
            Err(malformed) => {
                let range = line_range(text, malformed.line);
                let found = error("scn-times", &path, range, malformed.what);
                if file.beside.is_some() {
                    self.leave_out(found);
                    self.times.push(path);
                    return;
                }
                self.errors.push(found);
            }
        }
        let specs = self.units.iter().enumerate();
        let specs = specs.filter(|(index, _)| file.beside.is_none_or(|beside| beside == *index));
        let functions: Vec<&str> = specs.flat_map(|(_, unit)| functions(&unit.spec)).collect();
        let unknown = file.times.iter().filter(|given| !given.is_internal());
        let unknown = unknown.filter(|given| !functions.contains(&given.function.as_str()));
        let warnings = unknown.map(|given| Diagnostic {
            severity: Severity::Warning,
            ..error(
                "scn-times-name",
                &path,
                line_range(text, given.line),
                unknown_name(given, &functions),
            )
        });
        self.warnings.extend(warnings.collect::<Vec<_>>());
        self.scenario.times.push(file);
        self.times.push(path);
    }
}

/// The functions of the codels of a specification.
fn functions(spec: &Spec) -> impl Iterator<Item = &str> {
    let components = super::problem::components(spec);
    components.flat_map(|component| {
        component.all_codels().map(|codel| component.codel(codel).name.as_str())
    })
}

/// Returns the message about a time without a codel.
fn unknown_name(given: &GivenTime, functions: &[&str]) -> String {
    let what = format!("no codel has the function `{}`", given.function);
    match nearest(&given.function, functions.iter().copied()) {
        Some(near) => format!("{what}; there is `{near}`"),
        None => what,
    }
}

fn content(content: FileContent) -> Result<String, String> {
    match content {
        FileContent::Text(text) if text.len() <= times::MAX_BYTES => Ok(text),
        FileContent::Text(_) => Err("it is larger than 1 MB".to_owned()),
        FileContent::NotUtf8(_) => Err("it is not UTF-8".to_owned()),
        FileContent::Missing => Err("there is no such file".to_owned()),
        FileContent::Directory => Err("it is a directory".to_owned()),
        FileContent::Unreadable(why) => Err(why),
    }
}

/// The bytes of a line, counted from 1.
fn line_range(text: &str, line: usize) -> std::ops::Range<usize> {
    let mut start = 0;
    for (number, piece) in (1..).zip(text.split_inclusive('\n')) {
        if number == line {
            return start..start + piece.trim_end().len();
        }
        start += piece.len();
    }
    0..0
}
