"""Factor of safety of an undrained slope over stronger ground, beside an upper bound that no exact factor passes.

Slope of 2:1, 10 m, c_u = 50 kPa, 20 kN/m3, over 10 m of ground of twice the strength: Griffiths and Lane (1999), doi:10.1680/
geot.1999.49.3.387, example 4, where the best circle has 2.10. The bound is a kinematic limit analysis of triangles with velocities
of degree 2 without change of volume: strength times shear rate, from its values at the vertices, which are the largest of a linear
field's mean. It falls with the triangles' size: the circle is no limit load.
"""
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from bench.runs import ROOT, Table, median, repeated, run_scene

SCENE = ROOT / "tests" / "verification" / "cases" / "griffiths_lane_4.yaml"
STRENGTH, WEIGHT, RATIO, CIRCLE = 50e3, 20e3, 2.0, 2.10  # Pa, N/m3, of the base over the bank's strength, Taylor's circle
WIDTH, TOP, SLOPE, CREST = 60.0, 20.0, 10.0, 20.0  # m: of the ground, its height, the slope's height, where the crest ends
SWEEPS, VOLUME = 80, 1e4  # solves; stiffness of volume over the median viscosity
CELLS = (10, 20, 40)  # in the slope's height
CORNERS, INSIDE = np.eye(3), np.full((3, 3), 1 / 6) + np.eye(3) / 2  # places in a triangle: vertices, Gauss points
SIDES = ((0, 1), (1, 2), (0, 2))  # vertices beside a node in the middle of a side


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--cells", type=int, help="in the slope's height, for the upper bound alone")


def triangles(cells):
    """Nodes (n, 2) in m and triangles (m, 6) of them: vertices, then middles of the sides; halves of cells twice as wide as high."""
    half = np.array([SLOPE / cells, SLOPE / cells / 2])
    number, found = {}, []
    for i in range(0, 2 * round(WIDTH / half[0] / 2), 2):
        for j in range(0, 4 * cells, 2):
            for vertices in (((i, j), (i + 2, j), (i, j + 2)), ((i + 2, j + 2), (i, j + 2), (i + 2, j))):
                x, y = np.mean(vertices, 0) * half
                if y < TOP - SLOPE or x < CREST + 2 * (TOP - y):
                    middles = [tuple(np.add(vertices[a], vertices[b]) // 2) for a, b in SIDES]
                    found.append([number.setdefault(tuple(map(int, place)), len(number)) for place in (*vertices, *middles)])
    return np.array(list(number)) * half, np.array(found)


def gradients(nodes, elements, places):
    """Gradients (m, places, 6, 2) of the functions at barycentric places, and areas (m)."""
    x = nodes[elements[:, :3]]
    edge = np.roll(x, -1, 1) - np.roll(x, -2, 1)
    area = 0.5 * np.abs(edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    plane = np.stack([edge[..., 1], -edge[..., 0]], -1) / (2 * area[:, None, None])
    vertex = np.einsum("qk,mkd->mqkd", 4 * places - 1, plane)
    side = np.stack([4 * (np.einsum("q,md->mqd", places[:, a], plane[:, b]) + np.einsum("q,md->mqd", places[:, b], plane[:, a]))
                     for a, b in SIDES], 2)
    return np.concatenate([vertex, side], 2), area


def operators(nodes, elements, places):
    """Matrices of stretch, shear and change of volume at the places of all triangles, and the triangles' areas."""
    slope, area = gradients(nodes, elements, places)
    row = np.repeat(np.arange(slope.shape[0] * slope.shape[1]), 6)
    column = np.repeat(2 * elements[:, None], slope.shape[1], 1).ravel()

    def operator(of_x, of_y):
        return sp.csr_matrix((np.concatenate([of_x.ravel(), of_y.ravel()]), (np.concatenate([row, row]), np.concatenate([column, column + 1]))),
                             shape=(slope.shape[0] * slope.shape[1], 2 * len(nodes)))
    x, y = slope[..., 0], slope[..., 1]
    return (operator(x, -y), operator(y, x), operator(x, y)), area


def bound(cells):
    """An upper bound of the factor of safety with `cells` in the slope's height."""
    nodes, elements = triangles(cells)
    parts, area = operators(nodes, elements, INSIDE)
    ends, _ = operators(nodes, elements, CORNERS)
    share = np.repeat(area / 3, 3)
    strength = share * np.repeat(np.where(nodes[elements[:, :3], 1].mean(1) > TOP - SLOPE, 1.0, RATIO), 3)
    weight = np.zeros(2 * len(nodes))
    np.add.at(weight, 2 * elements[:, 3:] + 1, -(area / 3)[:, None])  # the functions of vertices have no mean
    held = np.zeros((len(nodes), 2), bool)
    held[np.isin(nodes[:, 0], (0, WIDTH)), 0] = held[nodes[:, 1] == 0] = True
    free = np.flatnonzero(~held.ravel())
    stretch, shear, volume = (part[:, free] for part in parts)
    weight, viscosity = weight[free], np.ones(len(share))
    for sweep in range(SWEEPS):
        matrix = stretch.T @ sp.diags(strength * viscosity) @ stretch + shear.T @ sp.diags(strength * viscosity) @ shear
        matrix = (matrix + VOLUME * volume.T @ sp.diags(share) @ volume).tocsc()
        speed = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(weight)
        speed /= weight @ speed
        rate = np.hypot(stretch @ speed, shear @ speed)
        viscosity = 1 / np.hypot(rate, rate.max() * 0.01 * max(1e-3, 0.88**sweep))
        viscosity /= np.median(viscosity)
    return STRENGTH / WEIGHT * (strength @ np.hypot(ends[0][:, free] @ speed, ends[1][:, free] @ speed))


def run(arguments):
    table = Table(arguments.out, "slope_limit", ("cells", "factor", "order_2", "upper_bound", "circle", "seconds", "seconds_order_2"))
    if arguments.cells:
        table.add(cells=arguments.cells, upper_bound=bound(arguments.cells), circle=CIRCLE)
        return
    for cells in CELLS[:1] if arguments.quick else CELLS:
        order = {"mpm_shape": "gimp_element", "mpm_order": 2, "mpm_body_bank_points_per_cell": "3,3", "mpm_body_base_points_per_cell": "3,3"}
        runs = [repeated(arguments.repeat or 1, lambda options=options: run_scene(
            arguments.program, SCENE, {"mpm_grid_refine": cells // 10} | options, arguments.ranks)) for options in ({}, order)]
        table.add(cells=cells, factor=runs[0][0]["factor_of_safety"], order_2=runs[1][0]["factor_of_safety"], upper_bound=bound(cells),
                  circle=CIRCLE, seconds=median(runs[0], "time_total_s"), seconds_order_2=median(runs[1], "time_total_s"))
