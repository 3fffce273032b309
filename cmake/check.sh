#!/usr/bin/env bash
# Formatting, lint and types. Only looks; with --apply it formats instead. One line a check; exit 1 if any fails.
set -uo pipefail
cd "$(dirname "$0")/.."
tools=build/venv/bin
mapfile -t cpp < <(find core fmu host tests -name '*.hpp' -o -name '*.cpp')
mapfile -t python < <(find cmake fmu host tests -name '*.py')

if [ "${1:-}" = --apply ]; then
  "$tools/clang-format" -i "${cpp[@]}" && "$tools/ruff" format -q "${python[@]}" && "$tools/ruff" check -q --fix "${python[@]}"
  exit
fi

failed=0
check() { # name command...
  local name=$1 output
  shift
  if output=$("$@" 2>&1); then echo "check $name: passed"; else echo "check $name: FAILED"; echo "$output"; failed=1; fi
}
check clang-format "$tools/clang-format" --dry-run -Werror "${cpp[@]}"
check ruff-format "$tools/ruff" format -q --diff "${python[@]}"
check ruff "$tools/ruff" check -q "${python[@]}"
check mypy "$tools/mypy"
exit $failed
