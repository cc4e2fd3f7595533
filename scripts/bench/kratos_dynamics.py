"""A block that its weight presses together in Kratos MPM; dynamics.py runs this file where Kratos is installed.

    python kratos_dynamics.py SCENE.json RESULT.json

SCENE.json: integrator, cells, steps and their length (see dynamics.py). RESULT.json: points, times, and where the top is.
"""
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from peers_kratos import analysis_class, main, project, write_material, write_models  # noqa: E402

SCENE = {"box": [0.2, 0.0, 1.0, 0.8], "grid": [1.2, 1.2], "points_per_side": 2, "layout": "uniform", "E": 1e6, "nu": 0.3,
         "density": 1000.0, "gravity": 10.0, "solver_type": "Dynamic", "tolerance": 1e-8, "max_iteration": 50,
         "linear_solver": "sparse_lu"}


def settings(scene, folder):
    """Those of peers_kratos.py, with the base held and a scheme of dynamics."""
    grid = folder / "grid.mdpa"
    size, nodes = scene["cells"] + 1, grid.read_text(encoding="utf-8")
    held = "".join(f"{i + 1}\n" for i in range(size))
    begin = nodes.index("Begin SubModelPartNodes\n") + len("Begin SubModelPartNodes\n")
    grid.write_text(nodes[:begin] + held + nodes[nodes.index("End SubModelPartNodes"):], encoding="utf-8")
    parameters = project(scene, folder)
    solver = parameters["solver_settings"]
    solver["time_stepping"] = {"time_step": scene["dt"]}
    parameters["problem_data"]["end_time"] = (scene["steps"] - 0.5) * scene["dt"]
    if scene["integrator"] == "explicit":
        solver.update(time_integration_method="explicit", analysis_type="linear", scheme_type="forward_euler",
                      stress_update="musl")
    else:
        solver.update(time_integration_method="implicit", scheme_type="newmark", newmark_beta=0.25)
    return parameters


def run(scene, folder):
    scene["h"] = scene["grid"][0] / scene["cells"]
    write_material(scene, folder, write_models(scene, folder))
    import KratosMultiphysics as kratos
    import KratosMultiphysics.LinearSolversApplication  # registers its solvers
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    kratos.ParallelUtilities.SetNumThreads(1)

    class Analysis(analysis_class(kratos, mpm, MpmAnalysis)):
        def set_gravity(self, _):
            """The whole of it from the first step on."""
            if self.steps == 0:
                super().set_gravity(1.0)

    analysis = Analysis(kratos.Model(), kratos.Parameters(json.dumps(settings(scene, folder))), scene)
    analysis.Initialize()
    initial = analysis.points(mpm.MP_COORD)
    begin = time.perf_counter()
    analysis.RunSolutionLoop()
    total = time.perf_counter() - begin
    final = analysis.points(mpm.MP_COORD)
    nearest = np.argsort(np.hypot(initial[:, 0] - 0.6, initial[:, 1] - 0.8))[:2]
    if analysis.failure:
        raise SystemExit(analysis.failure)
    return {"points": len(initial), "steps": analysis.steps, "newton_iterations": int(analysis.iterations),
            "seconds": analysis.seconds, "seconds_total": total, "top_uy": float((final - initial)[nearest, 1].mean())}


if __name__ == "__main__":
    main(run, SCENE)
