/*
  Faces of the ghost penalty (ghost_penalty.c has the equations): which faces between pieces get one, and the matrix

    Int_F [d^p N_i/dn^p] [d^p N_j/dn^p] dA

  of each as a Kronecker product over the axes: jumps along the normal, the spline's mass matrix of one piece along the
  face. Elements of order p have jumps of all derivatives 1 to p,

    sum_k 3/((2k + 1) k!^2) h^{2k-1} Int_F [d^k N_i/dn^k] [d^k N_j/dn^k] dA ,

  the factors being those of the energy of a Taylor series over the face's cells, and 1 for k = 1. The matrices of one
  axis are those of all faces.

  Sources: Sticko, Ludvigsson and Kreiss (2020), doi:10.1007/s10444-020-09783-z, for the factors; Wichrowski (2025),
  arXiv:2503.00246, for products of matrices along the axes.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "extension/pieces.h"
#include "grid/shape_element.h"
#include "space/rules.h"
#include "space/space.h"
#include "volume/ghost_faces.h"
#include "volume/material_pieces.h"

/* The (p + 1)-th difference, and the mass matrix of p + 1 splines on one piece (times `whole`), h = 1. */
static const PetscReal difference[3][5] = {{1., -2., 1.}, {-1., 3., -3., 1.}, {1., -4., 6., -4., 1.}};
static const PetscReal mass[3][16]      = {
       {2., 1., 1., 2.},
       {6., 13., 1., 13., 54., 13., 1., 13., 6.},
       {20., 129., 60., 1., 129., 1188., 933., 60., 60., 933., 1188., 129., 1., 60., 129., 20.},
};
static const PetscReal whole[3] = {6., 120., 5040.};

/* Numbers of a face's matrix along one axis. */
static PetscInt MatrixSize(MpmKnots knots)
{
  return PetscSqr(knots.order > 1 ? 2 * knots.order + 1 : knots.degree + 2);
}

/* Adds `value` to the nodes of the box that stand for a node: itself, or the masters of one at or beyond an edge. */
static void Fold(const MpmFace *face, const MpmGroup *box, PetscInt a, PetscInt node, PetscReal value, PetscReal to[])
{
  const PetscInt inside = face->edge[a] == MPM_EDGE_OPEN ? 1 : 0; /* the first node that stands for itself */
  const PetscInt step   = node < face->lower[a] + inside ? 1 : node > face->upper[a] - inside ? -1 : 0;
  const PetscInt edge   = (step > 0 ? face->lower[a] : face->upper[a]) - box->first[a];

  if (!step) to[node - box->first[a]] += value;
  for (PetscInt k = 0; step && k <= face->knots.degree; k++) {
    const PetscReal coefficient =
      MpmEdgeCoefficient(face->edge[a], face->knots.degree, PetscAbsInt(edge + box->first[a] - node), k);

    if (coefficient != 0.) to[edge + step * k] += coefficient * value;
  }
}

/* The jump over the face at the nodes of its box along the normal; PETSC_FALSE where an edge has removed the knot. */
static PetscBool Jump(const MpmFace *face, const MpmGroup *box, PetscReal jump[])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < box->count[face->axis]; k++) jump[k] = 0.;
  for (PetscInt k = 0; k < face->knots.degree + 2; k++)
    Fold(face, box, face->axis, face->first[face->axis] + k, difference[face->knots.degree - 1][k], jump);
  for (PetscInt k = 0; k < box->count[face->axis]; k++) most = PetscMax(most, PetscAbsReal(jump[k]));
  return (PetscBool)(most > 1e-12); /* differences are about 1 */
}

/* The face's matrix along one axis, count x count, for its Kronecker product. */
static void AxisMatrix(MpmFace *face, const MpmGroup *box, PetscInt a, PetscReal h)
{
  const PetscInt p = face->knots.degree, n = box->count[a];
  PetscReal     *matrix = face->along[a];
  PetscReal      rows[(MPM_FACE_WIDTH - 1) * MPM_FACE_WIDTH], jump[MPM_FACE_WIDTH];

  for (PetscInt k = 0; k < n * n; k++) matrix[k] = 0.;
  if (a == face->axis) {
    (void)Jump(face, box, jump);
    for (PetscInt k = 0; k < n * n; k++) matrix[k] = jump[k / n] * jump[k % n] / h;
    return;
  }
  for (PetscInt i = 0; i <= p; i++) {
    for (PetscInt k = 0; k < n; k++) rows[i * n + k] = 0.;
    for (PetscInt j = 0; j <= p; j++)
      Fold(face, box, a, face->first[a] + j, mass[p - 1][i * (p + 1) + j] * h / whole[p - 1], &rows[i * n]);
  }
  for (PetscInt k = 0; k < n; k++) {
    PetscReal column[MPM_FACE_WIDTH] = {0.};

    for (PetscInt i = 0; i <= p; i++) Fold(face, box, a, face->first[a] + i, rows[i * n + k], column);
    for (PetscInt i = 0; i < n; i++) matrix[i * n + k] = column[i];
  }
}

/* The box of a face's nodes between the edges; PETSC_FALSE where there is no room for it, or nothing can jump. */
static PetscBool FaceBox(const MpmSpace *space, const MpmRules *rules, const PetscInt piece[], MpmFace *face,
                         MpmGroup *box)
{
  const MpmGrid *grid = rules->grid;
  PetscReal      jump[MPM_FACE_WIDTH];

  MpmPieceEdges(space, rules, face->knots, piece, face->lower, face->upper);
  box->node_count  = 1;
  box->point_begin = box->point_end = 0;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscInt last, low, high, reach, from;

    face->first[a] = box->first[a] = 0;
    box->count[a]                  = 1;
    if (a >= grid->dim) continue;
    face->edge[a]  = MpmEdgeOf(rules->edge, face->knots.degree, face->upper[a] - face->lower[a]);
    face->first[a] = MpmPieceFirstNode(face->knots, piece[a]);
    last           = face->first[a] + face->knots.degree + (a == face->axis);
    /* the box must contain the nodes that represent those beyond an edge, and at an open one on it */
    reach = face->edge[a] == MPM_EDGE_OPEN ? face->knots.degree : 1;
    from  = face->edge[a] == MPM_EDGE_OPEN ? 0 : 1;
    low   = PetscMax(face->first[a], face->lower[a]);
    high  = PetscMin(last, face->upper[a]);
    if (face->lower[a] - face->first[a] >= from) high = PetscMax(high, face->lower[a] + reach);
    if (last - face->upper[a] >= from) low = PetscMin(low, face->upper[a] - reach);
    if (high <= low || high > face->upper[a] || low < face->lower[a]) return PETSC_FALSE;
    box->first[a] = low;
    box->count[a] = high - low + 1;
    box->node_count *= box->count[a];
  }
  return Jump(face, box, jump);
}

/* FaceBox() of elements; PETSC_FALSE where an edge lies between the two cells. */
static PetscBool ElementBox(const MpmSpace *space, const MpmRules *rules, const PetscInt piece[], MpmFace *face,
                            MpmGroup *box)
{
  const PetscInt p = face->knots.order;

  MpmPieceEdges(space, rules, face->knots, piece, face->lower, face->upper);
  *box = (MpmGroup){.count = {1, 1, 1}, .node_count = 1};
  for (PetscInt a = 0; a < space->dim; a++) {
    box->first[a] = MpmPieceFirstNode(face->knots, piece[a]);
    box->count[a] = a == face->axis ? 2 * p + 1 : p + 1;
    box->node_count *= box->count[a];
    if (piece[a] < face->lower[a] || piece[a] + (a == face->axis) >= face->upper[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Matrices of elements by axis, in cells of size h: jumps at 2a, masses at 2a + 1 of `matrix`. */
static void ElementMatrices(const MpmSpace *space, PetscInt p, const PetscReal h[], PetscReal matrix[])
{
  const PetscInt size = PetscSqr(2 * p + 1), n = 2 * p + 1;

  for (PetscInt a = 0; a < space->dim; a++) {
    PetscReal *jumps = &matrix[2 * a * size], *masses = jumps + size, factor = 3. / h[a];

    for (PetscInt k = 0; k < size; k++) jumps[k] = 0.;
    for (PetscInt d = 1; d <= p; d++) {
      PetscReal jump[MPM_FACE_WIDTH] = {0.}, end[MPM_FACE_WIDTH];

      factor /= (PetscReal)(d * d);
      MpmElementDerivatives(p, d, 0.5, end);
      for (PetscInt i = 0; i <= p; i++) jump[i] -= end[i];
      MpmElementDerivatives(p, d, -0.5, end);
      for (PetscInt i = 0; i <= p; i++) jump[p + i] += end[i];
      for (PetscInt k = 0; k < size; k++) jumps[k] += factor / (PetscReal)(2 * d + 1) * jump[k / n] * jump[k % n];
    }
    MpmElementMass(p, masses);
    for (PetscInt k = 0; k < (p + 1) * (p + 1); k++) masses[k] *= h[a];
  }
}

/* Gives a face its matrices: of the k-th face, or of the axes, which all faces share. */
static void SetMatrices(const MpmSpace *space, const PetscReal h[], PetscInt k, const MpmGroup *box, MpmFace *face)
{
  const PetscInt size = MatrixSize(face->knots);

  for (PetscInt a = 0; a < space->dim; a++) {
    const PetscInt place = face->knots.order > 1 ? 2 * a + (a != face->axis) : k * space->dim + a;

    face->along[a] = &space->boxes.faces.matrix[place * size];
    if (face->knots.order == 1) AxisMatrix(face, box, a, h[a]);
  }
}

/* Lists the faces whose lower piece is one of these; counts them where `faces` is NULL. */
static PetscInt ListFaces(const MpmMaterialPieces *map, const MpmRules *rules, PetscInt piece_count,
                          const PetscInt pieces[], MpmFace faces[], MpmGroup boxes[])
{
  const MpmGrid     *grid      = rules->grid;
  const MpmMaterial *materials = rules->materials;
  PetscInt           count     = 0;

  for (PetscInt k = 0; k < piece_count; k++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmMaterialPieceAt(map, pieces[k], cell);
    for (PetscInt axis = 0; axis < map->dim; axis++) {
      PetscInt next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]};
      MpmFace  face              = {.axis = axis, .knots = map->knots};
      MpmGroup box               = {0};

      next[axis]++;
      const PetscInt here = map->mark[pieces[k]], there = MpmMaterialPieceMark(map, next);

      if (!there) continue;
      if (MpmMarkIsSparse(here) || MpmMarkIsSparse(there))
        face.gamma = PetscMax(rules->penalty.ghost, rules->penalty.sparse);
      else if (MpmMaterialPieceIsEdge(map, rules, cell) || MpmMaterialPieceIsEdge(map, rules, next))
        face.gamma = rules->penalty.ghost;
      if (!(face.gamma > 0. || rules->penalty.interior > 0.)) continue;
      if (!(face.knots.order > 1 ? ElementBox : FaceBox)(map->space, rules, cell, &face, &box)) continue;
      face.material[0] = MpmMarkMaterial(here);
      face.material[1] = MpmMarkMaterial(there);
      face.stiffness   = PetscMax(face.gamma, rules->penalty.interior) *
                       PetscMax(materials[face.material[0]].moduli.penalty, materials[face.material[1]].moduli.penalty);
      if (faces) {
        SetMatrices(map->space, grid->h, count, &box, &face);
        faces[count] = face;
        boxes[count] = box;
      }
      count++;
    }
  }
  return count;
}

/* True where points of any material may be sparse. */
static PetscBool AnySparse(const MpmRules *rules)
{
  for (PetscInt m = 0; rules->penalty.sparse > 0. && m < rules->material_count; m++)
    if (MpmShapeSpacing(rules->shape, rules->materials[m].spacing) >= MPM_SPARSE_LEAST) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmGhostFaces(const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmMaterialPieces map;
  MpmGroup         *boxes;
  PetscInt         *pieces, count, numbers;

  PetscFunctionBeginUser;
  if (!(rules->penalty.ghost > 0. || rules->penalty.interior > 0. || AnySparse(rules)))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMaterialPiecesCreate(space, rules, points, &map));
  PetscCall(PetscMalloc1((map.size[0] * map.size[1] * map.size[2]), &pieces));
  count                    = MpmMaterialPiecesOwned(&map, rules->grid, pieces);
  space->boxes.faces.count = ListFaces(&map, rules, count, pieces, NULL, NULL);
  space->boxes.faces.begin = space->boxes.count;
  PetscCall(MpmSpaceAppendBoxes(space, space->boxes.faces.count, &boxes));
  PetscCall(PetscMalloc1(space->boxes.faces.count, &space->boxes.faces.face));
  numbers = (map.knots.order > 1 ? 2 : space->boxes.faces.count) * space->dim * MatrixSize(map.knots);
  PetscCall(PetscMalloc1(numbers, &space->boxes.faces.matrix));
  if (map.knots.order > 1) ElementMatrices(space, map.knots.order, rules->grid->h, space->boxes.faces.matrix);
  (void)ListFaces(&map, rules, count, pieces, space->boxes.faces.face, boxes);
  PetscCall(PetscFree(pieces));
  PetscCall(MpmMaterialPiecesDestroy(&map));
  PetscFunctionReturn(PETSC_SUCCESS);
}
