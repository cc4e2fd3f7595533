"""The force on a rigid disc pressed into a block, by finite elements: the reference of kratos.py.

    python kratos_reference.py

Total-Lagrangian nine-node quadrilaterals in plane strain, graded towards the contact, the law of kratos.yaml, and a penalty of
1e6 E per metre on the nodes of the top that stand in the disc, by their part of the length. It needs scipy, and some minutes:

    20 elements over the height: 3315.68 N/m, half-width 0.1791 m
    40 elements over the height: 3320.57 N/m, half-width 0.1685 m
    80 elements over the height: 3320.18 N/m, half-width 0.1734 m
"""
import numpy as np

E, NU, RADIUS, WIDTH, HEIGHT, DEPTH = 1e6, 0.3, 4.0, 1.5, 1.0, 0.01  # Pa, -, m
PENALTY = 1e6 * E  # Pa/m
GRADING = 2.2


def line_shapes(t):
    return np.array([t * (t - 1.0) / 2.0, 1.0 - t * t, t * (t + 1.0) / 2.0])


def line_slopes(t):
    return np.array([t - 0.5, -2.0 * t, t + 0.5])


def mesh(count_x, count_y):
    """Coordinates of the corners on both axes with those of the nodes midway, and the nodes of each element."""
    corners = (WIDTH * np.linspace(0.0, 1.0, count_x + 1) ** GRADING,
               HEIGHT * (1.0 - np.linspace(1.0, 0.0, count_y + 1) ** GRADING))
    axes = []
    for corner in corners:
        axis = np.empty(2 * len(corner) - 1)
        axis[::2], axis[1::2] = corner, 0.5 * (corner[1:] + corner[:-1])
        axes.append(axis)
    first = 2 * np.arange(count_y)[:, None] * len(axes[0]) + 2 * np.arange(count_x)
    local = (np.arange(3)[:, None] * len(axes[0]) + np.arange(3)).ravel()
    return axes, first.ravel()[:, None] + local


def gradients(axes, elements):
    """Of the shape functions at the Gauss points: (elements, points, nodes, 2), and weights times areas."""
    points, weights = [-np.sqrt(0.6), 0.0, np.sqrt(0.6)], [5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0]
    x, y = np.meshgrid(*axes)
    size_x = np.ptp(x.ravel()[elements], axis=1)
    size_y = np.ptp(y.ravel()[elements], axis=1)
    slopes, areas = [], []
    for s, weight_s in zip(points, weights):
        for t, weight_t in zip(points, weights):
            by_x = np.outer(line_shapes(t), line_slopes(s)).ravel()[None] * 2.0 / size_x[:, None]
            by_y = np.outer(line_slopes(t), line_shapes(s)).ravel()[None] * 2.0 / size_y[:, None]
            slopes.append(np.stack([by_x, by_y], axis=-1))
            areas.append(weight_s * weight_t * size_x * size_y / 4.0)
    return np.stack(slopes, axis=1), np.stack(areas, axis=1)


def internal(u, elements, slopes, areas):
    """Forces and stiffness of tau = mu (b - I) + lambda ln(J) I, as (elements, 18) and (elements, 18, 18)."""
    mu, lame = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    F = np.eye(2) + np.einsum("eni,egnj->egij", u[elements], slopes)
    J = np.linalg.det(F)
    inverse = np.linalg.inv(F)  # (J, i)
    pressure = mu - lame * np.log(J)
    P = mu * F - pressure[..., None, None] * np.swapaxes(inverse, -1, -2)
    spatial = np.einsum("egnj,egji->egni", slopes, inverse)  # by the deformed place
    force = np.einsum("egij,egnj,eg->eni", P, slopes, areas)
    stiffness = mu * np.einsum("egnj,egmj,eg,ik->enimk", slopes, slopes, areas, np.eye(2))
    stiffness += np.einsum("eg,egnk,egmi->enimk", pressure * areas, spatial, spatial)
    stiffness += lame * np.einsum("eg,egni,egmk->enimk", areas, spatial, spatial)
    count = 2 * elements.shape[1]
    return force.reshape(-1, count), stiffness.reshape(-1, count, count)


def contact(place, share, depth):
    """Force of the disc on the nodes of the top, and minus its derivative."""
    way = place - [0.0, HEIGHT + RADIUS - depth]
    distance = np.linalg.norm(way, axis=1)
    normal = way / distance[:, None]
    gap = np.minimum(distance - RADIUS, 0.0)
    stiff = PENALTY * share * (gap < 0.0)
    both = normal[:, :, None] * normal[:, None, :]
    across = (gap / distance)[:, None, None] * (np.eye(2) - both)
    return -(stiff * gap)[:, None] * normal, stiff[:, None, None] * (both + across)


def force_on_disc(count_x, count_y, depth=DEPTH, steps=4):
    """Force on the half disc, N/m, and the half-width of the contact, m."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import spsolve

    axes, elements = mesh(count_x, count_y)
    slopes, areas = gradients(axes, elements)
    x, y = np.meshgrid(*axes)
    start = np.column_stack([x.ravel(), y.ravel()])
    size = 2 * len(start)
    dofs = (2 * elements[:, :, None] + np.arange(2)).reshape(len(elements), -1)
    rows, columns = np.repeat(dofs, dofs.shape[1], axis=1).ravel(), np.tile(dofs, (1, dofs.shape[1])).ravel()
    top = np.flatnonzero(start[:, 1] > HEIGHT - 1e-12)
    share = np.zeros(len(top))
    lengths = np.diff(axes[0])[::2] * 2.0
    for k, length in enumerate(lengths):
        share[2 * k:2 * k + 3] += length * np.array([1.0, 4.0, 1.0]) / 6.0
    free = np.ones(size, bool)
    free[2 * np.flatnonzero(start[:, 0] < 1e-12)] = False
    free[2 * np.flatnonzero(start[:, 1] < 1e-12) + 1] = False
    u = np.zeros_like(start)
    for step in range(1, steps + 1):
        for _ in range(40):
            inner, blocks = internal(u, elements, slopes, areas)
            pushed, stiff = contact(start[top] + u[top], share, depth * step / steps)
            residual = -np.bincount(dofs.ravel(), inner.ravel(), size)
            residual += np.bincount((2 * top[:, None] + np.arange(2)).ravel(), pushed.ravel(), size)
            matrix = csr_matrix((blocks.ravel(), (rows, columns)), (size, size))
            pairs = 2 * top[:, None, None] + np.arange(2)
            matrix += csr_matrix((stiff.ravel(), (np.repeat(pairs, 2, axis=1).transpose(0, 2, 1).ravel(),
                                                 np.repeat(pairs, 2, axis=1).ravel())), (size, size))
            move = np.zeros(size)
            move[free] = spsolve(matrix[free][:, free].tocsc(), residual[free])
            u += move.reshape(-1, 2)
            if np.abs(move).max() < 1e-12:
                break
        else:
            raise RuntimeError(f"no convergence in step {step}")
    touching = start[top, 0][np.abs(pushed).max(axis=1) > 0.0]
    return -pushed[:, 1].sum(), touching.max()


if __name__ == "__main__":
    for cells in (20, 40, 80):
        force, width = force_on_disc(round(1.25 * cells), cells)
        print(f"{cells} elements over the height: {force:.2f} N/m, half-width {width:.4f} m", flush=True)
