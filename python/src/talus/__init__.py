"""Talus from Python: scenes, runs, parameter studies, calibrations.

    import talus

    scene = talus.Scene("case.yaml")
    scene["material_soil_E"] = 20e6
    results = talus.run(scene, ranks=2)
    print(results.history["track_toe_ux"].iloc[-1])
"""
from . import importers, templates
from . import plot
from .calibration import Calibration, calibrate
from .errors import RunError, SceneError
from .gradients import Gradient, gradient
from .inverse import Inverse, Residuals, invert, residuals
from .program import find_program
from .plot import Picture
from .results import Results, ResultsError, State
from .running import run
from .scene import Scene
from .sweeps import sweep

__all__ = ["Calibration", "Gradient", "Inverse", "Picture", "Residuals", "Results", "ResultsError", "RunError", "Scene", "SceneError",
           "State", "calibrate", "find_program", "gradient", "importers", "invert", "residuals", "run", "sweep", "templates"]
