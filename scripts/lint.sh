#!/usr/bin/env bash
# Style: C sources as clang-format 14 leaves them, shell scripts without shellcheck's complaints, no build files in git.
# A tool that is not installed is passed over.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

status=0
if command -v clang-format-14 >/dev/null; then
  find include src physics materials tests examples scripts -name '*.[ch]' -print0 | xargs -0 clang-format-14 --dry-run --Werror || status=1
else
  echo "lint: clang-format-14 is not installed; C sources were not looked at" >&2
fi
if command -v shellcheck >/dev/null; then
  shellcheck -x scripts/*.sh scripts/slurm/* .ci/run || status=1
else
  echo "lint: shellcheck is not installed; shell scripts were not looked at" >&2
fi
if built=$(git ls-files 2>/dev/null | grep -E '(^|/)(CMakeCache\.txt|CMakeFiles/)|\.(o|a|so)$'); then
  echo "lint: build files are in git:" >&2
  head -3 <<<"$built" >&2
  status=1
fi
exit $status
