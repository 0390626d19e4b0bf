vim.filetype.add({ extension = { gen = 'genom3', scn = 'genom3_scenario' } })

-- True if the server may run programs for a folder. Asks once; the answers are in the folder of data.
function _G.dotgen_trusted(folder)
  local path = vim.fn.stdpath('data') .. '/dotgen-trust.json'
  local read, lines = pcall(vim.fn.readfile, path)
  local parsed, answers = pcall(vim.fn.json_decode, read and lines or '{}')
  if not parsed or type(answers) ~= 'table' then answers = {} end
  if answers[folder] == nil and #vim.api.nvim_list_uis() > 0 then
    local question = 'Let dotgen run pkg-config and templates of ' .. folder .. '?'
    answers[folder] = vim.fn.confirm(question, '&Yes\n&No', 2) == 1
    vim.fn.mkdir(vim.fn.stdpath('data'), 'p')
    vim.fn.writefile({ vim.fn.json_encode(answers) }, path)
  end
  return answers[folder] == true
end

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
