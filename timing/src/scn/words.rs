//! The words of the language and their meanings, for hovers and completion. `docs/verification.md` explains
//! them in detail.

/// A word and its meaning.
pub(super) struct Word {
    pub(super) word: &'static str,
    /// Syntax of the word.
    pub(super) form: &'static str,
    pub(super) meaning: &'static str,
}

const fn word(word: &'static str, form: &'static str, meaning: &'static str) -> Word {
    Word { word, form, meaning }
}

/// Returns true for a word of the language.
pub fn is_word(name: &str) -> bool {
    find(name).is_some()
}

/// Returns the meaning of a word as an item, a check or a step.
pub(super) fn find(name: &str) -> Option<&'static Word> {
    WORDS.iter().find(|word| word.word == name)
}

const WORDS: &[Word] = &[
    word(
        "scenario",
        "scenario NAME { … }",
        "The specifications, the platform, the clients and the checks of a verification.",
    ),
    word(
        "use",
        "use \"FILE.gen\";",
        "A specification to verify; the path starts at the directory of the scenario.",
    ),
    word(
        "times",
        "times \"FILE.wcet\";",
        "A file with the functions of codels and their worst cases in seconds, for codels without a `wcet` and \
         without a `duration`. `NAME.wcet` next to `NAME.gen` needs no `times`.",
    ),
    word(
        "weights",
        "weights \"FILE.proba\";",
        "A file with how often each transition was taken: `dotgen run` draws the yields of simulated codels by it. \
         Verification does not use it.",
    ),
    word("unit", "unit 10 us;", "Unit of results (default 1 ms); durations are rounded up to it."),
    word("cores", "cores 4;  cores free;", "Number of cores. `free` (default): one core per task."),
    word(
        "semantics",
        "semantics servers;  semantics published;",
        "Rules of the model: the servers that run on robots (default), or the published formal models.",
    ),
    word(
        "policy",
        "policy priority;  fair;  fifo;  edf;  any;",
        "Order in which tasks get a core. With preemption: the ready tasks of highest priority (`priority`, \
         default), or any ready tasks (`fair`). Without preemption, to the end of the cycle: the task that \
         waits longest (`fifo`, default with `semantics published`), the task with the earliest deadline \
         (`edf`), or any (`any`).",
    ),
    word(
        "affinity",
        "affinity component.task 1;",
        "Ties a task to one core; cores are numbered from 1.",
    ),
    word(
        "ticks",
        "ticks component;  ticks task;",
        "Source of ticks: one clock per component, from its start, or one timer per task, from the start of \
         the task.",
    ),
    word(
        "turns",
        "turns codel;  turns pause;",
        "Order of the activities of one task: the next one after each codel, or when one pauses or ends.",
    ),
    word(
        "ports",
        "ports copy;  ports lock;",
        "Ports are copied and lock nothing between components, or an output is one lock for all codels that \
            use it.",
    ),
    word(
        "pause",
        "pause events;  pause turns;",
        "Event that resumes a paused activity of an aperiodic task: an internal event, or the next cycle.",
    ),
    word(
        "exceptions",
        "exceptions on;  exceptions off component.service;",
        "`on`: codels whose service or task declares exceptions may throw one. `off`: they do not.",
    ),
    word(
        "order",
        "order on;  order off;",
        "`on`: requests that violate `before` and `after` are refused. `off`: both are ignored.",
    ),
    word(
        "durations",
        "durations interval;  fixed;  open;",
        "Execution times of codels: from 0 to their `wcet` (default), always their `wcet`, or more than 0.",
    ),
    word(
        "duration",
        "duration component.task.state [1,3] ms;",
        "Execution time of one codel; `*` for no upper bound.",
    ),
    word(
        "loop",
        "loop once component.task;",
        "Number of times that one turn may enter the same state: `once`, a number, or `free` (default).",
    ),
    word(
        "idle",
        "idle keep component.task;",
        "A tick with nothing to do: `drop` (default) takes the tick and a core with it, `keep` leaves it.",
    ),
    word(
        "locks",
        "locks queue;  locks free;  locks fifo;",
        "Order of waiting codels. `queue` (default): one queue per component, first come, first served; all \
         codels wait behind the head. `free`: any codel. `fifo`: first come, first served among codels that \
         exclude each other.",
    ),
    word(
        "async",
        "async held;  async free;",
        "`held` (default): `async` codels are executed like others. `free`: they need no core.",
    ),
    word(
        "aperiodic",
        "aperiodic core;  aperiodic free;",
        "`core` (default): aperiodic tasks need a core. `free`: they need none.",
    ),
    word(
        "connect",
        "connect INPUT to OUTPUT;  to none;  (of a client:) connect component;",
        "The output that an input port reads; otherwise ports of equal name are connected. As a step of a \
         client: asks the component to connect a port or a remote service. The component waits at the head \
         of its lock queue until no task executes a codel.",
    ),
    word(
        "slots",
        "slots component.task 3;  slots component.activity 3;",
        "Number of activities that a task can have at the same time, its permanent one included (default \
         16). With `semantics published`: number of instances that an activity can have (default 2).",
    ),
    word(
        "client",
        "client NAME { … }",
        "A client that sends requests. Without a client nothing is requested.",
    ),
    word(
        "on",
        "on [NAME:] late PATH, … { … }  on lost COMPONENT <= 50 ms { … }",
        "A measure: steps that follow an event of a run. `late`: a codel takes longer than its time, or a task \
         misses a deadline. `violation of CHECK`: a check is violated. `lost`: the process of a component has \
         ended. `stale PORT after TIME`: the port was not written for that long. A run takes each measure once. \
         The model takes it at any time, and a check gives the longest time from the event to its end.",
    ),
    word(
        "late",
        "on late component.task.state, component.task { … }",
        "A codel takes longer than its time, or a task misses a deadline.",
    ),
    word("violation", "on violation of CHECK { … }", "A check of the scenario is violated."),
    word(
        "stale",
        "on stale component.port after 200 ms { … }",
        "The output port was written once, and then not for this long.",
    ),
    word("lost", "on lost component { … }", "The process of the component has ended."),
    word("check", "check [NAME:] …;", "A property to verify."),
    word(
        "schedulable",
        "check schedulable TASK;",
        "No tick comes before the job of the previous one has ended. `*`: all tasks.",
    ),
    word(
        "no-overdue",
        "check no-overdue TASK;",
        "The task never waits for a core as long as its period.",
    ),
    word(
        "response",
        "check response TASK <= 5 ms;",
        "The time from release to the end of the job is at most this long. Without a bound, the least bound \
         is computed.",
    ),
    word(
        "within",
        "check within P => Q [then R] <= 5 ms;",
        "Whenever P becomes true, Q is true then or later. With `then`, R is true at that moment or later. \
         The last of them is at most that long after P.",
    ),
    word(
        "reaction",
        "check reaction component.port -> component.port [via PATH, …] <= 20 ms;",
        "The longest time from a new first datum until the last one is first written by a codel whose data \
            depend on it.",
    ),
    word(
        "age",
        "check age component.port -> component.port [via PATH, …] <= 20 ms;",
        "The longest time since the write of the first datum on which the visible last datum depends.",
    ),
    word(
        "via",
        "check reaction A -> B via component.task.state, component.port;",
        "Of each component that is named here, only these codels carry the data, or only codels that write \
         these ports.",
    ),
    word("leadsto", "check leadsto P => Q;", "Whenever P becomes true, Q follows on every run."),
    word("eventually", "check eventually P;", "P becomes true on every run."),
    word(
        "always",
        "check always P;  check always P => Q;",
        "P holds in every state; with `=>`, Q holds in every state with P.",
    ),
    word("never", "check never P;", "P holds in no state. The same as `always not P`."),
    word("reachable", "check reachable P;", "P holds in some state."),
    word(
        "deadlock",
        "check deadlock;",
        "There is no state in which nothing will ever happen again.",
    ),
    word(
        "send",
        "send component.service;",
        "Sends a request and waits until the control task takes it.",
    ),
    word(
        "await",
        "await accepted;  await ended component.activity;  await ended ok;",
        "Waits until the last request is answered, or until an activity has ended (`ok`: and has succeeded; \
         `failed`: and has not).",
    ),
    word(
        "ok",
        "await ended ok component.activity;",
        "The request has succeeded: it has ended without an exception and was not interrupted without a \
         `stop` codel.",
    ),
    word(
        "failed",
        "await ended failed component.activity;",
        "The request was refused, has ended by an exception, or was interrupted without a `stop` codel.",
    ),
    word(
        "abort",
        "abort component.activity;  abort LABEL;",
        "Asks the component to interrupt one instance: the last accepted one of this activity and this \
         client, or the last one sent at the step with the label. In a measure: interrupts all instances of \
         the activity.",
    ),
    word(
        "kill",
        "kill component;",
        "Asks the component to end. Its activities are interrupted task by task, then its permanent ones in \
         reverse order, through their `stop` codels. Then its tasks end.",
    ),
    word("delay", "delay [1,2] ms;", "Waits; `[0,*]`: for any time."),
    word(
        "repeat",
        "repeat 3 { … }  repeat * { … }",
        "Executes the steps this many times; `*`: for ever.",
    ),
    word("choice", "choice { … } or { … }", "Executes one of the branches; all are explored."),
    word(
        "then",
        "check within P => Q then R <= 5 ms;",
        "The next predicate: it is true when the one before it is, or later.",
    ),
    word(
        "absent",
        "check absent Q after P for 10 ms;",
        "Whenever P becomes true, Q does not hold from then on, for less than this time.",
    ),
    word(
        "lasts",
        "check lasts P >= 2 ms;  check lasts P <= 2 ms;",
        "Whenever P becomes true, it holds for at least, or at most, this time.",
    ),
    word("precedes", "check P precedes Q;", "Q does not hold before P has held."),
    word(
        "before",
        "check before P never Q;  check before P eventually Q;",
        "Until P holds for the first time, Q never holds (or always, or at some moment). If P never holds, \
         nothing is claimed.",
    ),
    word(
        "after",
        "check after P never Q;  check after P until Q always R;",
        "From the first P on, or from each P until the next Q, the last predicate never or always holds.",
    ),
    word(
        "between",
        "check between P and Q never R;",
        "From P to the next Q, R never holds (or always, or at some moment). If Q does not come, nothing is \
         claimed. Predicates with `and` or `or` need parentheses.",
    ),
    word("until", "check after P until Q never R;", "The end of a scope; it need not come."),
    word("in", "check within P => Q in [5, 20] ms;", "The least and the greatest time; `*`: any."),
    word("for", "check absent Q after P for 10 ms;", "The time for which something is absent."),
    word("tick", "TASK.tick", "The timer of a periodic task has just begun a period."),
    word("leave", "leave PATH", "The moment at which PATH stops being true."),
    word("waiting", "TASK.waiting", "The task waits for a core (an activity: is held back)."),
    word("running", "TASK.running", "The task has its core."),
    word("idle", "TASK.idle", "The task has nothing to do."),
    word("exec", "STATE.exec", "The codel executes."),
    word("lock", "STATE.lock", "The codel waits for its locks."),
    word("run", "ACTIVITY.run", "An instance of the activity runs."),
    word(
        "stop",
        "ACTIVITY.stop  stop;",
        "An instance of the activity is being interrupted. As the last step of a measure: the run ends, and \
         everything executes its `stop` codels.",
    ),
    word("void", "ACTIVITY.void", "There is no instance of the activity."),
];
