; Scopes

[
  (source_file)
  (component_body)
  (module_body)
  (attribute)
  (function)
  (activity)
  (codel_parameters)
  (struct)
  (union)
  (ids)
] @local.scope

; Definitions

(component name: (identifier) @local.definition)
(interface name: (identifier) @local.definition)
(module name: (identifier) @local.definition)
(task name: (identifier) @local.definition)
(port name: (identifier) @local.definition)
(attribute name: (identifier) @local.definition)
(function name: (identifier) @local.definition)
(activity name: (identifier) @local.definition)
(constant name: (identifier) @local.definition)
(enumerator name: (identifier) @local.definition)
(typedef declarator: (declarator name: (identifier) @local.definition))
(native name: (identifier) @local.definition)
(exception name: (identifier) @local.definition)
(struct name: (identifier) @local.definition)
(union name: (identifier) @local.definition)
(enum name: (identifier) @local.definition)
(member declarator: (declarator name: (identifier) @local.definition))
(case declarator: (declarator name: (identifier) @local.definition))
(parameter declarator: (declarator name: (identifier) @local.definition))
(local_property declarator: (declarator name: (identifier) @local.definition))
(preproc_define name: (identifier) @local.definition)

; References

(scoped_name (identifier) @local.reference)
(path name: (identifier) @local.reference)
(interfaces_property interface: (identifier) @local.reference)
(services_property service: (identifier) @local.reference)
(task_property task: (identifier) @local.reference)
(macro_call name: (identifier) @local.reference)
(macro_statement name: (identifier) @local.reference)
(text (identifier) @local.reference)
