"""Results in a window, by pyvista: the surface in space, or the domains in the plane, with a slider over steps."""

import numpy as np

from results import ResultsError

from . import fields, style, units
from .plane import look_at
from .space import BOX, shell
from .domains import deformation, half_lengths
from .states import read_points

HEXAHEDRON = np.array([0, 1, 3, 2, 4, 5, 7, 6])  # of BOX, in the order of VTK


def import_pyvista():
    try:
        import pyvista
    except ImportError as error:
        raise ResultsError(f"needs the Python package pyvista ({error}): pip install pyvista") from error
    return pyvista


def mesh_of(pyvista, results, scene, state):
    """Cells of a state and the point of each: polygons in the plane, in space the boxes at the surface."""
    if state.dim == 2:
        found = look_at(results, scene, state).domains
        count, width = found.corners.shape[:2]
        place = np.pad(found.corners.reshape(-1, 2), ((0, 0), (0, 1)))
        cells = np.column_stack([np.full(count, width), np.arange(count * width).reshape(count, width)])
        return pyvista.PolyData(place, cells.ravel()), found.owner
    origin = results.origin(state)
    rows = shell(origin)
    local = BOX[HEXAHEDRON] * half_lengths(state, origin)[rows][:, None]
    corners = state["position"][rows][:, None] + np.einsum("pij,pkj->pki", deformation(state)[rows], local)
    cells = np.column_stack([np.full(len(rows), 8), np.arange(8 * len(rows)).reshape(-1, 8)])
    kinds = np.full(len(rows), pyvista.CellType.HEXAHEDRON)
    return pyvista.UnstructuredGrid(cells.ravel(), kinds, corners.reshape(-1, 3)), rows


def view(results, scene, arguments):
    """Opens a window; with --screenshot writes a picture in its place."""
    pyvista = import_pyvista()
    plotter = pyvista.Plotter(off_screen=bool(arguments.screenshot), title=scene.title or "talus view")
    steps = results.steps
    size = units.largest(fields.field_values(read_points(results, steps[-1]), arguments.field, arguments.component)[0])

    def show(number):
        state = read_points(results, steps[int(round(number))])
        mesh, owner = mesh_of(pyvista, results, scene, state)
        field = fields.read_field(state, arguments.field, arguments.component, size)
        label = units.with_unit(
            " ".join(filter(None, (arguments.field.replace("_", " "), arguments.component))), field.unit
        )
        mesh.cell_data[label] = field.values[owner]
        scale = fields.colour_scale(field.values, arguments.limits, arguments.colours)
        plotter.add_mesh(mesh, name="material", scalars=label, cmap=scale.colours, clim=(scale.low, scale.high))
        plotter.add_text(f"step {state.step}, {units.time_text(scene, state.time)}", name="time", font_size=9)

    show(steps.index(state_number(results, arguments.step)))
    if len(steps) > 1 and not arguments.screenshot:
        plotter.add_slider_widget(show, (0, len(steps) - 1), value=len(steps) - 1, title="state", fmt="%.0f")
    plotter.view_xy() if scene.dim == 2 else plotter.view_isometric()
    plotter.show_axes()
    if arguments.screenshot:
        plotter.screenshot(arguments.screenshot)
    else:
        plotter.show()


def state_number(results, step):
    return results.state(step).step
