/*
  Conditions along normals: a node with one of them has an orthonormal frame q_1, q_2 (, q_3).

  The conditions on such a node are equations a_k . u = g_k, with a_k a normal or an axis. Gram and Schmidt's method
  turns them into constrained components of the frame, a_k = sum_r L_kr q_r, so that v_r = q_r . u follows from L v = g;
  the remaining q_r are free. An equation that depends on those before it adds nothing: equations come with the last
  condition first, so that the last one prevails, as for single components.

  The solver's unknowns of the node are its components in the frame, u = Q^T v. Q is orthonormal: the Jacobian's node
  blocks become Q_i K_ij Q_j^T, symmetric where K is, and norms stay. All sums over points work on u: frames are known
  in this file alone.
*/
#include "bc/bc.h"

#define DEPENDENT 1e-6 /* remainder of a unit vector that depends on others */

void MpmFrameAdd(MpmFrame *frame, PetscInt dim, const PetscReal a[], PetscReal g, PetscInt condition)
{
  const PetscInt r                 = frame->constrained;
  PetscReal      rest[MPM_MAX_DIM] = {0., 0., 0.}, along[MPM_MAX_DIM] = {0., 0., 0.}, norm = 0.;

  if (r == dim) return;
  for (PetscInt c = 0; c < dim; c++) rest[c] = a[c];
  for (PetscInt pass = 0; pass < 2; pass++) { /* twice is enough for full accuracy */
    for (PetscInt k = 0; k < r; k++) {
      PetscReal dot = 0.;

      for (PetscInt c = 0; c < dim; c++) dot += rest[c] * frame->axis[k][c];
      for (PetscInt c = 0; c < dim; c++) rest[c] -= dot * frame->axis[k][c];
      along[k] += dot;
    }
  }
  for (PetscInt c = 0; c < dim; c++) norm += rest[c] * rest[c];
  norm = PetscSqrtReal(norm);
  if (norm < DEPENDENT) return;
  for (PetscInt k = 0; k < r; k++) g -= along[k] * frame->value[k];
  along[r]            = norm;
  frame->value[r]     = g / norm;
  frame->condition[r] = condition;
  for (PetscInt c = 0; c < dim; c++) {
    frame->axis[r][c]   = rest[c] / norm;
    frame->factor[r][c] = along[c];
  }
  frame->constrained++;
}

void MpmFrameComplete(MpmFrame *frame, PetscInt dim)
{
  const PetscInt constrained = frame->constrained;

  while (frame->constrained < dim) {
    PetscReal least[MPM_MAX_DIM] = {0., 0., 0.}, a[MPM_MAX_DIM] = {0., 0., 0.};
    PetscInt  best = 0;

    /* the axis that the frame knows least about */
    for (PetscInt c = 0; c < dim; c++) {
      for (PetscInt k = 0; k < frame->constrained; k++) least[c] += PetscSqr(frame->axis[k][c]);
      if (least[c] < least[best]) best = c;
    }
    a[best] = 1.;
    MpmFrameAdd(frame, dim, a, 0., -1);
  }
  frame->constrained = constrained;
}

/* values <- Q values, or Q^T values, at the first `nodes` local nodes */
static void Rotate(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscBool transposed,
                   PetscReal values[])
{
  const PetscInt dim = constraints->dim;

  for (PetscInt i = 0; constraints->frame_of && i < nodes; i++) {
    const MpmFrame *frame = MpmConstraintsFrame(constraints, i);
    PetscReal       result[MPM_MAX_DIM];

    if (!frame) continue;
    for (PetscInt r = 0; r < dim; r++) {
      result[r] = 0.;
      for (PetscInt c = 0; c < dim; c++)
        result[r] += (transposed ? frame->axis[c][r] : frame->axis[r][c]) * values[i * bs + c];
    }
    for (PetscInt r = 0; r < dim; r++) values[i * bs + r] = result[r];
  }
}

void MpmFramesToUnknowns(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[])
{
  Rotate(constraints, bs, nodes, PETSC_FALSE, values);
}

void MpmFramesToAxes(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[])
{
  Rotate(constraints, bs, nodes, PETSC_TRUE, values);
}

/* Replaces the entries of the frame's dim values, `stride` apart, by their components in the frame. */
static void RotateEntries(const MpmFrame *frame, PetscInt dim, PetscInt stride, PetscReal values[])
{
  PetscReal result[MPM_MAX_DIM];

  for (PetscInt r = 0; r < dim; r++) {
    result[r] = 0.;
    for (PetscInt c = 0; c < dim; c++) result[r] += frame->axis[r][c] * values[c * stride];
  }
  for (PetscInt r = 0; r < dim; r++) values[r * stride] = result[r];
}

void MpmFramesRotateVector(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                           PetscReal values[])
{
  for (PetscInt i = 0; constraints->frame_of && i < n; i++) {
    const MpmFrame *frame = nodes[i] < 0 ? NULL : MpmConstraintsFrame(constraints, nodes[i]);

    if (frame) RotateEntries(frame, constraints->dim, 1, &values[i * bs]);
  }
}

void MpmFramesRotateElement(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                            PetscReal element[])
{
  const PetscInt dim = constraints->dim;

  for (PetscInt i = 0; constraints->frame_of && i < n; i++) {
    const MpmFrame *frame = nodes[i] < 0 ? NULL : MpmConstraintsFrame(constraints, nodes[i]);

    if (!frame) continue;
    /* the rows of node i, [i][.][d][j]; then its columns, [j][c][.][i] */
    for (PetscInt k = 0; k < bs * n; k++) RotateEntries(frame, dim, bs * n, &element[i * bs * bs * n + k]);
    for (PetscInt k = 0; k < bs * n; k++) RotateEntries(frame, dim, n, &element[k * bs * n + i]);
  }
}

void MpmFramesRotateBlocks(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal blocks[])
{
  const PetscInt dim = constraints->dim;

  for (PetscInt i = 0; constraints->frame_of && i < nodes; i++) {
    const MpmFrame *frame = MpmConstraintsFrame(constraints, i);

    if (!frame) continue;
    for (PetscInt k = 0; k < bs; k++) RotateEntries(frame, dim, bs, &blocks[i * bs * bs + k]);
    for (PetscInt k = 0; k < bs; k++) RotateEntries(frame, dim, 1, &blocks[(i * bs + k) * bs]);
  }
}

void MpmFrameForces(const MpmFrame *frame, PetscInt dim, const PetscReal force[], PetscReal amount[])
{
  for (PetscInt r = frame->constrained - 1; r >= 0; r--) {
    PetscReal rest = 0.;

    for (PetscInt c = 0; c < dim; c++) rest += frame->axis[r][c] * force[c];
    for (PetscInt k = r + 1; k < frame->constrained; k++) rest -= frame->factor[k][r] * amount[k];
    amount[r] = rest / frame->factor[r][r];
  }
}
