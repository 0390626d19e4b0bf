#!/bin/sh
# Writes the parsers of both grammars, and their checksums. Version 14 of tree-sitter's parser format is what every current
# editor reads.
#
#   ./generate.sh [FOLDER]    FOLDER: a copy of this folder; by default this folder
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=${TREE_SITTER:-}
if [ -z "$program" ]; then
  program=$here/node_modules/.bin/tree-sitter
  [ -x "$here/node_modules/tree-sitter-cli/tree-sitter" ] || program=tree-sitter
fi
cd "${1:-$here}"
for grammar in . scenario; do
  (cd $grammar && "$program" generate --abi 14)
done
find grammar.js src scenario/grammar.js scenario/src -type f ! -name scanner.c | LC_ALL=C sort | xargs sha256sum >checksums.txt
