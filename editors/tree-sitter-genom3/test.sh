#!/bin/bash
# Tests both grammars. Exit status 1: a test failed; 2: a needed program is missing.
#
#   TREE_SITTER             the program; by default the one that `npm ci` installs, then the one on the path
#   DOTGEN_SPECIFICATIONS   more folders of specifications to parse, separated by `:`
#   DOTGEN                  dotgen's program; if set, files in which `dotgen check` finds errors are left out
#
# Without `tree-sitter`, Neovim parses the files and compiles the queries; the trees of test/corpus and the tags are not
# compared.
set -uo pipefail
cd "$(dirname "$0")"
here=$PWD
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
passed=0 failed=0 skipped=0
pass() { passed=$((passed + ${1:-1})); }
fail() {
  failed=$((failed + 1))
  echo "FAILED: $*" >&2
}
skip() {
  skipped=$((skipped + 1))
  echo "skipped: $*"
}

version=$(sed -n 's/.*"tree-sitter-cli": "\(.*\)".*/\1/p' package.json)
export TREE_SITTER=${TREE_SITTER:-}
if [ -z "$TREE_SITTER" ]; then
  TREE_SITTER=$here/node_modules/.bin/tree-sitter
  [ -x "$here/node_modules/tree-sitter-cli/tree-sitter" ] || TREE_SITTER=tree-sitter
fi
found=$("$TREE_SITTER" --version 2>/dev/null)
[[ $found == "tree-sitter $version"* ]] && has_program=1 || has_program=
if command -v nvim >/dev/null && command -v cc >/dev/null; then has_neovim=1; else has_neovim=; fi
missing="tree-sitter $version is missing (found: ${found:-none}): run \`npm ci\` or \`cargo install tree-sitter-cli@$version\`"
if [ -z "$has_program$has_neovim" ]; then
  echo "$missing" >&2
  exit 2
fi
# The user's settings and compiled parsers are not used.
export XDG_CACHE_HOME=$temporary/cache XDG_CONFIG_HOME=$temporary/xdg TREE_SITTER_DIR=$temporary/config
mkdir -p "$TREE_SITTER_DIR"
echo "{\"parser-directories\": [\"$(dirname "$here")\"]}" >"$TREE_SITTER_DIR/config.json"

# ---- The files to parse

specifications() { find "$1" -type d -name target -prune -o -type f \( -name '*.gen' -o -name '*.idl' \) -print | sort; }
examples=$(realpath ../../examples)
specifications "$examples" >"$temporary/specifications"
IFS=: read -ra folders <<<"${DOTGEN_SPECIFICATIONS:-}"
for folder in "${folders[@]}"; do
  [ -d "$folder" ] || fail "DOTGEN_SPECIFICATIONS: $folder is not a folder"
  specifications "$(realpath "$folder")" | while read -r file; do
    if [ -z "${DOTGEN:-}" ] || "$DOTGEN" check "$file" >/dev/null 2>&1; then echo "$file"; fi
  done
done >>"$temporary/specifications"
find "$examples" -name '*.scn' | sort >"$temporary/scenarios"
[ -s "$temporary/specifications" ] && [ -s "$temporary/scenarios" ] || fail "no example was found"
files() { if [ "$1" = . ]; then echo "$temporary/specifications"; else echo "$temporary/scenarios"; fi; }

# ---- The generated files are up to date

if sha256sum --check --quiet checksums.txt; then pass; else fail "the parsers are out of date: run ./generate.sh"; fi
if [ "$has_program" ]; then
  mkdir -p "$temporary/new/scenario"
  cp -r grammar.js tree-sitter.json package.json src "$temporary/new"
  cp -r scenario/grammar.js scenario/src "$temporary/new/scenario"
  if ./generate.sh "$temporary/new" && diff -rq src "$temporary/new/src" && diff -rq scenario/src "$temporary/new/scenario/src"; then
    pass
  else
    fail "the parsers are not what ./generate.sh writes"
  fi
else
  skip "$missing"
fi

# ---- Trees, error nodes, queries and highlights, with the program

test_with_program() { # GRAMMAR
  local query line
  if (cd "$1" && "$TREE_SITTER" test) >"$temporary/test" 2>&1; then
    pass "$(grep -c '✓' "$temporary/test")"
  else
    cat "$temporary/test" >&2
    fail "test/corpus of $1"
  fi
  if (cd "$1" && "$TREE_SITTER" parse --quiet --paths "$(files "$1")") >"$temporary/parse" 2>&1; then
    pass "$(wc -l <"$(files "$1")")"
  else
    grep -E 'ERROR|MISSING|rror:' "$temporary/parse" >"$temporary/errors" || cp "$temporary/parse" "$temporary/errors"
    while read -r line; do fail "$line"; done <"$temporary/errors"
  fi
  if "$TREE_SITTER" tags --paths "$(files "$1")" >"$temporary/tags" 2>"$temporary/errors" && [ -s "$temporary/tags" ]; then
    pass
  else
    cat "$temporary/errors" >&2
    fail "tags of $1"
  fi
  for query in "$1"/queries/*.scm; do
    if (cd "$1" && "$TREE_SITTER" query --captures --paths "$(files "$1")" "$here/$query") >"$temporary/captures" 2>"$temporary/errors"; then
      pass
    else
      cat "$temporary/errors" >&2
      fail "$query"
    fi
    if [[ $query == */highlights.scm ]]; then
      if node test/highlights.mjs "$temporary/captures" "$1"; then pass; else fail "$query"; fi
    fi
  done
}
if [ "$has_program" ]; then
  for grammar in . scenario; do test_with_program "$grammar"; done
fi

# ---- Error nodes, queries and highlights, in Neovim

test_in_neovim() { # GRAMMAR LANGUAGE
  local folder=$temporary/neovim sources=("$1/src/parser.c") line
  [ -f "$1/src/scanner.c" ] && sources+=("$1/src/scanner.c")
  mkdir -p "$folder/parser" "$folder/queries"
  cp -r "$1/queries" "$folder/queries/$2"
  if ! cc -std=c11 -O1 -shared -fPIC -I "$1/src" "${sources[@]}" -o "$folder/parser/$2.so"; then
    fail "the parser $2 does not compile"
    return
  fi
  timeout 120 nvim --headless -u NONE --cmd "set rtp+=$folder" --cmd "let g:language = '$2'" \
    --cmd "let g:list = '$(files "$1")'" --cmd "let g:captures = '$temporary/captures'" +"luafile $here/test/neovim.lua" >"$temporary/output" 2>&1
  grep -vE '^\s*$|^[0-9]+ parsed\s*$' "$temporary/output" >"$temporary/errors"
  if [ -s "$temporary/errors" ] || ! grep -qE '^[1-9][0-9]* parsed' "$temporary/output"; then
    cat "$temporary/errors" >&2
    fail "$2 in Neovim"
  else
    pass
  fi
  if node test/highlights.mjs "$temporary/captures" "$1"; then pass; else fail "the highlights of $2"; fi
}
if [ "$has_neovim" ]; then
  test_in_neovim . genom3
  test_in_neovim scenario genom3_scenario
else
  skip "Neovim or a C compiler is missing"
fi

echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
