//! Files of worst cases: the function of a codel and its time in seconds, line by line.

use anyhow::{bail, ensure};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::FileContent;
use dotgen_platform::files::vfs;
use dotgen_recording::matching::Site;
use dotgen_recording::measurements::ExecutionTimes;
use dotgen_syntax::suggestion::nearest;
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::times::{self, GivenTime};
use num_rational::Ratio;
use serde::Serialize;

use crate::session::is_standard_input;

/// Longest time, in nanoseconds: a day.
const MAX_NANOS: i64 = 86_400_000_000_000;

/// Most names that are listed.
const MAX_NAMED: usize = 10;

/// A function without a codel.
#[derive(Serialize)]
struct Unknown {
    function: String,
    /// The nearest function of a codel.
    near: Option<String>,
}

/// A list of worst cases, assigned to codels.
#[derive(Serialize)]
pub(super) struct Given {
    /// Names of the files.
    #[serde(skip)]
    files: Vec<Utf8PathBuf>,
    unknown: Vec<Unknown>,
    /// Number of codels that GenoM3 adds to a component.
    internal: usize,
}

/// The worst cases of some files.
pub(super) struct Lists(Vec<(Utf8PathBuf, Vec<GivenTime>)>);

/// Reads files of worst cases. Returns `None` if none of the files is one.
///
/// # Errors
/// Some of the files are lists of worst cases and others are not, or a `.wcet` file is malformed.
pub(super) fn read(files: &[Utf8PathBuf]) -> anyhow::Result<Option<Lists>> {
    let mut lists = Vec::new();
    for file in files {
        lists.extend(list(file)?.map(|times| (file.clone(), times)));
    }
    if lists.is_empty() {
        return Ok(None);
    }
    ensure!(
        lists.len() == files.len(),
        "give logs, or files of worst cases, not both: `{}` is a file of worst cases",
        lists[0].0
    );
    Ok(Some(Lists(lists)))
}

/// Returns the worst cases of a file, or `None` if the file is not such a list. A line of a log has more than
/// two words.
fn list(path: &Utf8Path) -> anyhow::Result<Option<Vec<GivenTime>>> {
    if is_standard_input(path) {
        return Ok(None);
    }
    let is_named = path.extension() == Some(times::EXTENSION);
    let is_short = std::fs::metadata(path).is_ok_and(|file| file.len() <= times::MAX_BYTES as u64);
    if !is_short {
        ensure!(!is_named || !path.exists(), "`{path}` is larger than 1 MB");
        return Ok(None);
    }
    let FileContent::Text(text) = vfs::read(path) else { return Ok(None) };
    match times::parse(&text) {
        Ok(times) if is_named || !times.is_empty() => Ok(Some(times)),
        Err(malformed) if is_named => bail!("{path}:{}: {}", malformed.line, malformed.what),
        _ => Ok(None),
    }
}

/// Returns the time to write for a worst case in nanoseconds: whole microseconds, at least one.
pub(super) fn micros(nanos: i64) -> u64 {
    u64::try_from(nanos).unwrap_or(0).div_ceil(1_000).max(1)
}

impl Given {
    /// Assigns worst cases to the codels with their functions. Of several times of a function, the longest
    /// counts.
    ///
    /// # Errors
    /// A time is longer than a day, or no function is that of a codel.
    pub(super) fn assign(
        Lists(lists): &Lists,
        names: &Names<'_>,
        sites: &mut [(Site, ExecutionTimes)],
    ) -> anyhow::Result<Given> {
        let mut out = Given {
            files: lists.iter().map(|(path, _)| path.clone()).collect(),
            unknown: Vec::new(),
            internal: 0,
        };
        let function = |site: &Site| {
            let member = names.components.get(site.component)?;
            Some(member.component.codel(site.codel).name.to_string())
        };
        let functions: Vec<Option<String>> = sites.iter().map(|(site, _)| function(site)).collect();
        for (file, (path, times)) in lists.iter().enumerate() {
            for given in times {
                let mut is_known = false;
                for ((_, measure), name) in sites.iter_mut().zip(&functions) {
                    if name.as_deref() != Some(given.function.as_str()) {
                        continue;
                    }
                    is_known = true;
                    let nanos = (given.time * Ratio::from_integer(1_000_000_000)).ceil();
                    let nanos = i64::try_from(nanos.to_integer()).ok();
                    let Some(nanos) = nanos.filter(|&nanos| nanos <= MAX_NANOS) else {
                        bail!("{path}:{}: `{}` is longer than a day", given.line, given.function);
                    };
                    if measure.runs == 0 || nanos > measure.greatest {
                        *measure = ExecutionTimes {
                            runs: 1,
                            least: nanos,
                            greatest: nanos,
                            total: nanos.into(),
                            at: (file, given.line as u64),
                        };
                    }
                }
                if is_known {
                } else if given.is_internal() {
                    out.internal += 1;
                } else {
                    let near =
                        nearest(&given.function, functions.iter().flatten().map(String::as_str));
                    out.unknown.push(Unknown {
                        function: given.function.clone(),
                        near: near.map(str::to_owned),
                    });
                }
            }
        }
        ensure!(
            sites.iter().any(|(_, measure)| measure.runs > 0),
            "no codel of the specification is in {}",
            out.names()
        );
        Ok(out)
    }

    fn names(&self) -> String {
        let names = self.files.iter().map(|path| format!("`{path}`"));
        names.collect::<Vec<_>>().join(", ")
    }

    /// Returns what was read, and what was left out.
    pub(super) fn told(&self) -> Vec<String> {
        let mut out =
            vec![format!("{}: read as worst cases in seconds, without a margin", self.names())];
        for Unknown { function, near } in self.unknown.iter().take(MAX_NAMED) {
            let near = near.as_ref().map_or(String::new(), |near| format!("; there is `{near}`"));
            out.push(format!("no codel has the function `{function}`{near}"));
        }
        if self.unknown.len() > MAX_NAMED {
            out.push(format!("{} more functions have no codel", self.unknown.len() - MAX_NAMED));
        }
        if self.internal > 0 {
            let lines = if self.internal == 1 { "line" } else { "lines" };
            out.push(format!(
                "{} {lines} of codels that GenoM3 adds to a component left out",
                self.internal
            ));
        }
        out
    }
}
