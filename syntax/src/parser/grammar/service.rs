//! Attributes, functions and activities.

use super::*;

// test service
// component c {
//   attribute set(in speed = 1.0 : "m/s", inout v.x);
//   function f(in long a, out m::t b[3]) { doc "text"; };
//   activity a() { task t; local long x; };
//   function function(in in in);
// };
pub(super) fn service(p: &mut Parser<'_>) {
    let m = p.start();
    let (params, what) = match p.current_contextual() {
        ATTRIBUTE_KW => (param::Params::Attribute, "this attribute"),
        FUNCTION_KW => (param::Params::Service, "this function"),
        _ => (param::Params::Service, "this activity"),
    };
    p.bump_contextual();
    if property::unless_item(p, name) {
        param::param_list(p, params);
    }
    property::properties(p, what);
    semicolon(p, what);
    m.complete(p, SERVICE);
}
