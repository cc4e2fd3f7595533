/*
  Faces of the ghost penalty (ghost_penalty.c has the equations): which faces between pieces get one, and the matrix

    Int_F [d^p N_i/dn^p] [d^p N_j/dn^p] dA

  of each as a Kronecker product over the axes: jumps along the normal, the
  spline's mass matrix of one piece along the face.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "extension/pieces.h"
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

/* Adds `value` to the nodes of the box that stand for a node: itself, or the masters of one at or beyond an edge. */
static void Fold(const MpmFace *face, const MpmGroup *box, PetscInt a, PetscInt node, PetscReal value, PetscReal to[])
{
  const PetscInt inside = face->edge[a] == MPM_EDGE_OPEN ? 1 : 0; /* the first node that stands for itself */
  const PetscInt step   = node < face->lower[a] + inside ? 1 : node > face->upper[a] - inside ? -1 : 0;
  const PetscInt edge   = (step > 0 ? face->lower[a] : face->upper[a]) - box->first[a];

  if (!step) to[node - box->first[a]] += value;
  for (PetscInt k = 0; step && k <= face->degree; k++) {
    const PetscReal coefficient =
      MpmEdgeCoefficient(face->edge[a], face->degree, PetscAbsInt(edge + box->first[a] - node), k);

    if (coefficient != 0.) to[edge + step * k] += coefficient * value;
  }
}

/* The jump over the face at the nodes of its box along the normal; PETSC_FALSE where an edge has removed the knot. */
static PetscBool Jump(const MpmFace *face, const MpmGroup *box, PetscReal jump[])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < box->count[face->axis]; k++) jump[k] = 0.;
  for (PetscInt k = 0; k < face->degree + 2; k++)
    Fold(face, box, face->axis, face->first[face->axis] + k, difference[face->degree - 1][k], jump);
  for (PetscInt k = 0; k < box->count[face->axis]; k++) most = PetscMax(most, PetscAbsReal(jump[k]));
  return (PetscBool)(most > 1e-12); /* differences are about 1 */
}

/* The face's matrix along one axis, count x count, for its Kronecker product. */
static void AxisMatrix(MpmFace *face, const MpmGroup *box, PetscInt a, PetscReal h)
{
  const PetscInt p = face->degree, n = box->count[a];
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

  MpmPieceEdges(space, rules, face->degree, piece, face->lower, face->upper);
  box->node_count  = 1;
  box->point_begin = box->point_end = 0;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscInt last, low, high, reach, from;

    face->first[a] = box->first[a] = 0;
    box->count[a]                  = 1;
    if (a >= grid->dim) continue;
    face->edge[a]  = MpmEdgeOf(rules->edge, face->degree, face->upper[a] - face->lower[a]);
    face->first[a] = piece[a] + MpmPieceFirstNode(face->degree);
    last           = face->first[a] + face->degree + (a == face->axis);
    /* the box must contain the nodes that represent those beyond an edge, and at an open one on it */
    reach = face->edge[a] == MPM_EDGE_OPEN ? face->degree : 1;
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
      MpmFace  face              = {.axis = axis, .degree = map->degree};
      MpmGroup box               = {0};

      next[axis]++;
      const PetscInt here = map->mark[pieces[k]], there = MpmMaterialPieceMark(map, next);

      if (!there) continue;
      if (MpmMarkIsSparse(here) || MpmMarkIsSparse(there))
        face.gamma = PetscMax(rules->penalty.ghost, rules->penalty.sparse);
      else if (MpmMaterialPieceIsEdge(map, rules, cell) || MpmMaterialPieceIsEdge(map, rules, next))
        face.gamma = rules->penalty.ghost;
      if (!(face.gamma > 0. || rules->penalty.interior > 0.) || !FaceBox(map->space, rules, cell, &face, &box))
        continue;
      face.material[0] = MpmMarkMaterial(here);
      face.material[1] = MpmMarkMaterial(there);
      face.stiffness   = PetscMax(face.gamma, rules->penalty.interior) *
                       PetscMax(materials[face.material[0]].moduli.penalty, materials[face.material[1]].moduli.penalty);
      if (faces) {
        for (PetscInt a = 0; a < map->dim; a++) AxisMatrix(&face, &box, a, grid->h[a]);
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
    if (rules->materials[m].spacing >= MPM_SPARSE_LEAST) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmGhostFaces(const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmMaterialPieces map;
  MpmGroup         *boxes;
  PetscInt         *pieces, count;

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
  (void)ListFaces(&map, rules, count, pieces, space->boxes.faces.face, boxes);
  PetscCall(PetscFree(pieces));
  PetscCall(MpmMaterialPiecesDestroy(&map));
  PetscFunctionReturn(PETSC_SUCCESS);
}
