#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test; the unit and material tests under the address and
# undefined-behaviour sanitizers too. Arguments go to the last ctest: scripts/test.sh -R cantilever
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$ROOT/scripts/setup.sh"
"$ROOT/scripts/build.sh" asan test_programs
"$ROOT/scripts/build.sh" release all
cd "$ROOT"
ctest --preset asan --parallel "$JOBS"
ctest --preset release --parallel "$JOBS" "$@"
