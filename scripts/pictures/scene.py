"""The scene behind results, by the options in force: bodies, conditions, loads, boundaries, water and stages."""

import math
from collections import namedtuple

import numpy as np

from results import ResultsError, read_columns

from .domains import in_polygon
from .layers import in_layer, layer_polygon

Body = namedtuple("Body", "name material polygon joins")
Stage = namedtuple("Stage", "name resets")
ROUND = 120  # corners of a disc
VISCOUS = ("newtonian",)  # laws in which time is real without inertia


def numbers(text):
    return [float(part) for part in text.split(",") if part.strip()]


def names(text):
    return [part.strip() for part in text.split(",") if part.strip()]


def ramp(text, time):
    """Value at a time of time:factor pairs, linear between them."""
    pairs = np.array([[float(number) for number in pair.split(":")] for pair in text.split(",")])
    return float(np.interp(time, pairs[:, 0], pairs[:, 1]))


class Scene:
    """Options of the run, as the blocks of a scene."""

    def __init__(self, results):
        self.results, self.memo = results, {}
        try:
            self.options = {name.removeprefix("mpm_"): text for name, text in results.options.items()}
        except ResultsError:  # nobody kept the options
            self.options = {}
        self.dim = int(self.get("dim", "2"))
        self.axial = self.get("kinematics") == "axisymmetric"
        self.materials, self.stages = names(self.get("materials")), self._stages()

    def get(self, name, default=""):
        text = self.options.get(name, default)
        return default if text == "not given" else text

    def is_given(self, name):
        """True where the scene itself has this option."""
        return bool(self.options) and self.results.is_given(f"mpm_{name}")

    def vector(self, name, default=""):
        return np.array(numbers(self.get(name, default)))

    def list(self, name):
        return names(self.get(name))

    @property
    def title(self):
        return self.get("title")

    @property
    def has_time(self):
        """Is time in seconds? Statics of solids has a pseudo-time, which orders the loads."""
        if self.get("physics", "solid") == "stress_point":
            return False
        if self.get("physics", "solid") != "solid" or not self.options:
            return True
        if any(self.get(f"material_{name}_type").startswith(VISCOUS) for name in self.materials):
            return True
        kinds = [self.get("time_integrator", "quasistatic")]
        kinds += [self.get(f"stage_{stage.name}_time_integrator", kinds[0]) for stage in self.stages]
        return any(kind != "quasistatic" for kind in kinds)

    def _stages(self):
        found = []
        for name in self.list("stages"):
            found.append(Stage(name, self.get(f"stage_{name}_reset_displacement", "false") == "true"))
        return found

    def active(self, kind, stage):
        """Names of the conditions, loads or the like that act in a stage (its name, or None)."""
        own = self.get(f"stage_{stage}_{kind}") if stage else ""
        if own in ("none", "''", '""'):
            return []
        return names(own) if own else self.list(kind)

    def stage_at(self, step):
        """Name of the stage that a step belongs to; None without stages."""
        if not self.stages:
            return None
        try:
            history = self.results.history
        except ResultsError:
            return self.stages[0].name
        if "stage" not in history or not len(history["step"]):
            return self.stages[0].name
        row = min(np.searchsorted(history["step"], step), len(history["step"]) - 1)
        return self.stages[min(max(int(history["stage"][row]) - 1, 0), len(self.stages) - 1)].name

    # ---- regions ----

    def polygon(self, block):
        """Outline of a region in the plane, (corners, 2); None where it has none, as of files or of the whole grid."""
        kind = self.get(f"{block}_region", "all")
        if kind == "box":
            low, high = self.vector(f"{block}_lower"), self.vector(f"{block}_upper")
            corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])]) if len(low) == 2 else None
        elif kind == "polygon":
            corners = self.vector(f"{block}_vertices").reshape(-1, 2)
        elif kind == "sphere" and self.dim == 2:
            corners = circle(self.vector(f"{block}_center"), self.vector(f"{block}_radius")[0])
        else:
            return layer_polygon(self, block) if kind == "layers" and self.dim == 2 else None
        return corners

    def clip(self, block):
        """Box in which a region ends, (2, dim); infinite where it has none."""
        ends = np.array([[-np.inf] * self.dim, [np.inf] * self.dim])
        for row, end in enumerate(("lower", "upper")):
            given = self.vector(f"{block}_clip_{end}")
            ends[row, : len(given)] = given
        return ends

    def contains(self, block, place, reach=0.0):
        """Which of the places (n, dim) lie in a region, or within `reach` of it."""
        kind = self.get(f"{block}_region", "all")
        low, high = self.clip(block)
        inside = np.all((place >= low - reach) & (place <= high + reach), axis=1)
        if kind == "box":
            low, high = self.vector(f"{block}_lower"), self.vector(f"{block}_upper")
            return inside & np.all((place >= low - reach) & (place <= high + reach), axis=1)
        if kind == "sphere":
            centre, radius = self.vector(f"{block}_center"), self.vector(f"{block}_radius")[0]
            return inside & (np.linalg.norm(place - centre, axis=1) <= radius + reach)
        if kind == "layers":
            inside &= in_layer(self, block, place, reach)
        if kind == "polygon":
            inside &= in_polygon(place[:, :2], self.polygon(block), reach)
            if self.dim == 3:
                inside &= place[:, 2] >= float(self.get(f"{block}_lower_z", "-inf")) - reach
                inside &= place[:, 2] <= float(self.get(f"{block}_upper_z", "inf")) + reach
        if kind == "cylinder":
            axis, start = self.vector(f"{block}_axis", "0,0,1"), place - self.vector(f"{block}_point")
            along = start @ (axis / np.linalg.norm(axis))
            across = np.sqrt(np.maximum(np.sum(start**2, axis=1) - along**2, 0.0))
            inside &= across <= self.vector(f"{block}_radius")[0] + reach
            if self.get(f"{block}_length"):
                inside &= (along >= -reach) & (along <= float(self.get(f"{block}_length")) + reach)
        return inside

    def bodies(self):
        joining = {name for stage in self.stages for name in self.list(f"stage_{stage.name}_bodies")}
        return [
            Body(name, self.get(f"body_{name}_material"), self.polygon(f"body_{name}"), name in joining)
            for name in self.list("bodies")
        ]

    def body_of_points(self, state, origin):
        """Number of each point's body, by where and in which stage it was first; -1 where no region has it."""
        found, births, reach = (
            np.full(len(origin.position), -1),
            self.results.births(state),
            1e-3 * origin.lengths.min(),
        )
        bodies = self.bodies()
        material = state["material"] if "material" in state else np.zeros(len(found), int)
        for step in np.unique(births):
            stage = self.stage_at(step)
            joining = self.list(f"stage_{stage}_bodies") if stage and step > self.results.steps[0] else []
            chosen = [number for number, body in enumerate(bodies) if body.name in joining] or range(len(bodies))
            self._assign(
                found,
                births == step,
                [(number, bodies[number]) for number in chosen],
                (origin.position, material, reach),
            )
        return found

    def _assign(self, found, rows, bodies, places):
        """Bodies of points that came at the same time; those in no region go with a body of their material."""
        position, material, reach = places
        left = []
        for number, body in bodies:
            own = rows & (material == self.materials.index(body.material)) if body.material in self.materials else rows
            left.append((number, own))
            if self.get(f"body_{body.name}_region", "all") != "file":
                own = own & self.contains(f"body_{body.name}", position, reach)
                found[own & ((found < 0) | (self.get(f"body_{body.name}_priority") == "true"))] = number
        for number, own in left:
            found[own & (found < 0)] = number

    # ---- boundaries ----

    def boundary_pose(self, name, time, step=None):
        """Translation (2), rotation (radians) and growth of a boundary in the plane."""
        block = f"boundary_{name}"
        table, shift, turn, growth = self.get(f"{block}_motion_table"), np.zeros(2), 0.0, 0.0
        if table and table != "none":
            try:
                columns = read_columns(table)
                shift = np.array(
                    [np.interp(time, columns["time"], columns.get(key, 0.0 * columns["time"])) for key in ("ux", "uy")]
                )
                turn = np.interp(time, columns["time"], columns["rz"]) if "rz" in columns else 0.0
            except (OSError, KeyError, ValueError):
                pass
        else:
            factor = ramp(self.get(f"{block}_ramp", "0:0,1:1"), time)
            motion, rotation = self.vector(f"{block}_motion"), self.vector(f"{block}_rotation")
            shift[: len(motion)] = factor * motion[:2]
            turn = factor * rotation[-1] if len(rotation) else 0.0
            growth = factor * float(self.get(f"{block}_growth", "0"))
        return shift + self._freed(name, step, shift), math.radians(turn), growth

    def _freed(self, name, step, prescribed):
        """Displacement of a free boundary beside the prescribed one, of the history."""
        more = np.zeros(2)
        try:
            history = self.results.history
        except ResultsError:
            return more
        for axis in range(2):
            column = f"position_{name}_{'xy'[axis]}"
            if column in history and step is not None and len(history["step"]):
                start, row = self.middle(name)[axis], np.searchsorted(history["step"], step, side="right") - 1
                more[axis] = history[column][row] - start - prescribed[axis] if row >= 0 else 0.0
        return more

    def middle(self, name):
        """Place about which a boundary turns."""
        block = f"boundary_{name}"
        for key in ("pivot", "center", "point", "tip"):
            if self.is_given(f"{block}_{key}"):
                return self.vector(f"{block}_{key}")
        if self.get(f"{block}_lower"):
            return 0.5 * (self.vector(f"{block}_lower") + self.vector(f"{block}_upper"))
        corners = self.vector(f"{block}_vertices").reshape(-1, 2)
        return corners.mean(axis=0) if len(corners) else np.zeros(2)

    def boundary_outline(self, name, time, reach, step=None):
        """Outline of a boundary in the plane at a time, (corners, 2), and whether it is closed; None in space."""
        block, kind = f"boundary_{name}", self.get(f"boundary_{name}_type")
        shift, turn, growth = self.boundary_pose(name, time, step)
        if kind == "plane":
            normal, point = self.vector(f"{block}_normal"), self.vector(f"{block}_point")
            along = np.array([-normal[1], normal[0]]) / np.linalg.norm(normal)
            corners, closed = np.array([point - reach * along, point + reach * along]), False
        elif kind == "sphere":
            corners, closed = circle(self.vector(f"{block}_center"), self.vector(f"{block}_radius")[0] + growth), True
        elif kind == "box":
            low, high = self.vector(f"{block}_lower"), self.vector(f"{block}_upper")
            corners, closed = np.array([low, (high[0], low[1]), high, (low[0], high[1])]), True
        elif kind == "polygon":
            corners, closed = self.vector(f"{block}_vertices").reshape(-1, 2), True
        elif kind == "cone":
            axis = self.vector(f"{block}_axis", "0,1")
            axis, half = axis / np.linalg.norm(axis), math.radians(float(self.get(f"{block}_angle", "60")) / 2.0)
            side, radius = np.array([-axis[1], axis[0]]), self.vector(f"{block}_radius")[0]
            rise = radius / math.tan(half)
            local = ((-radius, rise + reach), (-radius, rise), (0.0, 0.0), (radius, rise), (radius, rise + reach))
            corners, closed = np.array([self.vector(f"{block}_tip") + a * side + b * axis for a, b in local]), False
        else:
            return None
        middle = self.middle(name)[:2]
        matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        return (corners - middle) @ matrix.T + middle + shift, closed

    # ---- water ----

    def water_line(self, time, low, high):
        """Water level between two places along x, (corners, 2); None without one."""
        if self.is_given("water_level"):
            factor = ramp(self.get("water_ramp", "0:1") or "0:1", time)
            return np.array(
                [[low, factor * float(self.get("water_level"))], [high, factor * float(self.get("water_level"))]]
            )
        if not self.is_given("water_table"):
            return None
        factor = ramp(self.get("water_table_ramp", "0:1") or "0:1", time)
        table = self.vector("water_table").reshape(-1, 2)
        places = np.unique(np.clip(np.concatenate([[low, high], table[:, 0]]), low, high))
        return np.column_stack([places, factor * np.interp(places, table[:, 0], table[:, 1])])


def circle(centre, radius):
    angle = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
