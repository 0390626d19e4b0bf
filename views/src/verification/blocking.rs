//! The codels that can block each codel, for how long, and the data they share.

use dotgen_analysis::model::Src;
use dotgen_analysis::phrase::Phrase;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::build::build;
use dotgen_timing::system::{Codel, CodelName, FOREVER, SharedPorts};
use dotgen_timing::verify::{Options, settings};

use super::Problem;
use dotgen_timing::report::TimeUnit;

/// A codel and the codels that can block it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub codel: CodelLocation,
    /// The codels that exclude it, in order of declaration.
    pub by: Vec<Blocker>,
}

/// See [`Row`].
#[derive(Debug, Clone, PartialEq)]
pub struct Blocker {
    pub codel: CodelLocation,
    /// The shared data.
    pub through: Vec<Phrase>,
}

/// A codel of the system.
#[derive(Debug, Clone, PartialEq)]
pub struct CodelLocation {
    /// Name, with its component and owner.
    pub path: CodelName,
    /// Its function; for an attribute, the path.
    pub function: String,
    /// Longest execution time, in the unit of the report; `None`: unbounded.
    pub upper: Option<f64>,
    /// Longest execution time in microseconds, for what-if fields.
    pub micros: Option<f64>,
    /// Number of the specification, and place.
    pub src: Option<(usize, Src)>,
}

/// All codels of the system in order, each with the codels that exclude it.
pub fn table(problem: &Problem, options: &Options) -> Vec<Row> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let settings = settings(&problem.scenario, options);
    let built = build(&names, &settings, &|_| true);
    if built.has_errors() {
        return Vec::new();
    }
    let ports = SharedPorts::new(&names, &settings);
    let (unit, system) = (TimeUnit::of(&settings), &built.system);
    let at = |codel: &Codel| {
        let time = system.seconds(codel.upper);
        let finite = codel.upper != FOREVER;
        CodelLocation {
            path: codel.path.clone(),
            function: match codel.site {
                Some((c, site)) => names.components[c].component.codel(site).name.to_string(),
                None => codel.path.to_string(),
            },
            upper: finite.then(|| unit.from_seconds(time)),
            micros: finite.then(|| *time.numer() as f64 * 1e6 / *time.denom() as f64),
            src: codel.site.and_then(|(c, _)| Some((names.components[c].spec_index, codel.src?))),
        }
    };
    let row = |codel: &Codel| Row {
        codel: at(codel),
        by: codel
            .conflicts
            .iter()
            .map(|conflict| &system.codels[conflict])
            .map(|other| Blocker { codel: at(other), through: ports.through(codel, other) })
            .collect(),
    };
    system.codels.iter().map(row).collect()
}

pub(super) fn function(table: &[Row], codel: &CodelName) -> String {
    let row = table.iter().find(|row| row.codel.path == *codel);
    row.map_or(&**codel, |row| &row.codel.function).to_owned()
}
