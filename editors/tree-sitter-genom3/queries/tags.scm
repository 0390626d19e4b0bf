(component name: (identifier) @name) @definition.class
(interface name: (identifier) @name) @definition.interface
(module name: (identifier) @name) @definition.module
(task name: (identifier) @name) @definition.module
(port name: (identifier) @name) @definition.field
(attribute name: (identifier) @name) @definition.method
(function name: (identifier) @name) @definition.method
(activity name: (identifier) @name) @definition.method
(constant name: (identifier) @name) @definition.constant
(enumerator name: (identifier) @name) @definition.constant
(typedef declarator: (declarator name: (identifier) @name)) @definition.type
(native name: (identifier) @name) @definition.type
(exception name: (identifier) @name) @definition.type
(struct name: (identifier) @name) @definition.type
(union name: (identifier) @name) @definition.type
(enum name: (identifier) @name) @definition.type
(preproc_define name: (identifier) @name) @definition.macro

(codel_property name: (identifier) @name) @reference.call
(validate_property name: (identifier) @name) @reference.call
(services_property service: (identifier) @name) @reference.call
(interfaces_property interface: (identifier) @name) @reference.implementation
(task_property task: (identifier) @name) @reference.class
(named_type (scoped_name name: (identifier) @name)) @reference.type
(throws_property exception: (scoped_name name: (identifier) @name)) @reference.type
