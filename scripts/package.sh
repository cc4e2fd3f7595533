#!/usr/bin/env bash
# Debian packages for any processor of this kind, in out/packages: scripts/package.sh. Needs dpkg-dev; lintian looks over them
# where it is installed.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$ROOT/scripts/build.sh" package all
cd "$ROOT"
cpack -G DEB --config build-package/CPackConfig.cmake -B out/packages
if command -v lintian >/dev/null; then lintian --fail-on error,warning out/packages/*.deb; fi
