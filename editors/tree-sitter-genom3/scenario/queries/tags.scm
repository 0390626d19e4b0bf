(scenario name: (identifier) @name) @definition.class
(client name: (identifier) @name) @definition.function
(check name: (label) @name) @definition.constant

(send service: (path (identifier) @name .)) @reference.call
