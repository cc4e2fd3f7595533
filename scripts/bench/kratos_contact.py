"""A disc pressed into a block, or a block that slides, in Kratos MPM; kratos.py runs this file where Kratos is installed.

    python kratos_contact.py SCENE.json RESULT.json

SCENE.json: numbers of the scene (see kratos.py). RESULT.json: forces, times, and how far the run came.

The disc is a row of lines with a material point each, which hold the grid by a penalty where it moves into them
("contact_slip": along their normal, and no tension). The plane is the lower edge of the grid ("slip" with friction).
"""
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from peers_kratos import MATERIAL_POINTS, SOLVERS, lattice, main, write_model  # noqa: E402

BLOCK, LINES, HELD, PUSHED = "Block", "Lines", "Held", "Pushed"


def add_lines(path, ends, first):
    """Line conditions of a model that has been written: rows of their nodes' ids, and places of nodes that only they have."""
    rows, places = ends
    text = path.read_text(encoding="utf-8")
    new = "".join(f"{first + 1 + i} {x:.15g} {y:.15g} 0.0\n" for i, (x, y) in enumerate(places))
    text = text.replace("End Nodes\n", new + "End Nodes\n", 1)
    used = sorted({node for row in rows for node in row})
    lines = ["Begin Conditions LineCondition2D2N", *[f"{i} 0 {a} {b}" for i, (a, b) in enumerate(rows, 1)], "End Conditions",
             f"Begin SubModelPart {LINES}", "Begin SubModelPartNodes", *map(str, used), "End SubModelPartNodes",
             "Begin SubModelPartConditions", *map(str, range(1, len(rows) + 1)), "End SubModelPartConditions",
             "End SubModelPart"]
    path.write_text(text + "\n".join(lines) + "\n", encoding="utf-8")


def write_models(scene, folder):
    """Grid with its conditions, and the block: one point in each element of a quarter of the grid's size."""
    h, (left, right, top) = scene["h"], scene["block"]
    nodes, quadrilaterals = lattice((0.0, 0.0), scene["grid"], [round(length / h) for length in scene["grid"]])
    base, places = np.flatnonzero(nodes[:, 1] < 1e-9), []
    if scene["case"] == "disc":
        parts = {HELD: (np.flatnonzero(nodes[:, 0] < 1e-9), []), PUSHED: (base, [])}
        count = round(scene["reach"] / h) * scene["lines_per_cell"]
        angle = np.linspace(0.0, np.arcsin(scene["reach"] / scene["radius"]), count + 1)
        places = scene["radius"] * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]) + [0.0, top]
        rows = [(len(nodes) + i, len(nodes) + i + 1) for i in range(1, count + 1)]
    else:
        parts = {PUSHED: (np.flatnonzero(np.abs(nodes[:, 1] - top) < 1e-9), [])}
        rows = [(base[i] + 1, base[i + 1] + 1) for i in range(len(base) - 1)]
    write_model(folder / "grid.mdpa", nodes, quadrilaterals, "Element2D4N", parts)
    add_lines(folder / "grid.mdpa", (rows, places), len(nodes))
    size = h / scene["points_per_side"]
    own, elements = lattice((left, 0.0), (right, top), [round((right - left) / size), round(top / size)])
    write_model(folder / "body.mdpa", own, elements, "MPMUpdatedLagrangian2D4N",
                {BLOCK: (range(len(own)), range(len(elements)))}, first=len(nodes) + len(places))
    return list(parts)


def write_material(scene, folder):
    variables = {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 1, "DENSITY": 1.0, "YOUNG_MODULUS": scene["E"],
                 "POISSON_RATIO": scene["nu"]}
    part = {"model_part_name": f"Initial_{MATERIAL_POINTS}.{BLOCK}", "properties_id": 1,
            "Material": {"constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"}, "Variables": variables,
                         "Tables": {}}}
    (folder / "material.json").write_text(json.dumps({"properties": [part]}), encoding="utf-8")


def contact(scene):
    part = {"model_part_name": f"Background_Grid.{LINES}"}
    if scene["case"] == "disc":
        part.update(material_points_per_condition=1, penalty_coefficient=scene["penalty"], constrained="contact_slip",
                    variable_name="DISPLACEMENT", value=[0.0, -scene["depth"] / scene["steps"], 0.0])  # of each step
        module = "apply_mpm_particle_dirichlet_condition_process"
    else:
        part.update(friction_coefficient=scene["friction"], tangential_penalty_coefficient=scene["penalty"],
                    option="flip_normal")
        module = "apply_mpm_slip_boundary_process"
    return {"python_module": module, "kratos_module": "KratosMultiphysics.MPMApplication", "Parameters": part}


def project(scene, folder, parts):
    step = 1.0 / scene["steps"]
    solver = {
        "solver_type": "quasi_static", "model_part_name": MATERIAL_POINTS, "domain_size": 2, "echo_level": 0,
        "analysis_type": "non_linear", "time_stepping": {"time_step": step}, "compute_reactions": True,
        "grid_model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "grid")},
        "model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "body")},
        "material_import_settings": {"materials_filename": str(folder / "material.json")},
        "convergence_criterion": scene["criterion"], "residual_relative_tolerance": scene["tolerance"],
        "residual_absolute_tolerance": 1e-9, "displacement_relative_tolerance": scene["tolerance"],
        "displacement_absolute_tolerance": 1e-12, "max_iteration": scene["max_iteration"],
        "pressure_dofs": False, "linear_solver_settings": SOLVERS["sparse_lu"],
        "problem_domain_sub_model_part_list": [BLOCK], "processes_sub_model_part_list": [*parts, LINES],
        "auxiliary_variables_list": ["NORMAL", "IS_STRUCTURE", "NODAL_AREA", "FRICTION_STATE", "STICK_FORCE"],
    }
    data = {"problem_name": scene["case"], "parallel_type": "OpenMP", "start_time": 0.0, "end_time": 1.0 - 0.5 * step,
            "echo_level": 0}
    return {"problem_data": data, "solver_settings": solver,
            "processes": {"constraints_process_list": [], "loads_process_list": [], "list_other_processes": [contact(scene)],
                          "gravity": []}}


def prescribe(kratos, scene, grid, step):
    """Nodes of the grid that are held or pushed, by the displacement of one step."""
    if scene["case"] == "disc":
        for part, component in ((HELD, kratos.DISPLACEMENT_X), (PUSHED, kratos.DISPLACEMENT_Y)):
            for node in grid.GetSubModelPart(part).Nodes:
                node.Fix(component)
                node.SetSolutionStepValue(component, 0.0)
        return
    pressing = scene["steps"] // 4
    way = [0.0, -scene["depth"] / pressing] if step < pressing else [scene["slide"] / (scene["steps"] - pressing), 0.0]
    for node in grid.GetSubModelPart(PUSHED).Nodes:
        for component, value in zip((kratos.DISPLACEMENT_X, kratos.DISPLACEMENT_Y), way):
            node.Fix(component)
            node.SetSolutionStepValue(component, value)


def run(scene, folder):
    parts = write_models(scene, folder)
    write_material(scene, folder)
    import KratosMultiphysics as kratos
    import KratosMultiphysics.LinearSolversApplication  # registers its solvers
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    kratos.ParallelUtilities.SetNumThreads(1)
    analysis = MpmAnalysis(kratos.Model(), kratos.Parameters(json.dumps(project(scene, folder, parts))))
    analysis.Initialize()
    solver = analysis._GetSolver()
    points, grid = solver.GetComputingModelPart(), solver.GetGridModelPart()
    seconds, iterations, unconverged = 0.0, 0, 0
    for step in range(scene["steps"]):
        before = time.perf_counter()
        analysis.time = analysis._AdvanceTime()
        analysis.InitializeSolutionStep()
        prescribe(kratos, scene, grid, step)
        unconverged += not solver.SolveSolutionStep()
        analysis.FinalizeSolutionStep()
        seconds += time.perf_counter() - before
        iterations += points.ProcessInfo[kratos.NL_ITERATION_NUMBER]

    def at_points(variable):
        return np.array([list(np.atleast_1d(element.CalculateOnIntegrationPoints(variable, points.ProcessInfo)[0]))
                         for element in points.Elements])

    stress, volume = at_points(mpm.MP_CAUCHY_STRESS_VECTOR), at_points(mpm.MP_VOLUME)[:, 0]
    reaction = sum(np.array(list(node.GetSolutionStepValue(kratos.REACTION)))[:2]
                   for node in grid.GetSubModelPart(PUSHED).Nodes)
    return {"newton_iterations": int(iterations), "seconds": seconds, "unconverged": int(unconverged), "points": len(volume),
            "virial": float(stress[:, 1] @ volume), "reaction": np.asarray(reaction).tolist()}


if __name__ == "__main__":
    main(run)
