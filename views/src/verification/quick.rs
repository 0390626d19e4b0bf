//! Quick upper bounds on response times, available before the exact answer.

use dotgen_analysis::model::Seconds;
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::system::TaskId;

use dotgen_timing::scn::names::Names;
use dotgen_timing::system::build::build;
use dotgen_timing::system::indexed::DeclaredTask;
use dotgen_timing::verify::{Cancel, Options, settings};

use super::Problem;
use dotgen_timing::report::TimeUnit;

/// An upper bound on the response time of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskBound {
    pub id: DeclaredTask,
    /// `component.task`
    pub task: String,
    /// The bound, in the unit of the report.
    pub bound: f64,
}

/// Response-time analysis with blocking. Tasks for which it finds no bound are absent.
pub fn quick_bounds(problem: &Problem, options: &Options, cancel: &Cancel) -> Vec<TaskBound> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let settings = settings(&problem.scenario, options);
    let built = build(&names, &settings, &|_| true);
    if built.has_errors() {
        return Vec::new();
    }
    let (unit, system) = (TimeUnit::of(&settings), &built.system);
    let bounds = response_bounds(system, cancel);
    let of_task = |(&id, &task): (&DeclaredTask, &TaskId)| {
        let bound: Seconds = system.seconds(bounds[task]?);
        Some(TaskBound { id, task: system.task_path(task), bound: unit.from_seconds(bound) })
    };
    let mut out: Vec<TaskBound> = built.tasks.iter().filter_map(of_task).collect();
    out.sort_by(|a, b| a.task.cmp(&b.task));
    out
}
