//! Names of ROS 2 for names of GenoM3.

use dotgen_analysis::model::{ScopeKind, Spec, TypeId};

/// The package of types that are declared outside modules.
const GLOBAL: &str = "genom_global";

/// Packages of ROS 2 whose types are used.
const STANDARD: [&str; 8] = [
    "action_msgs",
    "builtin_interfaces",
    "geometry_msgs",
    "nav_msgs",
    "sensor_msgs",
    "service_msgs",
    "std_msgs",
    "unique_identifier_msgs",
];

/// Words that are not names of packages and fields, because the generated C++ or Python would not compile.
const KEYWORDS: &str = " \
     alignas alignof and and_eq as asm assert async auto await bitand bitor bool break case catch char \
     char8_t char16_t char32_t class co_await co_return co_yield compl concept const const_cast consteval \
     constexpr constinit continue decltype def default del delete do double dynamic_cast elif else enum \
     except explicit export extern false finally float for friend from global goto if import in inline \
     int is lambda long mutable namespace new noexcept nonlocal not not_eq nullptr operator or or_eq pass \
     private protected public raise register reinterpret_cast requires restrict return short signed \
     sizeof static static_assert static_cast struct switch template this thread_local throw true try \
     typedef typeid typename union unsigned using virtual void volatile wchar_t while with xor xor_eq \
     yield ";

/// Macros that end the compilation of generated C and C++ if fields or packages have their names.
const MACROS: &str = " errno linux unix ";

/// Targets of every build with CMake and ament. A package has a target of its own name.
const TARGETS: &str = " all clean edit_cache help install preinstall rebuild_cache test uninstall ";

/// Macros of headers that generated C++, or a program that includes it, includes.
const UPPER_CASE_MACROS: &str = include_str!("macros.txt");

/// Words in lower case with single `_` between them: a word begins at `_`, and at an upper case letter that
/// follows a lower case letter or digit.
fn snake(name: &str) -> String {
    let mut out = String::new();
    let mut before = '_';
    for c in name.chars() {
        let begins =
            c.is_ascii_uppercase() && (before.is_ascii_lowercase() || before.is_ascii_digit());
        if (begins || c == '_') && !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
        if c != '_' {
            out.push(c.to_ascii_lowercase());
        }
        before = c;
    }
    out.truncate(out.trim_end_matches('_').len());
    out
}

/// The begin of a message about a name.
fn becomes(of: &str, name: &str) -> String {
    if of == name { format!("`{name}` is") } else { format!("`{of}` becomes `{name}`,") }
}

/// The name if it can be used.
fn checked(name: String, of: &str) -> Result<String, String> {
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        return Err(format!("`{of}` has no name in ROS 2: begin it with a letter"));
    }
    let word = format!(" {name} ");
    let kind = if KEYWORDS.contains(&word) {
        "keyword of C++ or Python"
    } else if MACROS.contains(&word) {
        "macro of C"
    } else {
        return Ok(name);
    };
    let becomes = becomes(of, &name);
    Err(format!("{becomes} a {kind}: rename it"))
}

/// The package of a path of modules: `or_t3d`.
///
/// # Errors
/// In words: the name is a keyword, a macro, a package of ROS 2 or a target of CMake, or does not begin with
/// a letter.
pub fn package<'n>(modules: impl IntoIterator<Item = &'n str>) -> Result<String, String> {
    let modules: Vec<&str> = modules.into_iter().collect();
    if modules.is_empty() {
        return Ok(GLOBAL.to_owned());
    }
    let path = modules.join("::");
    let name = checked(snake(&modules.join("_")), &path)?;
    let kind = if STANDARD.contains(&name.as_str()) {
        "package of ROS 2"
    } else if TARGETS.contains(&format!(" {name} ")) {
        "target of CMake"
    } else {
        return Ok(name);
    };
    let becomes = becomes(&path, &name);
    Err(format!("{becomes} a {kind}: rename it"))
}

/// The name of a field: `max_speed`.
///
/// # Errors
/// In words: the name is a keyword or a macro, or does not begin with a letter.
pub fn field(name: &str) -> Result<String, String> {
    checked(snake(name), name)
}

/// The name of a constant: `MAX_SPEED`.
///
/// # Errors
/// In words: the name does not begin with a letter.
pub fn constant(name: &str) -> Result<String, String> {
    let out = snake(name).to_ascii_uppercase();
    if out.starts_with(|c: char| c.is_ascii_uppercase()) {
        Ok(out)
    } else {
        Err(format!("`{name}` has no name in ROS 2: begin it with a letter"))
    }
}

/// Returns true for the name of a macro, which generated C++ cannot declare as a constant.
pub(crate) fn is_macro(constant: &str) -> bool {
    UPPER_CASE_MACROS.split_whitespace().any(|word| word == constant)
}

/// The generated files of a message, service or action: `demo/msg/max_speed` for `demo/msg/MaxSpeed`, but
/// `demo/msg/ab` for both `AB` and `Ab`.
pub(crate) fn files(name: &str) -> String {
    let (folder, local) = name.rsplit_once('/').unwrap_or_default();
    let mut out = format!("{folder}/");
    let mut before: Option<char> = None;
    let mut rest = local.chars().peekable();
    while let Some(c) = rest.next() {
        let follows_word = before.is_some_and(|letter| !letter.is_ascii_uppercase());
        let begins_word = before.is_some() && rest.peek().is_some_and(char::is_ascii_lowercase);
        if c.is_ascii_uppercase() && (follows_word || begins_word) {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
        before = Some(c);
    }
    out
}

/// The local name of a message, service or action: `MaxSpeed`.
///
/// # Errors
/// In words: the name does not begin with a letter.
pub fn camel(name: &str) -> Result<String, String> {
    let mut out = String::new();
    for word in name.split('_') {
        let mut letters = word.chars();
        out.extend(letters.next().map(|letter| letter.to_ascii_uppercase()));
        out.extend(letters);
    }
    if out.starts_with(|c: char| c.is_ascii_uppercase()) {
        Ok(out)
    } else {
        Err(format!("`{name}` has no name in ROS 2: begin it with a letter"))
    }
}

/// The local name of a service or action.
///
/// # Errors
/// In words: its class in C++ has a member of this name, or the name does not begin with a letter.
pub fn service(name: &str, is_action: bool) -> Result<String, String> {
    let local = camel(name)?;
    let members: &[&str] = if is_action {
        &["Feedback", "Goal", "Impl", "Result"]
    } else {
        &["Event", "Request", "Response"]
    };
    if members.contains(&local.as_str()) {
        Err(format!("`{name}` becomes `{local}`, a member of its class in C++: rename it"))
    } else {
        Ok(local)
    }
}

/// Package and local name of a type that has a name: `or_t3d` and `Pos`.
///
/// # Errors
/// In words: ROS 2 has no such name.
pub fn of_type(spec: &Spec, ty: TypeId) -> Result<(String, String), String> {
    let ty = spec.ty(ty);
    let is_module = |kind| kind == ScopeKind::Module;
    let modules = ty.scope.iter().filter(|scope| is_module(scope.kind));
    let package = package(modules.map(|scope| scope.name.as_str()))?;
    let around = ty.scope.iter().filter(|scope| !is_module(scope.kind));
    let mut local = String::new();
    for name in around.map(|scope| &scope.name).chain(&ty.name) {
        local += &camel(name)?;
    }
    Ok((package, local))
}

/// The name of a topic, service or action: `/demo/pose`, or `/demo/pose/left` for an instance.
///
/// # Errors
/// In words: a part is not a name in ROS 2.
pub fn topic<'n>(parts: impl IntoIterator<Item = &'n str>) -> Result<String, String> {
    let mut out = String::new();
    for part in parts {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if part.is_empty()
            || part.starts_with(|c: char| c.is_ascii_digit())
            || !part.chars().all(allowed)
        {
            return Err(format!(
                "`{part}` is not a name in ROS 2: use letters, digits and `_`, and begin with a letter"
            ));
        }
        out.push('/');
        out += part;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_the_rules_of_ros() {
        assert_eq!(package(["or", "t3d"]).as_deref(), Ok("or_t3d"));
        assert_eq!(package(["Big__Arm_"]).as_deref(), Ok("big_arm"));
        assert_eq!(package([]).as_deref(), Ok("genom_global"));
        assert_eq!(field("posXY").as_deref(), Ok("pos_xy"));
        assert_eq!(field("_d").as_deref(), Ok("d"));
        assert_eq!(camel("rigid_body").as_deref(), Ok("RigidBody"));
        assert_eq!(camel("t3D").as_deref(), Ok("T3D"));
        assert_eq!(constant("notReady").as_deref(), Ok("NOT_READY"));
        assert_eq!(topic(["demo", "pose"]).as_deref(), Ok("/demo/pose"));
    }

    #[test]
    fn generated_files_have_the_names_of_rosidl() {
        for (local, stem) in [
            ("MaxSpeed", "max_speed"),
            ("AB", "ab"),
            ("Ab", "ab"),
            ("SetHTTP", "set_http"),
            ("HTTPGet", "http_get"),
            ("T3D", "t3_d"),
            ("T3d", "t3d"),
            ("AaBbCc", "aa_bb_cc"),
        ] {
            assert_eq!(files(&format!("a/msg/{local}")), format!("a/msg/{stem}"));
        }
    }

    #[test]
    fn macros_are_not_constants() {
        assert!(is_macro("EOF") && is_macro("NAN") && is_macro("SIGINT"));
        assert!(!is_macro("OFF") && !is_macro("AUTO"));
    }

    #[test]
    fn names_that_cannot_be_used_are_refused() {
        for name in ["or", "class", "from", "linux", "_1"] {
            assert!(field(name).is_err(), "{name}");
            assert!(package([name]).is_err(), "{name}");
        }
        assert!(package(["test"]).is_err() && field("test").is_ok());
        assert!(service("goal", true).is_err() && service("goal", false).is_ok());
        assert!(service("request", false).is_err() && service("request", true).is_ok());
        assert!(constant("_1").is_err() && camel("_1").is_err());
        for part in ["", "1", "a-b", "a/b", "*"] {
            assert!(topic(["demo", part]).is_err(), "{part}");
        }
    }
}
