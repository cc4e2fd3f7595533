#!/usr/bin/env bash
# One piece of a run that is longer than a job may be.
#
#   piece.sh PREFIX COMMAND...
#
# Runs COMMAND, a talus command line whose results have this PREFIX; from the newest checkpoint, where there is one. SIGUSR1 and
# SIGTERM reach the run as SIGUSR1: it ends its step and writes a checkpoint. (mpiexec hands SIGUSR1 on to the ranks; SIGTERM
# would make it kill them.)
#
# Exit status: 0 the run is complete; 99 it was interrupted and is to be continued; 98 it was interrupted and has not got any
# further, so that to continue it would go on for ever; any other is that of the command.
set -u
if (($# < 2)); then
  echo "usage: $0 PREFIX COMMAND..." >&2
  exit 2
fi
prefix="$1"
shift

# The step of the newest checkpoint; -1 without one.
newest_step() {
  local head="$prefix"_checkpoint.h5
  if [[ -f $head ]]; then head -c 512 "$head" | tr -d '\0' | sed -n 's/^step //p'; else echo -1; fi
}

before="$(newest_step)"
restart=()
if compgen -G "$prefix"'_checkpoint*.h5' >/dev/null; then restart=(-mpm_restart latest); fi
"$@" ${restart[@]+"${restart[@]}"} &
run=$!
trap 'kill -USR1 $run 2>/dev/null' USR1 TERM
while kill -0 "$run" 2>/dev/null; do wait "$run"; done # a signal ends the waiting, not the run
wait "$run"
status=$?
((status)) && exit "$status"
grep -q '"status": "interrupted"' "$prefix"_summary.json || exit 0
if [[ $(newest_step) == "$before" ]]; then
  echo "$0: the run was interrupted before it had made one step" >&2
  exit 98
fi
exit 99
