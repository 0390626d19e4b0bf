---@brief
---
--- https://github.com/OWNER/dotgen
---
--- Language server for GenoM3 component specifications and their verification scenarios.
---
--- Neovim needs the types of the files:
--- ```lua
--- vim.filetype.add({ extension = { gen = 'genom3', scn = 'genom3_scenario' } })
--- ```

---@type vim.lsp.Config
return {
  cmd = { 'dotgen', 'lsp' },
  filetypes = { 'genom3', 'genom3_scenario' },
  root_markers = { 'dotgen.toml', '.git' },
  before_init = function(params, config)
    params.initializationOptions = { trusted = _G.dotgen_trusted(config.root_dir or vim.fn.getcwd()) }
  end,
}
