#!/bin/bash
# Downloads a release of dotgen, compares its checksum and puts the program on PATH. Part of action.yml.
#
# DOTGEN_VERSION is v1.2.3, 1.2.3 or latest. DOTGEN_RELEASES is the address of the releases.
set -euo pipefail

case $(uname -s)-$(uname -m) in
  Linux-x86_64) target=x86_64-unknown-linux-gnu ;;
  Linux-aarch64) target=aarch64-unknown-linux-gnu ;;
  Darwin-arm64) target=aarch64-apple-darwin ;;
  Darwin-x86_64) target=x86_64-apple-darwin ;;
  *)
    echo "::error::no release of dotgen for $(uname -s) $(uname -m); runners with Linux or macOS have one"
    exit 2
    ;;
esac
case $DOTGEN_VERSION in
  latest) from=$DOTGEN_RELEASES/latest/download ;;
  v*) from=$DOTGEN_RELEASES/download/$DOTGEN_VERSION ;;
  *) from=$DOTGEN_RELEASES/download/v$DOTGEN_VERSION ;;
esac

into=${RUNNER_TEMP:?}/dotgen
archive=dotgen-$target.tar.gz
mkdir -p "$into"
cd "$into"
for file in "$archive" SHA256SUMS; do
  if ! curl -fsSL --retry 3 -o "$file" "$from/$file"; then
    echo "::error::no dotgen $DOTGEN_VERSION at $from/$file"
    exit 2
  fi
done
sums=sha256sum
command -v sha256sum >/dev/null || sums="shasum -a 256"
if ! grep " [ *]\?$archive\$" SHA256SUMS >wanted; then
  echo "::error::SHA256SUMS has no line for $archive"
  exit 2
fi
$sums -c wanted
tar -xzf "$archive"

program=$into/dotgen-$target
version=$("$program/dotgen" --version)
echo "$version"
echo "$program" >>"$GITHUB_PATH"
echo "version=$version" >>"$GITHUB_OUTPUT"
