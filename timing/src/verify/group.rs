//! Groups of components that do not influence each other.

use crate::cancel::Cancel;
use crate::explore::Limits;
use crate::report::{Report, TimeUnit};
use crate::scn::names::Names;
use crate::system::indexed::Built;
use crate::system::settings::Settings;

/// Components that are explored together.
#[derive(Clone, Copy)]
pub(super) struct Group<'g> {
    pub(super) names: &'g Names<'g>,
    pub(super) built: &'g Built,
    /// Unit of the report.
    pub(super) unit: TimeUnit,
    pub(super) settings: &'g Settings,
    pub(super) limits: Limits,
    /// One failed check is enough, and no run that shows it is wanted.
    pub(super) until_failure: bool,
    pub(super) cancel: &'g Cancel,
    /// Reports the intermediate results.
    pub(super) tell: &'g (dyn Fn(&mut Report) + Sync),
}
