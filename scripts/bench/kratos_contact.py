"""A rigid disc pressed into an elastic block in Kratos MPM; kratos.py runs this file inside an environment that has Kratos.

    python kratos_contact.py SCENE.json RESULT.json

SCENE.json: numbers of the scene (see kratos.py). The disc is a row of line conditions with material points of their own, which
hold the grid by a penalty where it moves into them ("contact_slip"): its normal part only, and no tension.
"""
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from peers_kratos import MATERIAL_POINTS, SOLVERS, lattice, write_model

BLOCK, AXIS, BASE, DISC = "Block", "Axis", "Base", "Disc"


def write_models(scene, folder):
    """Grid with its conditions, and the block: one point in each element of a quarter of the grid's size."""
    h, box, side, radius = scene["h"], scene["box"], scene["points_per_side"], scene["radius"]
    cells = [round(length / h) for length in scene["grid"]]
    nodes, quadrilaterals = lattice((0.0, 0.0), scene["grid"], cells)
    axis, base = np.flatnonzero(nodes[:, 0] < 1e-9), np.flatnonzero(nodes[:, 1] < 1e-9)
    lines = round(scene["reach"] / h) * scene["lines_per_cell"]
    angle = np.linspace(0.0, np.arcsin(scene["reach"] / radius), lines + 1)
    arc = np.column_stack([radius * np.sin(angle), box[1] + radius * (1.0 - np.cos(angle))])
    path = folder / "grid.mdpa"
    write_model(path, nodes, quadrilaterals, "Element2D4N", {AXIS: (axis, []), BASE: (base, [])})
    first = len(nodes)
    text = path.read_text(encoding="utf-8")
    extra = "".join(f"{first + 1 + i} {x:.15g} {y:.15g} 0.0\n" for i, (x, y) in enumerate(arc))
    text = text.replace("End Nodes\n", extra + "End Nodes\n", 1)
    rows = [f"{i + 1} 0 {first + i + 1} {first + i + 2}" for i in range(lines)]
    text += "\n".join(["Begin Conditions LineCondition2D2N", *rows, "End Conditions", f"Begin SubModelPart {DISC}",
                       "Begin SubModelPartNodes", *[str(first + 1 + i) for i in range(lines + 1)], "End SubModelPartNodes",
                       "Begin SubModelPartConditions", *[str(i + 1) for i in range(lines)], "End SubModelPartConditions",
                       "End SubModelPart"]) + "\n"
    path.write_text(text, encoding="utf-8")
    size = h / side
    nodes, quadrilaterals = lattice((0.0, 0.0), box, [round(length / size) for length in box])
    write_model(folder / "body.mdpa", nodes, quadrilaterals, "MPMUpdatedLagrangian2D4N",
                {BLOCK: (range(len(nodes)), range(len(quadrilaterals)))}, first=first + len(arc))


def write_material(scene, folder):
    variables = {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 1, "DENSITY": 1.0, "YOUNG_MODULUS": scene["E"],
                 "POISSON_RATIO": scene["nu"]}
    part = {"model_part_name": f"Initial_{MATERIAL_POINTS}.{BLOCK}", "properties_id": 1,
            "Material": {"constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"}, "Variables": variables,
                         "Tables": {}}}
    (folder / "material.json").write_text(json.dumps({"properties": [part]}), encoding="utf-8")


def fixed(name, components):
    return {"python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics", "Parameters": {
        "model_part_name": f"Background_Grid.{name}", "variable_name": "DISPLACEMENT", "constrained": components,
        "value": [0.0 if held else None for held in components], "interval": [0.0, "End"]}}


def project(scene, folder):
    step = 1.0 / scene["steps"]
    solver = {
        "solver_type": "quasi_static", "model_part_name": MATERIAL_POINTS, "domain_size": 2, "echo_level": 0,
        "analysis_type": "non_linear", "time_stepping": {"time_step": step}, "compute_reactions": False,
        "grid_model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "grid")},
        "model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "body")},
        "material_import_settings": {"materials_filename": str(folder / "material.json")},
        "convergence_criterion": "residual_criterion", "residual_relative_tolerance": scene["tolerance"],
        "residual_absolute_tolerance": scene["absolute"], "max_iteration": scene["max_iteration"],
        "pressure_dofs": False, "linear_solver_settings": SOLVERS[scene["linear_solver"]],
        "problem_domain_sub_model_part_list": [BLOCK], "processes_sub_model_part_list": [AXIS, BASE, DISC],
        "auxiliary_variables_list": ["NORMAL", "IS_STRUCTURE", "NODAL_AREA"],
    }
    disc = {"python_module": "apply_mpm_particle_dirichlet_condition_process",
            "kratos_module": "KratosMultiphysics.MPMApplication", "Parameters": {
                "model_part_name": f"Background_Grid.{DISC}", "material_points_per_condition": 1,
                "penalty_coefficient": scene["penalty"], "constrained": scene["constrained"], "option": scene["option"],
                "variable_name": "DISPLACEMENT", "value": [0.0, -scene["depth"] * step, 0.0]}}
    data = {"problem_name": "disc", "parallel_type": "OpenMP", "start_time": 0.0, "end_time": 1.0 - 0.5 * step,
            "echo_level": 0}
    return {"problem_data": data, "solver_settings": solver,
            "processes": {"constraints_process_list": [fixed(AXIS, [True, False, False]), fixed(BASE, [False, True, False])],
                          "loads_process_list": [], "list_other_processes": [disc], "gravity": []}}


def run(scene, folder):
    write_models(scene, folder)
    write_material(scene, folder)
    import KratosMultiphysics as kratos
    import KratosMultiphysics.LinearSolversApplication  # registers its solvers
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    kratos.ParallelUtilities.SetNumThreads(1)
    analysis = MpmAnalysis(kratos.Model(), kratos.Parameters(json.dumps(project(scene, folder))))
    analysis.Initialize()
    part, info = analysis._GetSolver().GetComputingModelPart(), None
    info = part.ProcessInfo
    seconds, iterations, steps, failure = 0.0, 0, 0, ""
    trace = []
    while analysis.KeepAdvancingSolutionLoop():
        before = time.perf_counter()
        try:
            analysis.time = analysis._AdvanceTime()
            analysis.InitializeSolutionStep()
            converged = analysis._GetSolver().SolveSolutionStep()
            analysis.FinalizeSolutionStep()
        except RuntimeError as error:
            converged, failure = False, str(error).strip().splitlines()[0]
        seconds += time.perf_counter() - before
        iterations += info[kratos.NL_ITERATION_NUMBER]
        if not converged:
            failure = failure or f"no convergence in {scene['max_iteration']} iterations"
            break
        steps += 1

    def points(variable, column):
        return np.array([element.CalculateOnIntegrationPoints(variable, info)[0] for element in part.Elements])[..., column]

    stress = np.array([list(element.CalculateOnIntegrationPoints(mpm.MP_CAUCHY_STRESS_VECTOR, info)[0]) for element in part.Elements])
    volume = np.array([element.CalculateOnIntegrationPoints(mpm.MP_VOLUME, info)[0] for element in part.Elements])
    conditions = [(list(c.CalculateOnIntegrationPoints(mpm.MPC_COORD, info)[0]), list(c.CalculateOnIntegrationPoints(mpm.MPC_CONTACT_FORCE, info)[0]),
        c.CalculateOnIntegrationPoints(mpm.MPC_AREA, info)[0]) for c in part.Conditions]
    return {"steps": steps, "newton_iterations": int(iterations), "seconds": seconds, "failure": failure, "points": len(volume),
            "virial": float((stress[:, 1] * volume).sum()), "conditions": conditions, 
            "top": points(mpm.MP_COORD, 1).max()}


def main():
    scene = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        result = run(scene, Path(folder))
    Path(sys.argv[2]).write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main()
