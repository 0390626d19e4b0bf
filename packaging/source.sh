#!/bin/sh
# source.sh OUT: the source archive of a release, OUT/dotgen-VERSION.tar.gz, of the current commit.
#
# Contains the sources of all dependencies in vendor/, so that builds of distributions need no network.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$root"
version=$(sed -n '/^\[workspace.package\]/,/^\[workspace.dep/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT

git archive --prefix="dotgen-$version/" HEAD | tar -C "$stage" -xf -
cd "$stage/dotgen-$version"
cargo vendor --locked vendor >"$stage/sources.toml"
{
  echo
  cat "$stage/sources.toml"
} >>.cargo/config.toml
tar -C "$stage" -czf "$out/dotgen-$version.tar.gz" "dotgen-$version"
echo "$out/dotgen-$version.tar.gz"
