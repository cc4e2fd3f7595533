#!/usr/bin/env bash
# From a bare Debian 12 to a first result: installs, builds, runs the elastic column on 2 ranks and compares it with its
# exact solution.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$ROOT/scripts/setup.sh"
"$ROOT/scripts/build.sh" release talus

results="$ROOT/out/demo"
mkdir -p "$results"
cd "$results"
mpiexec --oversubscribe -n 2 "$ROOT/build/talus" -options_file "$ROOT/examples/bar_elastic/case.yaml"

echo
echo "Against the exact solution (name, value, bound; stress errors are relative to the stress at the base):"
/usr/bin/python3 "$ROOT/examples/bar_elastic/check.py" bar_elastic --plot "$results/bar_elastic.png"
echo
echo "Picture: $results/bar_elastic.png; results: $results/bar_elastic.* (ParaView opens the .xdmf)"
