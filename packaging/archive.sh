#!/bin/sh
# archive.sh PROGRAM TARGET OUT: the archive of a release, OUT/dotgen-TARGET.tar.gz.
#
# Contains the program, its manual in the place where the program searches it, pages for man, completions for
# shells, and the licences. The program must run on this machine.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
program=$1 target=$2 out=$3
name=dotgen-$target
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
folder=$stage/$name

mkdir -p "$folder/docs" "$folder/man" "$folder/completions" "$out"
cp "$program" "$folder/dotgen"
cp "$root/LICENSE" "$root/THIRD-PARTY-NOTICES.txt" "$root/README.md" "$root/CHANGELOG.md" "$folder"
cp -R "$root/docs/." "$folder/docs"
"$folder/dotgen" man "$folder/man" >/dev/null
for shell in bash zsh fish; do
  "$folder/dotgen" completions "$shell" >"$folder/completions/dotgen.$shell"
done
tar -C "$stage" -czf "$out/$name.tar.gz" "$name"
echo "$out/$name.tar.gz"
