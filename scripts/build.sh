#!/usr/bin/env bash
# Configures and builds: scripts/build.sh [PRESET [TARGET...]]. Presets (release, debug, asan) are those of
# CMakePresets.json. Without targets the program alone is built; `all` is everything, `test_programs` what the unit and
# material tests run.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
cd "$ROOT"

preset="${1:-release}"
shift || true
targets=("$@")
((${#targets[@]})) || targets=(talus)

if ! log="$(cmake --preset "$preset" 2>&1)"; then
  echo "$log" >&2
  exit 1
fi
grep -A4 -i "warning" <<<"$log" >&2 || true
cmake --build --preset "$preset" --parallel "$JOBS" --target "${targets[@]}" -- --no-print-directory --silent
