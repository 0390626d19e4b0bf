; `indent.…` are the names of Neovim, `indent` and `outdent` those of Helix.

[
  (component_body)
  (module_body)
  (property_list)
  (member_list)
  (case_list)
  (enumerator_list)
  (initializer_list)
  (parameters)
  (attribute_parameters)
  (codel_parameters)
  (codel_property)
  (validate_property)
  (local_property)
  (throws_property)
  (services_property)
] @indent.begin @indent

["}" ")"] @indent.branch @indent.end @outdent

[
  (comment)
  (string)
  (inactive)
] @indent.auto

["#include" "#define" "#undef" "#ifdef" "#ifndef" "#if" "#elif" "#else" "#endif" "#error" "#warning" "#pragma"] @indent.zero
