[
  (scenario_body)
  (client)
] @local.scope

(client name: (identifier) @local.definition)
(send label: (label) @local.definition)
(check name: (label) @local.definition)

(path . (identifier) @local.reference)
