//! Execution times of codels, from the lines of a log that measure them.

use std::collections::BTreeMap;

use dotgen_timing::scn::names::Names;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::log::{LineKind, LineKinds, Origin, SkippedLines, origin};
use crate::matching::{Mismatch, Site, path, site, sites};

/// Statistics of execution times, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExecutionTimes {
    /// Number of runs.
    pub runs: u64,
    /// Least time.
    pub least: i64,
    /// Greatest time.
    pub greatest: i64,
    /// Sum.
    pub total: i128,
    /// File, from 0, and line, from 1, of the greatest time.
    pub at: (usize, u64),
}

impl ExecutionTimes {
    /// Returns the mean, in nanoseconds.
    pub fn mean(&self) -> i64 {
        let mean = self.total / i128::from(self.runs.max(1));
        i64::try_from(mean).unwrap_or(i64::MAX)
    }

    fn add(&mut self, time: i64, at: (usize, u64)) {
        if self.runs == 0 || time > self.greatest {
            (self.greatest, self.at) = (time, at);
        }
        self.least = match self.runs {
            0 => time,
            _ => self.least.min(time),
        };
        self.runs += 1;
        self.total += i128::from(time);
    }

    fn join(&mut self, other: &ExecutionTimes) {
        if self.runs == 0 {
            *self = *other;
            return;
        }
        if other.greatest > self.greatest {
            (self.greatest, self.at) = (other.greatest, other.at);
        }
        self.least = self.least.min(other.least);
        self.runs += other.runs;
        self.total += other.total;
    }
}

#[derive(Debug, Default)]
pub struct LogMeasurements {
    /// Lines that were not used.
    pub left: SkippedLines,
    kinds: LineKinds,
    /// Sections of logs. Each has a single source of times.
    sections: Vec<Section>,
    /// File of the last section.
    file: Option<usize>,
}

/// A part of a log, from one line about the source of times to the next such line.
#[derive(Debug, Default)]
struct Section {
    /// No time is measured, because the clock is virtual.
    simulated: bool,
    /// Paths of simulated codels. The times of all other codels are measured.
    codels: FxHashSet<String>,
    /// Measurements, by kind.
    of: Vec<ExecutionTimes>,
}

/// The measurements of logs for specifications.
#[derive(Debug, Default)]
pub struct Measurements {
    /// Measurements of each codel in each of its states. A codel that was never seen has no runs.
    pub sites: Vec<(Site, ExecutionTimes)>,
    /// Kinds of lines that belong to no codel of the specifications, with the number of lines.
    pub strays: Vec<(LineKind, Mismatch, u64)>,
    /// Paths of simulated codels, with their number of runs. Their times are not measured.
    pub simulated: BTreeMap<String, u64>,
}

impl LogMeasurements {
    /// Reads a line of a file. `ended`: the line has its line break.
    pub fn line(&mut self, file: usize, number: u64, text: &[u8], ended: bool) {
        if self.file != Some(file) {
            self.file = Some(file);
            self.sections.push(Section::default());
        }
        match origin(text) {
            Some(Origin::Codel(path)) => {
                if let Some(section) = self.sections.last_mut() {
                    section.codels.insert(path.to_owned());
                }
            }
            Some(origin @ (Origin::Measured | Origin::Simulated)) => self
                .sections
                .push(Section { simulated: origin == Origin::Simulated, ..Section::default() }),
            Some(Origin::Ending | Origin::End) | None => {}
        }
        let Some((line, kind)) = self.left.classify(&mut self.kinds, text, ended) else {
            return;
        };
        let Some(section) = self.sections.last_mut() else {
            return;
        };
        let kind = kind as usize;
        if section.of.len() <= kind {
            section.of.resize(kind + 1, ExecutionTimes::default());
        }
        if let Some(measure) = section.of.get_mut(kind) {
            measure.add(line.ended - line.began, (file, number));
        }
    }

    /// Assigns the measurements to the codels of specifications.
    pub fn found(&self, names: &Names<'_>) -> Measurements {
        let sites = sites(names);
        let mut places: FxHashMap<(usize, _, Option<String>), usize> = FxHashMap::default();
        for (place, site) in sites.iter().enumerate() {
            places.insert((site.component, site.codel, site.state.clone()), place);
        }
        let mut found = Measurements {
            sites: sites.into_iter().map(|site| (site, ExecutionTimes::default())).collect(),
            strays: Vec::new(),
            simulated: BTreeMap::new(),
        };
        let mut strays: Vec<u64> = vec![0; self.kinds.all.len()];
        for section in &self.sections {
            let kinds = self.kinds.all.iter().zip(&section.of).enumerate();
            for (number, (kind, measure)) in kinds.filter(|kind| kind.1.1.runs > 0) {
                let Ok(site) = site(names, kind) else {
                    if let Some(runs) = strays.get_mut(number) {
                        *runs += measure.runs;
                    }
                    continue;
                };
                let path = path(names, &site);
                if section.simulated || section.codels.contains(&path) {
                    *found.simulated.entry(path).or_default() += measure.runs;
                    continue;
                }
                let place = places.get(&(site.component, site.codel, site.state));
                let entry = place.and_then(|&place| found.sites.get_mut(place));
                if let Some((_, known)) = entry {
                    known.join(measure);
                }
            }
        }
        for (kind, runs) in self.kinds.all.iter().zip(strays) {
            if let (Err(stray), true) = (site(names, kind), runs > 0) {
                found.strays.push((kind.clone(), stray, runs));
            }
        }
        found
    }
}
