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
  (comment)
  (inactive)
] @fold
