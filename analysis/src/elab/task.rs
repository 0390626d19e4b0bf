//! Tasks (language reference, section 10.3).

use crate::finding::role::Role;
use num_rational::Ratio;
use rustc_hash::FxHashMap;
use typed_index_collections::TiVec;

use super::{
    AccessKind, DefId, DefKind, Entity,
    context::Elaborator,
    property::{self, keyword, union},
    state::TaskState,
};
use crate::{
    finding::{Finding, services::DeclarationProblem, values::ValueProblem},
    item_tree::{CodelDecl, Item, Name, PropertyKind, Ptr},
    model::{CodelKind, ComponentId, Name as Text, Owner, OwnerBody, Src, Task, TaskId},
    release::Change,
};

impl<'a> Elaborator<'a> {
    pub(super) fn task(
        &mut self,
        c: ComponentId,
        name: &'a Name,
        properties: &'a [Item],
        ptr: Ptr,
    ) {
        let at = self.src(name.ptr);
        let known = self.components[c].task_by_name.get(&name.text);
        let task = if let Some(task) = known.copied() {
            let def = self.components[c].tasks[task].def;
            self.refer_as(at, def, AccessKind::Declaration);
            if self.spec.release.has(Change::ReopenedTaskPlaces) {
                self.spec.components[c].tasks[task].src = at;
            }
            task
        } else {
            let node = self.src(ptr);
            let def = self.define(DefKind::Task, &name.text, at, node, None);
            let task = self.new_task(c, &name.text, at, def, None);
            self.set_entity(def, Entity::Task(c, task));
            task
        };
        let node = self.src(ptr);
        self.spec.owner_bodies.push(OwnerBody { component: c, owner: Owner::Task(task), node });
        let container = self.components[c].tasks[task].def;
        let outer = self.container.replace(container);
        self.for_each(properties, |this, item| {
            this.task_property(c, task, name, item);
        });
        self.container = outer;
        self.check_delay(c, task);
    }

    pub(super) fn new_task(
        &mut self,
        c: ComponentId,
        name: &Text,
        src: Src,
        def: DefId,
        imported_from: Option<ComponentId>,
    ) -> TaskId {
        let tasks = &mut self.spec.components[c].tasks;
        let task = tasks.next_key();
        tasks.push(Task {
            name: name.clone(),
            src,
            doc: None,
            period: None,
            delay: None,
            priority: None,
            real_time: false,
            stack: None,
            throws: Vec::new(),
            codels: TiVec::new(),
            imported_from,
        });
        let state = &mut self.components[c];
        state.tasks.push(TaskState {
            def,
            given: FxHashMap::default(),
            codels: Vec::new(),
            incomplete: false,
        });
        state.task_by_name.insert(name.clone(), task);
        task
    }

    fn task_property(&mut self, c: ComponentId, task: TaskId, name: &'a Name, item: &'a Item) {
        let property = match item {
            Item::Property(property) => property,
            Item::Pragma(pragma) => return self.pragma(pragma),
            _ => return,
        };
        let at = self.src(property.ptr);
        let word = keyword(&property.kind);
        match &property.kind {
            PropertyKind::Doc(doc) => {
                let mut docs = self.spec.components[c].tasks[task].doc.take();
                self.add_doc(&mut docs, doc);
                self.spec.components[c].tasks[task].doc = docs;
            }
            PropertyKind::Throws(list) => {
                let added = self.throws(list, c, Some(Owner::Task(task)));
                union(&mut self.spec.components[c].tasks[task].throws, added);
            }
            PropertyKind::Period(duration) | PropertyKind::Delay(duration) => {
                let value = self.time(duration, word, at);
                if word == "period"
                    && value.as_ref().is_some_and(|time| time.value == Ratio::from_integer(0))
                {
                    self.error(at, ValueProblem::PeriodZero);
                }
                if self.once_in_task(c, task, word, at) {
                    let task = &mut self.spec.components[c].tasks[task];
                    match word {
                        "period" => task.period = value,
                        _ => task.delay = value,
                    }
                }
            }
            PropertyKind::Priority(expr) => {
                let value = self.priority(expr, at);
                if self.once_in_task(c, task, word, at) {
                    self.spec.components[c].tasks[task].priority = value;
                }
            }
            PropertyKind::Scheduling => {
                if self.once_in_task(c, task, word, at) {
                    self.spec.components[c].tasks[task].real_time = true;
                }
            }
            PropertyKind::Stack(size) => {
                let value = self.stack(size, at);
                if self.once_in_task(c, task, word, at) {
                    self.spec.components[c].tasks[task].stack = value;
                }
            }
            PropertyKind::Codel(decl) if decl.triggers.is_some() => {
                self.codel_here(c, Owner::Task(task), decl, CodelKind::Fsm);
            }
            PropertyKind::Codel(decl) => self.stateless_codel(c, task, name, decl),
            PropertyKind::Local { ty, .. } => {
                let at = self.src(ty.ptr);
                self.local_outside(at, "a task");
            }
            kind => {
                self.error(at, DeclarationProblem::NotInTask { word, home: property::home(kind) });
            }
        }
    }

    /// Reports a codel without states, which a task cannot have.
    fn stateless_codel(&mut self, c: ComponentId, task: TaskId, name: &Name, decl: &'a CodelDecl) {
        self.components[c].tasks[task].incomplete = true;
        let compiler_at = self.src(name.ptr);
        let (at, codel) = match &decl.name {
            Some(name) => (self.src(name.ptr), name.text.clone()),
            None => (self.src(decl.ptr), Text::default()),
        };
        let kind = DeclarationProblem::TaskCodelWithoutState { codel, task: name.text.clone() };
        // The reference compiler reports it at the task.
        self.report(Finding::new(kind, compiler_at).related(at, Role::ThisCodel));
        self.misplaced_params(c, Owner::Task(task), decl, CodelKind::Fsm);
    }

    pub(super) fn once_in_task(
        &mut self,
        c: ComponentId,
        task: TaskId,
        word: &'static str,
        at: Src,
    ) -> bool {
        let state = &mut self.components[c].tasks[task];
        let mut given = std::mem::take(&mut state.given);
        let first = self.once(&mut given, word, at);
        self.components[c].tasks[task].given = given;
        first
    }

    /// A delay needs a period, and must be shorter.
    pub(super) fn check_delay(&mut self, c: ComponentId, task: TaskId) {
        let given = &self.components[c].tasks[task].given;
        let period_given = given.contains_key("period");
        let task = &self.spec.components[c].tasks[task];
        let Some(delay) = &task.delay else { return };
        let at = delay.src;
        match &task.period {
            None if !period_given => {
                self.error(at, ValueProblem::DelayWithoutPeriod { task: task.name.clone() });
            }
            Some(period) if delay.value >= period.value => {
                let diagnostic =
                    Finding::new(ValueProblem::DelayRange, at).related(period.src, Role::Period);
                self.report(diagnostic);
            }
            _ => {}
        }
    }
}
