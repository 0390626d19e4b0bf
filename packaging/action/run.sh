#!/bin/bash
# Runs the commands of dotgen that a workflow names, all of them even if one fails. Part of action.yml.
set -uo pipefail

here=$(cd "$(dirname "$0")" && pwd)
reports=${RUNNER_TEMP:?}/dotgen-reports
mkdir -p "$reports"
# The inputs are lists of words.
read -ra commands <<<"$(tr '\n,' '  ' <<<"$COMMANDS")"
read -ra paths <<<"$(tr '\n' ' ' <<<"$PATHS")"
read -ra scenarios <<<"$(tr '\n' ' ' <<<"$SCENARIOS")"
read -ra options <<<"$(tr '\n' ' ' <<<"$OPTIONS")"
deny=()
if [ "$DENY_MISSING" = true ]; then
  deny=(--deny missing)
fi
failed=0

# section TITLE COMMAND…: runs a command below a title that can be folded. Returns its exit status.
section() {
  local status
  echo "::group::$1"
  shift
  "$@"
  status=$?
  echo "::endgroup::"
  return "$status"
}

# sarif NAME COMMAND…: if SARIF is true, writes the findings as SARIF, and their file as the output NAME-sarif.
sarif() {
  [ "${SARIF:-false}" = true ] || return 0
  local name=$1 file
  file=$reports/$1.sarif
  shift
  "$@" --format sarif >"$file" 2>/dev/null
  if [ -s "$file" ]; then
    echo "$name-sarif=$file" >>"$GITHUB_OUTPUT"
  fi
}

# result NAME STATUS: reports a failed command.
result() {
  case $2 in
    0) echo "dotgen $1: passed" ;;
    *)
      echo "::error::dotgen $1 failed with exit status $2"
      failed=1
      ;;
  esac
}

verify() {
  local status
  if [ ${#scenarios[@]} = 0 ]; then
    while IFS= read -r -d '' file; do
      scenarios+=("$file")
    done < <(git ls-files -z -- "${paths[@]}" | grep -z '\.scn$')
  fi
  if [ ${#scenarios[@]} = 0 ]; then
    echo "::notice::dotgen verify: no scenario (.scn) below ${paths[*]}"
    return
  fi
  section "dotgen verify" \
    dotgen verify --color never --timeout "$TIMEOUT" ${options[@]+"${options[@]}"} "${scenarios[@]}"
  status=$?
  if [ "$status" = 3 ] && [ "$UNANSWERED" = warn ]; then
    echo "::warning::dotgen verify: a check was given up or had nothing to verify"
    return
  fi
  result verify "$status"
}

echo "::add-matcher::$here/matcher.json"
for command in "${commands[@]}"; do
  case $command in
    check)
      run=(dotgen check ${deny[@]+"${deny[@]}"} ${options[@]+"${options[@]}"} "${paths[@]}")
      section "dotgen check" "${run[@]}" --color never
      result check $?
      sarif check "${run[@]}"
      ;;
    fmt)
      section "dotgen fmt --check" dotgen fmt --check --color never "${paths[@]}"
      result fmt $?
      ;;
    codels)
      run=(dotgen codels check ${options[@]+"${options[@]}"} "${paths[@]}")
      section "dotgen codels check" "${run[@]}" --color never
      result codels $?
      sarif codels "${run[@]}"
      ;;
    verify) verify ;;
    *)
      echo "::error::no command '$command' in this action; there are check, fmt, codels and verify"
      failed=1
      ;;
  esac
done
echo "::remove-matcher owner=dotgen::"
exit "$failed"
