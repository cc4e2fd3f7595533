#!/usr/bin/env bash
# Faults that clang-tidy 14 finds by the checks in .clang-tidy: scripts/tidy.sh [FILE...]; without files, all of src/.
# Slow: some seconds a file.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$ROOT"

build="$ROOT/build/tidy"
cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER=clang -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >/dev/null
cmake --build "$build" --target build_info -- --no-print-directory --silent
if [ $# -gt 0 ]; then files=("$@"); else files=(src/*/*.c); fi
printf '%s\n' "${files[@]}" | xargs -P "$JOBS" -n 4 clang-tidy-14 --quiet --warnings-as-errors='*' -p "$build"
