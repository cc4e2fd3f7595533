"""The cantilever under its own weight in Kratos MPM; peers.py runs this file inside an environment that has Kratos.

    python peers_kratos.py SCENE.json RESULT.json

SCENE.json: numbers of the scene (see peers.py). RESULT.json: how far the run came, its times, and where the points are.
Kratos reads its model from files, as its users write them: a background grid and a body of quadrilaterals (*.mdpa), the
material and the project's parameters (JSON).
"""
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

SOLVERS = {  # the direct ones of Kratos' wheels for Linux
    "sparse_lu": {"solver_type": "LinearSolversApplication.sparse_lu"},
    "sparse_qr": {"solver_type": "LinearSolversApplication.sparse_qr"},
    "skyline_lu": {"solver_type": "skyline_lu_factorization"},
}
MATERIAL_POINTS = "MPM_Material"
CLAMP = "Clamp"
BEAM = "Beam"


def lattice(lower, upper, cells):
    """Nodes and quadrilaterals of a regular mesh, both counted from one."""
    nodes_x, nodes_y = cells[0] + 1, cells[1] + 1
    x, y = np.meshgrid(np.linspace(lower[0], upper[0], nodes_x), np.linspace(lower[1], upper[1], nodes_y))
    corner = (np.arange(cells[1])[:, None] * nodes_x + np.arange(cells[0])).ravel() + 1
    quadrilaterals = np.column_stack([corner, corner + 1, corner + nodes_x + 1, corner + nodes_x])
    return np.column_stack([x.ravel(), y.ravel()]), quadrilaterals


def write_model(path, nodes, quadrilaterals, element, parts, first=0):
    """A model of Kratos; parts: name -> (rows of nodes, rows of quadrilaterals). Ids start behind `first`."""
    lines = ["Begin Properties 0", "End Properties", "Begin Nodes"]
    lines += [f"{i} {x:.15g} {y:.15g} 0.0" for i, (x, y) in enumerate(nodes, first + 1)]
    lines += ["End Nodes", f"Begin Elements {element}"]
    rows = [" ".join(str(node + first) for node in row) for row in quadrilaterals]
    lines += [f"{i} 0 {row}" for i, row in enumerate(rows, first + 1)]
    lines += ["End Elements"]
    for name, (some_nodes, some_elements) in parts.items():
        lines += [f"Begin SubModelPart {name}", "Begin SubModelPartNodes"]
        lines += [str(first + 1 + i) for i in some_nodes] + ["End SubModelPartNodes", "Begin SubModelPartElements"]
        lines += [str(first + 1 + i) for i in some_elements] + ["End SubModelPartElements", "End SubModelPart"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_models(scene, folder):
    """Grid and body; how many points Kratos has to put into an element of the body.

    It puts them at Gauss points: 4 x 4 in each element of the grid's size ("gauss"), or one in each element of a
    quarter of that size ("uniform", which is the lattice of Talus).
    """
    h, box, side = scene["h"], scene["box"], scene["points_per_side"]
    grid_nodes, grid_cells = lattice((0.0, 0.0), scene["grid"], [round(length / h) for length in scene["grid"]])
    clamped = np.flatnonzero(grid_nodes[:, 0] < 1e-9)
    write_model(folder / "grid.mdpa", grid_nodes, grid_cells, "Element2D4N", {CLAMP: (clamped, [])})
    size = h / side if scene["layout"] == "uniform" else h
    body_cells = [round((box[2] - box[0]) / size), round((box[3] - box[1]) / size)]
    nodes, quadrilaterals = lattice(box[:2], box[2:], body_cells)
    parts = {BEAM: (range(len(nodes)), range(len(quadrilaterals)))}
    write_model(folder / "body.mdpa", nodes, quadrilaterals, "MPMUpdatedLagrangian2D4N", parts, first=len(grid_nodes))
    return 1 if scene["layout"] == "uniform" else side * side


def write_material(scene, folder, points_per_element):
    """The law has tau = mu (b - I) + lambda ln(J) I, as neo_hookean of Talus; its values agree to the last digits."""
    variables = {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": points_per_element, "DENSITY": scene["density"],
                 "YOUNG_MODULUS": scene["E"], "POISSON_RATIO": scene["nu"]}
    law = {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"}
    part = {"model_part_name": f"Initial_{MATERIAL_POINTS}.{BEAM}", "properties_id": 1,
            "Material": {"constitutive_law": law, "Variables": variables, "Tables": {}}}
    (folder / "material.json").write_text(json.dumps({"properties": [part]}), encoding="utf-8")


def project(scene, folder):
    """The project's parameters."""
    step = 1.0 / scene["steps"]
    solver = {
        "solver_type": scene["solver_type"], "model_part_name": MATERIAL_POINTS, "domain_size": 2, "echo_level": 0,
        "analysis_type": "non_linear", "time_stepping": {"time_step": step}, "compute_reactions": False,
        "grid_model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "grid")},
        "model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "body")},
        "material_import_settings": {"materials_filename": str(folder / "material.json")},
        "convergence_criterion": "residual_criterion", "residual_relative_tolerance": scene["tolerance"],
        "residual_absolute_tolerance": 0.0, "max_iteration": scene["max_iteration"],
        "pressure_dofs": False, "linear_solver_settings": SOLVERS[scene["linear_solver"]],
        "problem_domain_sub_model_part_list": [BEAM], "processes_sub_model_part_list": [CLAMP],
        "auxiliary_variables_list": [],
    }
    clamp = {"python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics", "Parameters": {
        "model_part_name": f"Background_Grid.{CLAMP}", "variable_name": "DISPLACEMENT",
        "constrained": [True, True, True], "value": [0.0, 0.0, 0.0],
        "interval": [0.0, "End"]}}
    data = {"problem_name": "cantilever", "parallel_type": "OpenMP", "start_time": 0.0, "end_time": 1.0 - 0.5 * step,
            "echo_level": 0}
    return {"problem_data": data, "solver_settings": solver,
            "processes": {"constraints_process_list": [clamp], "loads_process_list": [], "list_other_processes": [],
                          "gravity": []}}


def analysis_class(kratos, mpm, base):
    """Kratos' own analysis, with a gravity that grows, and a clock."""

    class Analysis(base):
        def __init__(self, model, parameters, scene):
            super().__init__(model, parameters)
            self.scene, self.seconds, self.iterations, self.steps, self.failure = scene, 0.0, 0, 0, ""

        def points(self, variable):
            part = self.GetComputingModelPart()
            values = [element.CalculateOnIntegrationPoints(variable, part.ProcessInfo) for element in part.Elements]
            return np.array(values)[:, 0]

        def set_gravity(self, factor):
            part, value = self.GetComputingModelPart(), kratos.Array3([0.0, -factor * self.scene["gravity"], 0.0])
            for element in part.Elements:
                element.SetValuesOnIntegrationPoints(mpm.MP_VOLUME_ACCELERATION, [value], part.ProcessInfo)

        def advance(self):
            self.time = self._AdvanceTime()
            self.InitializeSolutionStep()
            converged = self.SolveSolutionStep()
            self.FinalizeSolutionStep()
            return converged

        def RunSolutionLoop(self):
            while self.KeepAdvancingSolutionLoop():
                self.set_gravity((self.steps + 1) / self.scene["steps"])  # not on the clock: it is Python's loop
                before = time.perf_counter()
                try:
                    converged = self.advance()
                except RuntimeError as error:
                    converged, self.failure = False, str(error).strip().splitlines()[0]
                self.seconds += time.perf_counter() - before
                self.iterations += self.GetComputingModelPart().ProcessInfo[kratos.NL_ITERATION_NUMBER]
                if not converged:
                    self.failure = self.failure or f"no convergence in {self.scene['max_iteration']} iterations"
                    return
                self.steps += 1

    return Analysis


def run(scene, folder):
    write_material(scene, folder, write_models(scene, folder))
    begin = time.perf_counter()
  
    import KratosMultiphysics as kratos
    import KratosMultiphysics.LinearSolversApplication  # registers its solvers
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis
    imported = time.perf_counter()
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    kratos.ParallelUtilities.SetNumThreads(1)
    analysis = analysis_class(kratos, mpm, MpmAnalysis)(
        kratos.Model(), kratos.Parameters(json.dumps(project(scene, folder))), scene)
    analysis.Initialize()
    initial = analysis.points(mpm.MP_COORD)
    looping = time.perf_counter()
    analysis.RunSolutionLoop()
    end = time.perf_counter()
    final, volume = analysis.points(mpm.MP_COORD), analysis.points(mpm.MP_VOLUME)
    lost = len(initial) - len(final)
    return {
        "steps": analysis.steps, "newton_iterations": int(analysis.iterations), "seconds": analysis.seconds,
        "seconds_import": imported - begin, "seconds_setup": looping - imported, "seconds_total": end - begin,
        "failure": analysis.failure or (f"{lost} points lost" if lost else ""), "points": len(initial),
        "version": kratos.KratosGlobals.Kernel.Version(), "volume": float(volume.sum()),
        "initial": initial[:, :2].tolist(), "displacement": [] if lost else (final - initial)[:, :2].tolist(),
    }


def main(run_scene, scene=None):
    """From the file with the scene, which `scene` completes, to that with what `run_scene` makes of it; both named in the command."""
    scene = {**(scene or {}), **json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))}
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        result = run_scene(scene, Path(folder))
    Path(sys.argv[2]).write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main(run)
