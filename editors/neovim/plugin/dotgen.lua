vim.filetype.add({ extension = { gen = 'genom3', scn = 'genom3_scenario' } })

-- Executes a command of the server; the result goes to `use`.
local function execute(command, argument, use)
  local request = { command = command, arguments = { argument } }
  vim.lsp.buf_request(0, 'workspace/executeCommand', request, function(err, result)
    if err then return vim.notify(err.message, vim.log.levels.WARN) end
    if use then use(result) end
  end)
end

-- :DotgenDiagram [mermaid|dot] [fsm|system|locks]: draws the machine at the cursor, or the system.
vim.api.nvim_create_user_command('DotgenDiagram', function(arguments)
  local form, kind = arguments.fargs[1] or 'mermaid', arguments.fargs[2] or 'fsm'
  local at = vim.lsp.util.make_position_params(0, 'utf-16')
  local argument = { textDocument = at.textDocument, position = at.position, kind = kind }
  execute('dotgen.diagram.' .. form, argument, function(text)
    if type(text) ~= 'string' then
      return vim.notify('There is nothing to draw here.', vim.log.levels.WARN)
    end
    vim.cmd('new')
    vim.bo.buftype, vim.bo.filetype = 'nofile', form
    vim.api.nvim_buf_set_lines(0, 0, -1, false, vim.split(text, '\n'))
  end)
end, { nargs = '*' })

-- :DotgenGenerate runs a template; the server asks for it. :DotgenRegenerate repeats those of this file.
vim.api.nvim_create_user_command('DotgenGenerate', function()
  execute('dotgen.generate', { uri = vim.uri_from_bufnr(0) })
end, {})
vim.api.nvim_create_user_command('DotgenRegenerate', function()
  execute('dotgen.regenerate', { uri = vim.uri_from_bufnr(0) })
end, {})
