# Sourced by the other scripts: the repository's root, how many jobs may run at once, and what Open MPI and the BLAS need to
# be told.
# shellcheck shell=bash
ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
export ROOT
JOBS="$(env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc)" # the cores that we may use; nproc takes these two for limits
export JOBS
export OMP_NUM_THREADS=1                     # ranks are the parallelism; threads under them only fight for the cores
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export ASAN_OPTIONS="${ASAN_OPTIONS:-detect_leaks=0}" # Open MPI and PETSc keep memory to the end; -malloc_dump looks for our leaks
export MPLBACKEND=Agg                        # pictures go to files

# Objects that were compiled before, on this processor, come from ccache where it is installed.
if command -v ccache >/dev/null; then
  export CMAKE_C_COMPILER_LAUNCHER="${CMAKE_C_COMPILER_LAUNCHER-ccache}" CCACHE_BASEDIR="$ROOT" CCACHE_NOHASHDIR=1
  export CCACHE_COMPILERCHECK="%compiler% -march=native -Q --help=target"
fi
