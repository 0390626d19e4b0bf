//! The meaning of each kind of drift: the table from which manual pages and help are generated.
//! [`dotgen_analysis::codes`] is the same for findings about specifications alone.

use super::drift::DriftCode;

/// A kind of drift, for users.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CodelCode {
    /// The kind; it has the code and the severity.
    pub code: DriftCode,
    /// The meaning, in one sentence.
    pub meaning: &'static str,
    /// The reason, or the consequence.
    pub why: &'static str,
    /// The specification of an example with this finding and no other.
    pub specification: &'static str,
    /// The codels of the example.
    pub source: &'static str,
    /// The corrected example.
    pub corrected: Correction,
    /// Advice for fixing it.
    pub fix: &'static str,
}

/// The part of an example that has to change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Correction {
    /// The specification; the codels are right.
    Specification(&'static str),
    /// The codels; the specification is right.
    Source(&'static str),
}

/// All kinds.
pub const CODES: &[CodelCode] = &[
    CodelCode {
        code: DriftCode::MissingDefinition,
        meaning: "No source defines the function of a codel.",
        why: "The component does not link, or the dynamic loader refuses it at run time. While most codels of a \
              component have no function, one finding names their number, and each codel has a hint.",
        specification: "component c {\n  function f() { codel c_f(); };\n  function g() { codel c_g(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\ngenom_event c_g(const genom_context self)\n{\n  return genom_ok;\n}\n",
        ),
        fix: "Let dotgen write a stub (quick fix, or `dotgen codels stub`), or remove the codel from the \
             specification.",
    },
    CodelCode {
        code: DriftCode::SignatureMismatch,
        meaning: "The prototype of a codel's function differs from the one that the specification requires.",
        why: "Codels are compiled separately from the code that calls them. If the file does not include the generated \
              prototype, no compiler sees the difference, and the function reads its arguments from the wrong places.",
        specification: "component c {\n  function f(in long n) { codel c_f(local in n); };\n};\n",
        source: "genom_event c_f(double n, const genom_context self)\n{\n  return genom_ok;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(int32_t n, const genom_context self)\n{\n  return genom_ok;\n}\n",
        ),
        fix: "Update the signature: the quick fix keeps the body and the names that it uses.",
    },
    CodelCode {
        code: DriftCode::UndeclaredYield,
        meaning: "A codel returns a state that its `yields` list does not contain.",
        why: "The running state machine differs from the specification. Diagrams, checks and response times \
             are computed from the specification, so they do not describe the code.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "genom_event c_start(const genom_context self)\n{\n  if (ready()) return c_run;\n  return c_ether;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        corrected: Correction::Specification(
            "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run, ether;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        ),
        fix: "Add the state to the `yields` list, or return one that is in it.",
    },
    CodelCode {
        code: DriftCode::NeverYielded,
        meaning: "A codel never returns one of the states in its `yields` list.",
        why: "The state machine in the specification, from which response times are computed, has a transition that \
              the code never takes. This is harmless while the code is still being written.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run, ether;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "genom_event c_start(const genom_context self)\n{\n  return c_run;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        corrected: Correction::Specification(
            "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        ),
        fix: "Remove the state from the `yields` list, or return it.",
    },
    CodelCode {
        code: DriftCode::UndeclaredThrow,
        meaning: "A codel raises an exception that neither its task nor its service declares.",
        why: "Clients are generated from the specification: they do not expect an exception that the service does not \
              `throw`.",
        specification: "component c {\n  exception e_late;\n  function f() { codel c_f(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return c_e_late(self);\n}\n",
        corrected: Correction::Specification(
            "component c {\n  exception e_late;\n  function f() { throw e_late; codel c_f(); };\n};\n",
        ),
        fix: "Add the exception to the `throws` of the service or task, or do not raise it.",
    },
    CodelCode {
        code: DriftCode::Orphan,
        meaning: "A function looks like a codel, but no specification names it.",
        why: "The function is probably left over from a codel that was removed or renamed.",
        specification: "component c {\n  function f() { codel c_f(); };\n};\n",
        source: "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\n\n/** Codel c_old of function old.\n *\n * Returns genom_ok.\n */\ngenom_event c_old(const genom_context self)\n{\n  return genom_ok;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(const genom_context self)\n{\n  return genom_ok;\n}\n",
        ),
        fix: "If a codel with a similar name has no function, rename this one. Otherwise declare a codel for \
             the function, or remove it. Make helper functions `static`.",
    },
    CodelCode {
        code: DriftCode::StaleComment,
        meaning: "The generated comment of a codel disagrees with the specification.",
        why: "Readers of the code rely on \"Triggered by\", \"Yields to\" and \"Throws\" in the comment.",
        specification: "component c {\n  task t {\n    period 10 ms;\n    codel<start> c_start() yield run;\n    codel<run> c_run() yield pause::run;\n  };\n};\n",
        source: "/** Codel c_start of task t.\n *\n * Triggered by c_start.\n * Yields to c_ether.\n */\ngenom_event c_start(const genom_context self)\n{\n  return c_run;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        corrected: Correction::Source(
            "/** Codel c_start of task t.\n *\n * Triggered by c_start.\n * Yields to c_run.\n */\ngenom_event c_start(const genom_context self)\n{\n  return c_run;\n}\ngenom_event c_run(const genom_context self)\n{\n  return c_pause_run;\n}\n",
        ),
        fix: "Refresh the comment with the quick fix.",
    },
    CodelCode {
        code: DriftCode::UndeclaredName,
        meaning: "A codel uses a name that is no longer one of its parameters.",
        why: "The code does not compile. The parameter was removed or renamed in the specification.",
        specification: "component c {\n  ids { double speed, limit; };\n  function f() { codel c_f(inout speed); };\n};\n",
        source: "genom_event c_f(double *speed, const genom_context self)\n{\n  *speed = limit;\n  return genom_ok;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(double *speed, const genom_context self)\n{\n  const double limit = 2.;\n  *speed = limit;\n  return genom_ok;\n}\n",
        ),
        fix: "Add the parameter to the codel and update the signature, or declare the name in the source.",
    },
    CodelCode {
        code: DriftCode::ConstantWrite,
        meaning: "A codel writes to a parameter that it may only read.",
        why: "The code does not compile. A parameter with the direction `in` points to a constant.",
        specification: "component c {\n  struct s { double x; };\n  ids { s state; };\n  function f() { codel c_f(in state); };\n};\n",
        source: "genom_event c_f(const c_s *state, const genom_context self)\n{\n  state->x = 1.;\n  return genom_ok;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(const c_s *state, const genom_context self)\n{\n  c_s next = *state;\n  next.x = 1.;\n  return genom_ok;\n}\n",
        ),
        fix: "Change the direction in the specification to `out` or `inout` and update the signature, or write to a \
              copy.",
    },
    CodelCode {
        code: DriftCode::UnwrittenPort,
        meaning: "No codel writes an output port, although codels have it as an `out` parameter.",
        why: "A port is published by its `write`. Without the call, a change of its `data` stays in the component, and \
              readers of the port get no data.",
        specification: "component c {\n  struct s { double x; };\n  port out s speed;\n  task t { codel<start> c_f(out speed) yield ether; };\n};\n",
        source: "genom_event c_f(const c_speed *speed, const genom_context self)\n{\n  speed->data(self)->x = 1.;\n  return c_ether;\n}\n",
        corrected: Correction::Source(
            "genom_event c_f(const c_speed *speed, const genom_context self)\n{\n  speed->data(self)->x = 1.;\n  speed->write(self);\n  return c_ether;\n}\n",
        ),
        fix: "Call `write` on the port after the change of its data, or remove the parameter from the codel. \
              Nothing is reported if the parameter is used in any other way, for example passed to a helper, or if \
              another codel writes the port.",
    },
];

/// The entry of a kind.
pub fn entry(code: DriftCode) -> Option<&'static CodelCode> {
    CODES.iter().find(|candidate| candidate.code == code)
}
