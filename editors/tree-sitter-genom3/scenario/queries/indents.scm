; `indent.…` are the names of Neovim, `indent` and `outdent` those of Helix.

[
  (scenario_body)
  (steps)
  (check)
] @indent.begin @indent

"}" @indent.branch @indent.end @outdent

(comment) @indent.auto
