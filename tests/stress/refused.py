"""What the tests of refused scenes share: a good scene, the change that spoils it, and what the refusal must look like."""
import concurrent.futures

from talus_test import Run

GOOD = {
    "mpm_dim": "2",
    "mpm_grid_lower": "0,0",
    "mpm_grid_upper": "4,4",
    "mpm_grid_cells": "4,4",
    "mpm_materials": "soil",
    "mpm_material_soil_type": "hencky",
    "mpm_material_soil_E": "1e6",
    "mpm_material_soil_nu": "0.3",
    "mpm_material_soil_density": "1000",
    "mpm_bodies": "block",
    "mpm_body_block_region": "box",
    "mpm_body_block_lower": "0,0",
    "mpm_body_block_upper": "2,2",
    "mpm_body_block_points_per_cell": "2,2",
    "mpm_body_block_material": "soil",
    "mpm_bcs": "base",
    "mpm_bc_base_region": "box",
    "mpm_bc_base_lower": "0,0",
    "mpm_bc_base_upper": "4,0",
    "mpm_bc_base_components": "x,y",
    "mpm_loads": "weight,push",
    "mpm_load_weight_type": "gravity",
    "mpm_load_weight_value": "0,-1",
    "mpm_load_push_type": "force",
    "mpm_load_push_at": "2,2",
    "mpm_load_push_nearest": "1",
    "mpm_load_push_value": "10,0",
    "mpm_time_step": "0.5",
    "mpm_tracks": "top",
    "mpm_track_top_at": "2,2",
    "mpm_output_prefix": "bad",
}

SUFFIXES = {"table": "table.csv", "scene": "scene.yaml", "points": "points.csv", "surface": "surface.stl"}


def write_scene(folder, options):
    path = folder / "scene.yaml"
    path.write_text("".join(f'{name}: "{value}"\n' for name, value in options.items()), encoding="utf-8")
    return path


def changed(change):
    return {name: value for name, value in {**GOOD, **change}.items() if value is not None}


def faults(run, expected, ranks):
    """What is wrong with the way in which a run refused its scene."""
    lines = [line for line in run.errors.splitlines() if line.strip()]
    told = [line for line in lines if line.startswith("talus: error:")]
    if run.status != 2:
        yield f"exit status {run.status}"
    if len(told) != 1:
        yield f"{len(told)} lines 'talus: error:'"
    if ranks == 1 and len(lines) != len(told):  # mpiexec adds lines of its own
        yield "more on stderr"
    for words in expected.split(" ... "):  # with $ at its end: the line's end
        if told and words.rstrip("$") not in told[0] or (words.endswith("$") and not told[0].endswith(words[:-1])):
            yield f"no {words}"
    if "PETSC ERROR" in run.errors + run.output or "Caught signal" in run.errors:
        yield "traceback"
    extra = [name for name in run.files if name not in SUFFIXES.values()]
    if extra:
        yield "wrote " + ", ".join(extra)


class Refusals:
    """Runs of spoilt scenes, several at a time: most of a refused run's time goes by while MPI starts and ends."""

    def __init__(self, test, two_ranks=()):
        self.test, self.pool, self.waiting = test, concurrent.futures.ThreadPoolExecutor(4), []
        self.two_ranks = two_ranks

    def add(self, name, expected, options=None, **files):
        """A case on one rank or, if `two_ranks` has it, on both numbers; files by their stems, None: not there."""
        for count in (1, 2) if name in self.two_ranks else (1,):
            folder = self.test.folder()
            if options is not None:
                write_scene(folder, changed(options))
            for stem, text in files.items():
                if text is not None:
                    (folder / SUFFIXES[stem]).write_bytes(text if isinstance(text, bytes) else text.encode())
            run = self.pool.submit(Run, self.test.program, folder / "scene.yaml", count, {}, folder)
            self.waiting.append((name, expected, count, run))

    def finish(self):
        for name, expected, count, future in self.waiting:
            run = future.result()
            found = list(faults(run, expected, count))
            label = name.replace(" ", "_") + ("" if count == 1 else f"_on_{count}_ranks")
            self.test.check(label, len(found), None, 0)
            if found:
                print(f"    {'; '.join(found)}: {run.errors.strip()[:400]}")
        self.pool.shutdown()
