/*
  Ghost penalty: a stabilization of small-cut nodes, those that only a sliver of the material touches.

  The grid's field is a spline of degree p, linear basis functions (p = 1) under GIMP too, and a polynomial on each knot
  span: the grid's cells, or for even p the cells around nodes. Spans that a point's domain touches are material; one
  with an empty neighbour in the grid is an edge span. On every face F between two material spans, one of them at least
  an edge span or made of a material with sparse points, the step's increment u gets the energy

    (gamma/2) E_s h_n^{2p-1} Int_F |[d^p u/dn^p]|^2 dA ,    h_n^p [d^p u/dn^p] = the (p + 1)-th difference of u along n

  over the p + 2 nodes that the two spans share out along the normal n; along the face the spline's mass matrix of one
  span integrates. E_s is Young's modulus of the stiffest material beside the face. The badly supported node is tied to
  the polynomial extension of its neighbours, whatever sliver touches it, and the energy vanishes for any polynomial of
  degree p. Acting on increments, it puts no lasting force on the material. Where a spline ends, at the grid's edge or a
  wall, nodes beyond have the coefficients of the shape functions there.

  Beside the displacement, where a physics has a factor for it, the one other component gets such an energy on its
  total, with that factor in place of E_s. For a pore pressure it is dt m + h^2/(2 mu), with m the mobility, the second
  fading with the first, so that the pressure is tied to its neighbours whether water has time to flow or not. The
  penalty's rows sum to zero: no water comes of it.

  Sparse points, one a cell on some axis from the start or by stretch, do not resolve the grid's field: nodal
  displacements that alternate from cell to cell strain no point, and a body folds up in them as it bends. These modes
  have the largest jumps of all, so that the penalty on every face, with gamma of at least MPM_GHOST_SPARSE, restores
  their stiffness. For a smooth field the jump is of order h^p and the penalty of the order of the discretisation error
  (Burman and Hansbo 2004, doi:10.1016/j.cma.2003.12.032, stabilise convection in this way).

  Flow whose dilation is less than its friction loses ellipticity long before a peak: increments that alternate from one
  row of cells to the next cost nothing, or less. An interior penalty, of the displacement alone, is this energy on
  every face with a factor of its own (MpmRules): the shorter a band, the stronger its effect, and it fades with h as
  the above does.

  Elements of order p, whose derivatives of all degrees jump, have the sum of such energies over them (ghost_faces.c).

  A face is a group of nodes without points: numbering and sparsity treat it like one.

  Sources: Burman (2010), doi:10.1016/j.crma.2010.10.006; for the material point method Coombs (2023),
  doi:10.1002/nme.7332.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/ghost_faces.h"
#include "volume/volume.h"

static PetscErrorCode Boxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(MpmGhostFaces(rules, points, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* out = A in along one axis of a box: `n` nodes of it, `before` and `after` of those that vary faster and slower. */
static void AxisApply(PetscInt before, PetscInt n, PetscInt after, const PetscReal A[], const PetscReal in[],
                      PetscReal out[])
{
  for (PetscInt k = 0; k < after; k++) {
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt b = 0; b < before; b++) {
        PetscReal s = 0.;

        for (PetscInt j = 0; j < n; j++) s += A[i * n + j] * in[(k * n + j) * before + b];
        out[(k * n + i) * before + b] = s;
      }
    }
  }
}

/* Components under the penalty: those of the displacement, and the one beside it where the physics has a factor. */
static PetscInt Components(const MpmSum *sum)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   dim    = layout->dim;

  return layout->ghost && layout->block == dim + 1 && !layout->component[dim].shape ? dim + 1 : dim;
}

/* True where the face's matrix reaches into dry ground, where the slope of the pressure jumps. */
static PetscBool IsDry(const MpmSum *sum, const MpmFace *face)
{
  const MpmGroup *box =
    &sum->space->groups[sum->space->boxes.faces.begin + (PetscInt)(face - sum->space->boxes.faces.face)];
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; sum->still.bent && i < box->node_count; i++)
    if (nodes[i] >= 0 && sum->still.bent[nodes[i]]) return PETSC_TRUE;
  return PETSC_FALSE;
}

#define LONG 1e20 /* in which all that is stored flows off */

/* Penalty on the water's pressure: flow and storage, or flow alone. */
static PetscReal Flow(const MpmSum *sum, const MpmPhysicsMaterial *of, const PetscReal parameter[], PetscReal h)
{
  return sum->step.drained ? sum->layout->ghost(of, parameter, LONG * sum->step.dt, h) / LONG
                           : sum->layout->ghost(of, parameter, sum->step.dt, h);
}

/* The circumference at the middle of a face's box, m; 1 without axial symmetry. */
static PetscReal Turn(const MpmSum *sum, const MpmFace *face)
{
  const MpmGrid  *grid = sum->grid;
  const MpmGroup *box =
    &sum->space->groups[sum->space->boxes.faces.begin + (PetscInt)(face - sum->space->boxes.faces.face)];
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, box->first, at);
  return MpmGridTurn(grid, grid->lower[0] + grid->h[0] * (MpmGridNodeXi(grid, at[0]) +
                                                          0.5 * MpmGridNodeStep(grid, at[0], box->count[0] - 1)));
}

/* Factor on a face's matrix, for one of the components. */
static PetscReal Factor(const MpmSum *sum, const MpmFace *face, PetscInt c)
{
  const PetscReal turn = Turn(sum, face);
  PetscReal       factor[2];

  if (c < sum->layout->dim) return turn * face->stiffness;
  if (IsDry(sum, face)) return 0.;
  for (PetscInt k = 0; k < 2; k++) {
    const MpmMaterial       *material = &sum->materials[face->material[k]];
    const MpmPhysicsMaterial of       = MpmMaterialForPhysics(material, NULL, sum->layout->dim);

    factor[k] = Flow(sum, &of, material->physics_parameter, sum->cell[face->axis]);
  }
  /* where permeability jumps so does the gradient: the lesser one */
  return turn * face->gamma * (PetscAbsReal(factor[0]) < PetscAbsReal(factor[1]) ? factor[0] : factor[1]);
}

/* y += factor times the face's matrix, on component c of the values u of the local nodes, `bs` a node. */
static void AddFace(const MpmSpace *space, PetscInt f, PetscInt c, PetscInt bs, PetscReal factor, const PetscReal u[],
                    PetscReal y[])
{
  const MpmFace  *face = &space->boxes.faces.face[f];
  const MpmGroup *box  = &space->groups[space->boxes.faces.begin + f];
  const PetscInt  n = box->node_count, *nodes = &space->group_nodes[box->node_offset];
  PetscReal       value[2][MPM_FACE_NODES];
  PetscInt        before = 1, now = 0;

  for (PetscInt i = 0; i < n; i++) value[0][i] = u[nodes[i] * bs + c];
  for (PetscInt a = 0; a < space->dim; before *= box->count[a], a++, now = !now)
    AxisApply(before, box->count[a], n / (before * box->count[a]), face->along[a], value[now], value[!now]);
  for (PetscInt i = 0; i < n; i++) y[nodes[i] * bs + c] += factor * value[now][i];
}

/* Linear: the residual of u is the action on it. */
static PetscErrorCode AddForces(const MpmSum *sum, const PetscReal u[], PetscReal residual[])
{
  const MpmSpace *space = sum->space;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->boxes.faces.count; f++)
    for (PetscInt c = 0; c < Components(sum); c++)
      AddFace(space, f, c, sum->block, Factor(sum, &space->boxes.faces.face[f], c), u, residual);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal of a face's matrix at node i of its box. */
static PetscReal FaceDiagonal(const MpmSpace *space, PetscInt f, PetscInt i)
{
  const MpmFace  *face  = &space->boxes.faces.face[f];
  const PetscInt *count = space->groups[space->boxes.faces.begin + f].count;
  PetscReal       value = 1.;

  for (PetscInt a = 0; a < space->dim; i /= count[a], a++) value *= face->along[a][(i % count[a]) * (count[a] + 1)];
  return value;
}

/* gamma rho h^2, kg/m: of the lighter side, so that the penalty is small beside the mass. */
static PetscReal MassFactor(const MpmSum *sum, const MpmFace *face)
{
  const PetscReal density =
    PetscMin(sum->materials[face->material[0]].density, sum->materials[face->material[1]].density);

  return Turn(sum, face) * face->gamma * density * PetscSqr(sum->cell[face->axis]);
}

PetscErrorCode MpmGhostMass(const MpmSum *sum, const PetscReal a[], PetscReal y[])
{
  const MpmSpace *space = sum->space;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->boxes.faces.count; f++)
    for (PetscInt c = 0; c < space->dim; c++)
      AddFace(space, f, c, space->dim, MassFactor(sum, &space->boxes.faces.face[f]), a, y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostMassDiagonal(const MpmSum *sum, PetscReal diagonal[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  dim   = space->dim;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->boxes.faces.count; f++) {
    const MpmGroup *box    = &space->groups[space->boxes.faces.begin + f];
    const PetscInt *nodes  = &space->group_nodes[box->node_offset];
    const PetscReal factor = MassFactor(sum, &space->boxes.faces.face[f]);

    for (PetscInt k = 0; k < box->node_count * dim; k++)
      diagonal[nodes[k / dim] * dim + k % dim] += factor * FaceDiagonal(space, f, k / dim);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim, components = Components(sum);

  PetscFunctionBeginUser;
  (void)ctx;
  (void)u;
  (void)failed;
  for (PetscInt f = 0; f < space->boxes.faces.count; f++) {
    const MpmFace  *face      = &space->boxes.faces.face[f];
    const MpmGroup *box       = &space->groups[space->boxes.faces.begin + f];
    const PetscInt *nodes     = &space->group_nodes[box->node_offset];
    const PetscReal stiffness = Factor(sum, face, 0),
                    other     = components > dim ? Factor(sum, face, dim) / stiffness : 0.;

    for (PetscInt i = 0; i < box->node_count; i++) {
      const PetscReal value = stiffness * FaceDiagonal(space, f, i);

      for (PetscInt c = 0; c < components; c++) blocks[(nodes[i] * bs + c) * bs + c] += c < dim ? value : other * value;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The face's matrix, the same for every component of the displacement; returns its number of nodes. */
static PetscInt FaceMatrix(const MpmSum *sum, PetscInt f, PetscReal matrix[])
{
  const MpmSpace *space     = sum->space;
  const MpmFace  *face      = &space->boxes.faces.face[f];
  const PetscReal stiffness = Factor(sum, face, 0);
  const PetscInt *count     = space->groups[space->boxes.faces.begin + f].count,
                 n          = space->groups[space->boxes.faces.begin + f].node_count;

  for (PetscInt p = 0; p < n / count[0]; p++) { /* lines of nodes along the first axis */
    for (PetscInt q = 0; q < n / count[0]; q++) {
      PetscReal value = stiffness;

      for (PetscInt a = 1, i = p, j = q; a < space->dim; i /= count[a], j /= count[a], a++)
        value *= face->along[a][i % count[a] * count[a] + j % count[a]];
      for (PetscInt i = 0; i < count[0]; i++)
        for (PetscInt j = 0; j < count[0]; j++)
          matrix[(p * count[0] + i) * n + q * count[0] + j] = value * face->along[0][i * count[0] + j];
    }
  }
  return n;
}

static PetscErrorCode AddElements(const MpmSum *sum, MpmPattern *pattern)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim, components = Components(sum);
  PetscInt        most = 0;
  PetscReal      *matrix, *element;

  PetscFunctionBeginUser;
  if (!space->boxes.faces.count) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt f = 0; f < space->boxes.faces.count; f++)
    most = PetscMax(most, space->groups[space->boxes.faces.begin + f].node_count);
  PetscCall(PetscMalloc1((most * most), &matrix));
  PetscCall(PetscMalloc1((most * most * bs * bs), &element));
  for (PetscInt f = 0; f < space->boxes.faces.count; f++) {
    const MpmFace  *face  = &space->boxes.faces.face[f];
    const PetscInt  n     = FaceMatrix(sum, f, matrix);
    const PetscReal other = components > dim ? Factor(sum, face, dim) / Factor(sum, face, 0) : 0.;

    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = 0; c < dim; c++)
        for (PetscInt j = 0; j < n; j++) element[((i * bs + c) * bs + c) * n + j] = matrix[i * n + j];
    for (PetscInt k = 0; k < n * n && components > dim; k++)
      element[((k / n * bs + dim) * bs + dim) * n + k % n] = other * matrix[k];
    MpmPatternAddBlock(pattern, space, &space->groups[space->boxes.faces.begin + f], element);
  }
  PetscCall(PetscFree(matrix));
  PetscCall(PetscFree(element));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)failed;
  PetscCall(AddForces(sum, u, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)u;
  PetscCall(AddForces(sum, du, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)failed;
  PetscCall(AddElements(sum, pattern));
  if (residual) PetscCall(AddForces(sum, u, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermGhost = {.name             = "ghost penalty",
                              .boxes            = Boxes,
                              .residual         = Residual,
                              .tangent          = Tangent,
                              .apply            = Apply,
                              .diagonal         = Diagonal,
                              .energy.quadratic = MpmTermIsQuadratic};
