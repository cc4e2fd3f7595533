"""The program: where it is, and the schema of scenes that follows from its manual."""
from __future__ import annotations

import functools
import os
import shlex
import shutil
from pathlib import Path
from typing import Any

import jsonschema

from .errors import RunError
from .tools import manual


def find_program() -> Path:
    """Path of the program: the environment variable TALUS, else the wheel's own one, else `talus` on PATH."""
    named = os.environ.get("TALUS")
    if named:
        found = shutil.which(named)
        if found is None:
            raise RunError(f"TALUS={named}: no such program")
        return Path(found).resolve()
    carried = Path(__file__).resolve().parent / "bin" / "talus"
    if carried.is_file():
        return carried
    found = shutil.which("talus")
    if found is None:
        raise RunError("no program talus: set the environment variable TALUS to its path, or put it on PATH")
    return Path(found).resolve()


def command(scene: Path, ranks: int) -> list[str]:
    """Command line of a run; TALUS_MPIEXEC replaces `mpiexec`, with options if need be."""
    launcher = shlex.split(os.environ.get("TALUS_MPIEXEC", "mpiexec"))
    return [*([*launcher, "-n", str(ranks)] if ranks > 1 else []), str(find_program()), str(scene)]


def environment(ranks: int, session: str) -> dict[str, str]:
    """Environment of a run: one thread a rank.

    One rank alone needs neither a daemon of Open MPI nor a network. Runs that start at once need a folder each for the
    files of Open MPI, `session`.
    """
    alone = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_orte_tmpdir_base": session}
    return {"OMP_NUM_THREADS": "1", **(alone if ranks == 1 else {}), **os.environ}


def validator() -> Any:
    """The validator of scenes by the program's JSON schema."""
    program = find_program()
    return _validator(program, program.stat().st_mtime_ns)


@functools.lru_cache(maxsize=4)
def _validator(program: Path, _changed: int) -> Any:
    try:
        options = manual.read(program)
    except (OSError, ValueError) as error:
        raise RunError(f"{program}: gives no manual: {error}") from error
    return jsonschema.Draft7Validator(manual.schema(options))
