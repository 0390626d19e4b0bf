[
  (scenario_body)
  (steps)
  (comment)
] @fold
