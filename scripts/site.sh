#!/usr/bin/env bash
# Builds the site of documents: scripts/site.sh [PROGRAM [FOLDER]], by default build/talus and build/site. FOLDER/html is the site.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec /usr/bin/python3 scripts/make_site.py "${1:-build/talus}" "${2:-build/site}"
