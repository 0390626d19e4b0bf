-- Neovim's own LSP client against the server. Run by `cargo xtask test`; Neovim 0.7 and later.
--
--   DOTGEN=path/to/dotgen nvim --headless --clean -n -i NONE -u nvim.lua maneuver.gen
--
-- The working directory is a copy of examples/maneuver. Exit status 0 or 1.
local HERE = vim.fn.fnamemodify(debug.getinfo(1, 'S').source:sub(2), ':p:h')
local PLUGIN = HERE .. '/../../../editors/neovim/plugin/dotgen.lua'
local function out(text) io.stdout:write(text .. '\n') end
local function wait(what, condition)
  assert(vim.wait(20000, condition, 20), 'timed out: ' .. what)
  out('ok ' .. what)
end

local function main()
  dofile(PLUGIN)
  vim.bo.filetype = 'genom3'
  local buffer = vim.api.nvim_get_current_buf()
  local id = assert(vim.lsp.start_client({
    name = 'dotgen',
    cmd = { vim.env.DOTGEN, 'lsp' },
    root_dir = vim.fn.getcwd(),
    get_language_id = function() return 'genom3' end,
  }), 'the server did not start')
  vim.lsp.buf_attach_client(buffer, id)

  local function ask(method, params)
    local answers = assert(vim.lsp.buf_request_sync(buffer, method, params, 10000), method .. ': no answer')
    local answer = answers[id]
    assert(answer and not answer.err, method .. ': ' .. vim.inspect(answer))
    return answer.result
  end
  local function line_of(text)
    for number, line in ipairs(vim.api.nvim_buf_get_lines(buffer, 0, -1, false)) do
      if line:find(text, 1, true) then return number - 1, line end
    end
    error('no line with ' .. text)
  end
  local function errors()
    return vim.tbl_filter(function(d) return d.severity == vim.diagnostic.severity.ERROR end, vim.diagnostic.get(buffer))
  end

  wait('initialized', function()
    local client = vim.lsp.get_client_by_id(id)
    return client and client.initialized
  end)
  local document = vim.lsp.util.make_text_document_params(buffer)

  -- What the file holds.
  local symbols = ask('textDocument/documentSymbol', { textDocument = document })
  local function names(list, into)
    for _, symbol in ipairs(list or {}) do
      into[symbol.name] = true
      names(symbol.children, into)
    end
    return into
  end
  local found = names(symbols, {})
  assert(found.maneuver and found["goto"] and found.exec, vim.inspect(found))
  out('ok document symbols')
  assert(#errors() == 0, vim.inspect(errors()))

  -- The picture of what is at the cursor, as text, by the plugin of editors/neovim.
  vim.api.nvim_win_set_cursor(0, { line_of('activity goto') + 1, 12 })
  vim.cmd('DotgenDiagram')
  local function picture() return table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), '\n') end
  wait('picture as Mermaid', function() return picture():find('^flowchart TD\n') end)
  assert(picture():find('mv_goto_plan', 1, true), picture())
  vim.cmd('close')

  -- A typed error, and its correction.
  local row, line = line_of('yield ether wcet 4 us;')
  vim.api.nvim_buf_set_lines(buffer, row, row + 1, false, { line .. ' oops' })
  wait('an error is reported', function() return #errors() > 0 end)
  local diagnostic = errors()[1]
  assert(diagnostic.lnum == row or diagnostic.lnum == row + 1, vim.inspect(diagnostic))
  assert(diagnostic.source == 'dotgen' and diagnostic.message ~= '', vim.inspect(diagnostic))
  vim.api.nvim_buf_set_lines(buffer, row, row + 1, false, { line })
  wait('the error is gone', function() return #errors() == 0 end)

  -- Where an include leads.
  local include, text = line_of('#include')
  local target = ask('textDocument/definition', {
    textDocument = document,
    position = { line = include, character = text:find('pose/') },
  })
  target = target[1] or target
  assert((target.uri or target.targetUri):find('idl/or/pose/pose_estimator.gen$'), vim.inspect(target))
  out('ok definition of an include')

  -- Folding, through the request a plugin would send.
  assert(#ask('textDocument/foldingRange', { textDocument = document }) > 3)
  out('ok folding ranges')

  -- Where a name is declared and used, in this file and others.
  local port, declared = line_of('or_pose_estimator::state state')
  local at = { line = port, character = declared:find('::state', 1, true) + 3 }
  target = ask('textDocument/definition', { textDocument = document, position = at })
  target = target[1] or target
  assert((target.uri or target.targetUri):find('idl/or/pose', 1, true), vim.inspect(target))
  out('ok definition of a type')
  local references = ask('textDocument/references', { textDocument = document, position = at, context = { includeDeclaration = true } })
  assert(#references > 4, vim.inspect(references))
  out('ok references')

  -- Another name for a state, as Neovim applies it.
  row, line = line_of('codel<wait> mv_exec_wait')
  vim.api.nvim_win_set_cursor(0, { row + 1, (line:find('wait', 1, true)) })
  vim.lsp.buf.rename('idle')
  wait('the state has its new name', function()
    local text = table.concat(vim.api.nvim_buf_get_lines(buffer, 0, -1, false), '\n')
    return text:find('codel<idle> mv_exec_wait', 1, true) and text:find('yield pause::idle, main', 1, true) and true
  end)
  wait('and no error', function() return #errors() == 0 end)

  vim.lsp.stop_client(id)
  wait('the server stopped', function() return vim.lsp.get_client_by_id(id) == nil end)
end

-- After start-up, and with errors caught: one here would leave a headless Neovim running for ever.
vim.defer_fn(function()
  local ok, message = xpcall(main, debug.traceback)
  if not ok then
    io.stderr:write('FAIL ' .. tostring(message) .. '\n')
    vim.cmd('cquit 1')
  end
  vim.cmd('qall!')
end, 0)
