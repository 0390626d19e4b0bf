//! The functions that the specification requires: for every codel its prototype, the events it may return and
//! the exceptions it may throw.
//!
//! Rules: sections "Codels" and "Mappings" of the GenoM3 manual. The prototype is the text of
//! [`Mapper::prototype`], parsed by the reader of sources. Both sides of a comparison thus have the same
//! normalization.

use dotgen_analysis::model::{
    CodelKind, CodelRef, Component, ComponentId, Name, Owner, Port, Service, Spec, Src, State,
    TaskId, TypeId, TypeKind, UnknownDependencies,
};
use dotgen_analysis::release::Change;
use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;
use std::sync::{LazyLock, Mutex, PoisonError};

use super::source::{CType, Function, Grammar, SourceIndex};
use crate::lang::{Language, Mapper, NoPlaces};
use crate::template::throws::{service_throws, task_throws};

/// The functions that a component requires.
pub struct Expected<'a> {
    /// The model.
    pub spec: &'a Spec,
    /// Index into [`Spec::components`].
    pub component: ComponentId,
    /// Language of the codel interface (`lang`).
    pub language: Language,
    /// One for each function name, in order of first use.
    pub functions: Vec<ExpectedFunction>,
    /// Spellings of all events of the component.
    pub events: FxHashMap<SmolStr, TypeId>,
    /// Spellings of all exceptions of the specification.
    pub exceptions: FxHashMap<SmolStr, TypeId>,
    aliases: FxHashMap<SmolStr, CType>,
    /// Spellings of types whose mapping is unknown.
    opaque: FxHashSet<SmolStr>,
    /// Spellings of all types of the specification.
    named: FxHashSet<SmolStr>,
}

/// The function behind one or more codels of the same name.
#[derive(Debug, Clone)]
pub struct ExpectedFunction {
    pub name: Name,
    /// The uses in the component, in order.
    pub uses: Vec<CodelRef>,
    /// The prototype on one or more lines, without semicolon. The error is the reason why its types have no
    /// mapping.
    pub signature: Result<String, String>,
    /// The parsed prototype; `None` if it cannot be generated or parsed.
    pub shape: Option<Function>,
    /// Spellings of the events it may return in any use, `genom_ok` included.
    pub returns: FxHashSet<SmolStr>,
    /// Exceptions that it may throw in any use.
    pub throws: FxHashSet<TypeId>,
    /// The missing declarations of its parameters in any use: see [`Spec::unknown_dependencies`].
    pub awaits: UnknownDependencies,
    /// True if in some use it may throw exceptions that are unknown.
    pub may_throw_more: bool,
}

impl<'a> Expected<'a> {
    /// The functions that a component requires.
    pub fn new(spec: &'a Spec, component: ComponentId) -> Expected<'a> {
        let language = Language::of(&spec.components[component]);
        Expected::in_language(spec, component, language)
    }

    /// The functions that a component requires with codels in a given language, whatever the specification
    /// says.
    pub(crate) fn in_language(
        spec: &'a Spec,
        component: ComponentId,
        language: Language,
    ) -> Expected<'a> {
        let declaration = &spec.components[component];
        let mut out = Expected {
            spec,
            component,
            language,
            functions: Vec::new(),
            events: FxHashMap::default(),
            exceptions: FxHashMap::default(),
            aliases: FxHashMap::default(),
            opaque: FxHashSet::default(),
            named: FxHashSet::default(),
        };
        let events = declaration
            .all_codels()
            .flat_map(|at| {
                let codel = declaration.codel(at);
                codel.triggers.iter().chain(&codel.yields)
            })
            .map(|state| state.event);
        for event in events {
            let spelling = out.spelling(event);
            out.events.entry(spelling).or_insert(event);
        }
        let types = spec.types.iter_enumerated();
        for (id, ty) in types {
            match ty.kind {
                TypeKind::Exception { .. } => {
                    let spelling = out.spelling(id);
                    out.exceptions.insert(spelling, id);
                }
                TypeKind::Event | TypeKind::PauseEvent
                    if ty.scope.first().is_some_and(|scope| scope.name == declaration.name) =>
                {
                    let spelling = out.spelling(id);
                    out.events.entry(spelling).or_insert(id);
                }
                _ => {}
            }
        }
        out.collect_functions();
        out.collect_aliases();
        out.collect_opaque();
        out.collect_ports();
        out
    }

    pub fn component(&self) -> &'a Component {
        &self.spec.components[self.component]
    }

    /// A mapper to the language of the codel interface.
    pub fn mapper(&self) -> Mapper<'a> {
        Mapper::new(self.spec, &NoPlaces, self.language)
    }

    /// The name of a type, event or exception in the language.
    pub fn spelling(&self, ty: TypeId) -> SmolStr {
        self.mapper().type_cname(ty).unwrap_or_default().into()
    }

    /// `genom_ok` in the language.
    pub fn ok(&self) -> &'static str {
        match self.language {
            Language::Cxx => "genom::ok",
            _ => "genom_ok",
        }
    }

    /// The event with a pause before a state, for the event without one; `None` if the event is not a state.
    pub(crate) fn paused(&self, event: &str) -> Option<String> {
        let (paused, state) = cut_tag(event, &self.component().name);
        let scopes = event.strip_suffix(state).filter(|_| !paused)?;
        (!scopes.is_empty()).then(|| format!("{scopes}pause{}{state}", self.separator()))
    }

    /// The separator of scopes in names.
    pub fn separator(&self) -> &'static str {
        match self.language {
            Language::Cxx => "::",
            _ => "_",
        }
    }

    /// Exceptions that a codel of an owner may throw: those of the component, of the task and of the service.
    pub fn throws_of(&self, owner: Owner) -> Vec<TypeId> {
        let component = self.component();
        match owner {
            Owner::Task(task) => task_throws(component, &component.tasks[task]),
            Owner::Service(service) => service_throws(component, service),
        }
    }

    /// True if the component itself contains the declaration, so that its skeleton has it. Older releases
    /// also write declarations of interfaces.
    pub(crate) fn is_own(&self, src: Src) -> bool {
        let per_component = self.spec.release.has(Change::PerComponentSkeletons);
        let body = || self.spec.body_of(src);
        !per_component || body().is_none_or(|body| body == self.component)
    }

    /// True if the skeleton has a file for a task.
    pub(crate) fn has_file(&self, task: TaskId) -> bool {
        let declaration = &self.component().tasks[task];
        let local_codels = self.spec.release.has(Change::ExternalLocalCodels);
        let own_codels = || {
            let runs = |service: &&Service| service.task == Some(task);
            let services = self.component().services.iter().filter(runs);
            let codels = services.flat_map(|service| &service.codels);
            let mut codels = declaration.codels.iter().chain(codels);
            codels.any(|codel| self.is_own(codel.src))
        };
        self.is_own(declaration.src) || local_codels && own_codels()
    }

    /// True if the skeleton has a stub for a codel. Otherwise the function is in other sources: interfaces
    /// have sources of their own.
    pub(crate) fn has_stub(&self, at: CodelRef) -> bool {
        let component = self.component();
        self.is_own(component.codel(at).src)
            && component.task_of(at).is_none_or(|task| self.has_file(task))
    }

    pub fn function(&self, name: &str) -> Option<&ExpectedFunction> {
        self.functions.iter().find(|function| function.name == name)
    }

    /// A type with the aliases of the specification replaced by their definitions.
    pub fn canonical(&self, ty: &CType) -> CType {
        let mut ty = ty.clone();
        for _ in 0..32 {
            match self.aliases.get(&ty.base) {
                Some(alias) => ty = ty.expand(alias),
                None => break,
            }
        }
        ty
    }

    /// True if the mapping of a type is unknown, so that it agrees with any.
    pub fn is_opaque(&self, ty: &CType) -> bool {
        !self.opaque.is_empty() && self.opaque.contains(&self.canonical(ty).base)
    }

    /// True if the specification has a type of that spelling.
    pub(crate) fn has_type(&self, base: &str) -> bool {
        self.knows_type(base) || self.named.contains(base)
    }

    /// True if the specification, the language or genom3 defines the base type.
    pub(crate) fn knows_type(&self, base: &str) -> bool {
        matches!(
            base,
            "bool"
                | "float"
                | "double"
                | "char"
                | "long"
                | "void"
                | "unsigned long"
                | "long long"
                | "unsigned long long"
                | "long double"
                | "genom_context"
                | "genom_event"
                | "genom::event"
                | "std::string"
        ) || base.ends_with("_t") && base.trim_start_matches('u').starts_with("int")
            || self.aliases.contains_key(base)
    }

    fn collect_functions(&mut self) {
        let component = self.component();
        for at in component.all_codels() {
            let codel = component.codel(at);
            let returns: Vec<SmolStr> = match codel.kind {
                CodelKind::Fsm => {
                    codel.yields.iter().map(|state| self.spelling(state.event)).collect()
                }
                CodelKind::Simple | CodelKind::Validate => vec![self.ok().into()],
            };
            let throws = self.throws_of(at.owner);
            let awaits = self.spec.unknown_dependencies(self.component, codel);
            let may_throw_more = self.spec.lacks_exceptions(self.component, at.owner);
            let known = self.functions.iter_mut().find(|function| function.name == codel.name);
            let function = if let Some(known) = known {
                known
            } else {
                let signature = self.mapper().prototype(self.component, codel, " ");
                self.functions.push(ExpectedFunction {
                    name: codel.name.clone(),
                    uses: Vec::new(),
                    signature: signature.map_err(|error| error.message),
                    shape: None,
                    returns: FxHashSet::default(),
                    throws: FxHashSet::default(),
                    awaits: UnknownDependencies::default(),
                    may_throw_more: false,
                });
                let last = self.functions.len() - 1;
                &mut self.functions[last]
            };
            function.uses.push(at);
            function.returns.extend(returns);
            function.throws.extend(throws);
            function.may_throw_more |= may_throw_more;
            for (all, more) in [
                (&mut function.awaits.interfaces, awaits.interfaces),
                (&mut function.awaits.types, awaits.types),
            ] {
                for name in more {
                    if !all.contains(&name) {
                        all.push(name);
                    }
                }
            }
        }
        let signatures = self.functions.iter().map(|function| function.signature.as_deref());
        let shapes = read_prototypes(signatures.map(Result::ok), self.language);
        for (function, shape) in self.functions.iter_mut().zip(shapes) {
            function.shape = shape;
        }
    }

    /// Adds the spellings of ports. In every release, a port from `provides` has two correct spellings of its
    /// type: that of the interface and that of the component. Newer releases declare one as an alias of the
    /// other.
    fn collect_ports(&mut self) {
        for port in &self.component().ports {
            let Some(interface) = port.imported_from else {
                continue;
            };
            let theirs = self.spec.components[interface].ports.iter();
            let same = |other: &&Port| {
                other.name == port.name && other.dir == port.dir && other.ty != port.ty
            };
            for other in theirs.filter(same) {
                let (name, own) = (self.spelling(other.ty), self.spelling(port.ty));
                let own = read_prototypes(
                    std::iter::once(Some(format!("void f({own} x)").as_str())),
                    self.language,
                );
                let parameter = own.into_iter().flatten().next();
                let parameter =
                    parameter.and_then(|parameter| parameter.parameters.into_iter().next());
                if let Some(parameter) = parameter {
                    self.aliases.insert(name, parameter.ty);
                }
            }
        }
    }

    fn collect_opaque(&mut self) {
        let (mut named, mut texts) = (Vec::new(), Vec::new());
        for id in self.spec.types.keys() {
            let ty = self.spec.ty(id);
            let value = matches!(
                ty.kind,
                TypeKind::Const { .. }
                    | TypeKind::StructMember { .. }
                    | TypeKind::UnionMember { .. }
            );
            if value {
                continue;
            }
            if self.spec.opaque(id).is_some() {
                texts.extend(self.mapper().declarator(id, "x").ok());
            } else if ty.name.is_some() {
                named.push(self.spelling(id));
            }
        }
        self.named.extend(named);
        let texts: Vec<String> = texts.iter().map(|text| format!("void f({text})")).collect();
        let shapes = read_prototypes(texts.iter().map(|text| Some(text.as_str())), self.language);
        for shape in shapes.into_iter().flatten() {
            self.opaque.extend(shape.parameters.into_iter().map(|parameter| parameter.ty.base));
        }
    }

    fn collect_aliases(&mut self) {
        let mapper = self.mapper();
        let mut names = Vec::new();
        let mut texts = Vec::new();
        for (id, ty) in self.spec.types.iter_enumerated() {
            let inner = match ty.kind {
                TypeKind::Typedef { ty } => mapper.declarator(ty, "x").ok(),
                // Enumerations are integers in C.
                TypeKind::Enum { .. } if self.language == Language::C => Some("uint32_t x".into()),
                _ => None,
            };
            if let Some(inner) = inner {
                names.push(self.spelling(id));
                texts.push(format!("void f({inner})"));
            }
        }
        let shapes = read_prototypes(texts.iter().map(|text| Some(text.as_str())), self.language);
        for (name, shape) in names.into_iter().zip(shapes) {
            let parameter = shape.and_then(|shape| shape.parameters.into_iter().next());
            if let Some(parameter) = parameter
                && parameter.ty.base != name
            {
                self.aliases.insert(name, parameter.ty);
            }
        }
    }
}

/// Maximum number of prototypes that are remembered.
const MOST_PROTOTYPES: usize = 1 << 14;

/// The prototypes read so far: an edit of a specification changes few, and each is parsed like a source.
type Prototypes = FxHashMap<Grammar, FxHashMap<String, Option<Function>>>;
static PROTOTYPES: LazyLock<Mutex<Prototypes>> = LazyLock::new(Mutex::default);

/// Parses prototypes (without semicolon) with the reader of sources.
fn read_prototypes<'t>(
    texts: impl Iterator<Item = Option<&'t str>>,
    language: Language,
) -> Vec<Option<Function>> {
    let grammar = match language {
        Language::Cxx => Grammar::Cxx,
        _ => Grammar::C,
    };
    let read = |text: &str| {
        let index = SourceIndex::new(&format!("{text};\n"), grammar);
        let [function] = <[Function; 1]>::try_from(index.functions).ok()?;
        (function.known && index.loose.is_empty()).then_some(function)
    };
    let mut all = PROTOTYPES.lock().unwrap_or_else(PoisonError::into_inner);
    let known = all.entry(grammar).or_default();
    if known.len() > MOST_PROTOTYPES {
        known.clear();
    }
    let prototype = |text: Option<&str>| {
        let text = text?;
        if let Some(function) = known.get(text) {
            return function.clone();
        }
        let function = read(text);
        known.insert(text.to_owned(), function.clone());
        function
    };
    texts.map(prototype).collect()
}

/// `start` or `pause::start`, in the syntax of specifications.
pub fn state_text(state: &State) -> String {
    let pause = if state.paused { "pause::" } else { "" };
    format!("{pause}{}", state.name)
}

/// `task`, `attribute`, `function` or `activity`, and its name.
pub fn owner_words(component: &Component, owner: Owner) -> (&'static str, &Name) {
    match owner {
        Owner::Task(task) => ("task", &component.tasks[task].name),
        Owner::Service(service) => {
            let service = &component.services[service];
            let kind = service.kind.word();
            (kind, &service.name)
        }
    }
}

/// The name of an event or exception without the component and the `pause` mark: `(paused, name)`.
pub(crate) fn cut_tag<'n>(name: &'n str, component: &str) -> (bool, &'n str) {
    let name = name.strip_prefix("::").unwrap_or(name);
    let rest = name.strip_prefix(component);
    let name = rest
        .and_then(|rest| rest.strip_prefix("::").or_else(|| rest.strip_prefix('_')))
        .unwrap_or(name);
    match name.strip_prefix("pause::").or_else(|| name.strip_prefix("pause_")) {
        Some(name) => (true, name),
        None => (false, name),
    }
}
