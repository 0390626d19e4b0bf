//! The exact explorer.
//!
//! Time is integer: all bounds are integers and closed, so every run can be shifted to a run with integer
//! time stamps and the same order of actions (section 12 of the timed semantics). States are visited in order
//! of absolute time, one *layer* per moment. Within a layer all orders of simultaneous actions are followed.
//! States in which nothing urgent remains become *nodes*. They are merged and compared with all earlier nodes
//! (see `explore::store`), and jump to their next moment.

mod chain_spans;
mod continued;
mod details;
mod findings;
mod follow;
mod held_cores;
mod last_job;
mod liveness;
mod measure;
mod never_observed;
mod observe;
mod reductions;
mod rules;
mod run;
mod search;
mod segments;
mod spans;
mod state;
mod stepper;
mod store;
mod watch;

pub use chain_spans::{explore_chain, is_exact};
pub use continued::{Continued, NextStep};
pub use details::{Blocker, Executing, MomentDetails};
pub use findings::{Bound, Findings, Measured};
pub(crate) use follow::follow;
pub use liveness::{Liveness, LivenessQuery, liveness};
pub use never_observed::{NeverObserved, TaskWithoutJob};
pub use reductions::{Activity, Kind, Kinds, Reason};
pub use rules::{Action, IdleTurn, Moment, MomentKind, Work};
pub use run::{Run, SystemRun};
pub use search::{Walked, bytes_of_walks, explore, explore_with_reports, search_once, walk};
pub use spans::{ChainSpans, Span, Spent};
pub use stepper::{Possible, RunState, Seen, Stepper, Watched};
pub use watch::{Limits, ResponseTime, Stop, Watch, Within};
