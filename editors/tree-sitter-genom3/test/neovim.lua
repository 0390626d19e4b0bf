-- Parses files and compiles the queries in Neovim:
--
--   nvim --headless -u NONE --cmd 'set rtp+=FOLDER' --cmd 'let g:language = NAME' --cmd 'let g:list = LIST' \
--     --cmd 'let g:captures = CAPTURES' +'luafile …'
--
-- FOLDER holds `parser/NAME.so` and `queries/NAME`; LIST is a file with one path a line. Prints one line for each problem,
-- then `N parsed`. Writes the highlights to CAPTURES, as `tree-sitter query --captures` prints them.
local language = vim.g.language
local get = vim.treesitter.query and vim.treesitter.query.get or vim.treesitter.get_query

local function check(path, highlights, out)
  local file = assert(io.open(path, 'rb'))
  local text = file:read('*a')
  file:close()
  local root = vim.treesitter.get_string_parser(text, language):parse()[1]:root()
  if root:has_error() then print('error node: ' .. path .. '\n') end
  local count = 0
  out:write(path .. '\n')
  local line = '    pattern: 0, capture: %d - %s, start: (%d, %d), end: (%d, %d)\n'
  for capture, node in highlights:iter_captures(root, text, 0, -1) do
    count = count + 1
    out:write(line:format(capture, highlights.captures[capture], node:range()))
  end
  return count
end

local ok, problem = pcall(function()
  for _, name in ipairs({ 'folds', 'indents', 'locals', 'tags' }) do assert(get(language, name), name) end
  local highlights = assert(get(language, 'highlights'))
  local parsed, captures, out = 0, 0, assert(io.open(vim.g.captures, 'w'))
  for path in io.lines(vim.g.list) do
    captures = captures + check(path, highlights, out)
    parsed = parsed + 1
  end
  out:close()
  if captures == 0 then print('no highlight\n') end
  print(parsed .. ' parsed\n')
end)
if not ok then print(tostring(problem) .. '\n') end
vim.cmd('qa!')
