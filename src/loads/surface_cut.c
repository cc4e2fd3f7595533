/*
  Faces of bodies whose edge cuts the boxes of their points (`edge: cut`, particles/body_edge.c).

  A point stands for the part of a box and of boxes beside it: at the centroid, with the part's volume V. Faces that
  bound the material are those of the boxes; they stand where the boxes stand, at b from the point's own, with

    w_i(y + b) = w_i(y) + b . grad w_i ,   m = V_box - V

  Work of the faces under a normal stress s in a uniform strain is that of s in the boxes. With s in what is missing
  taken off, s m (surface_load.c), it is that of s in the points: a uniform stress is in balance.

  A point has several faces; the missing part is shared by how far they face it. A traction t acts at the true surface,
  m/A before the box's face of the area A: up to there t balances t n.
*/
#include "grid/grid.h"
#include "facets/outer_faces.h"
#include "particles/body.h"
#include "particles/points.h"
#include "space/point_shape.h"
#include "space/space.h"
#include "loads/body_surface.h"

#define WHOLE 1e-9 /* of a box: a shift of its point that is none */

/* The box of a point that stands for a part of it. */
typedef struct {
  PetscReal back[MPM_MAX_DIM];   /* from the point to the box's middle, m */
  PetscReal missing;             /* volume of the box less that of the point, m^dim or of a full turn */
  PetscReal toward[MPM_MAX_DIM]; /* direction in which that lies, half-lengths, as of the start */
} CutBox;

/* Nothing where the point stands in the middle of its box, or is a part of a divided one. */
static void FindCutBox(const MpmBody body, PetscInt dim, const MpmPoints *points, PetscInt p, CutBox *box)
{
  const double  *F    = MpmPointF(points, p);
  PetscReal      full = 1., start[MPM_MAX_DIM] = {0., 0., 0.}, most = 0., radius = 0.;
  PetscInt       divisions = 0;
  MpmBodyLattice lattice;

  MpmBodyGetLattice(body, &lattice);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal at     = (points->origin[p * dim + a] - lattice.lower[a]) / lattice.spacing[a],
                    middle = lattice.lower[a] + (PetscFloorReal(at) + 0.5) * lattice.spacing[a];

    divisions += MpmPointDivisions(points, p, a);
    full *= 2. * points->domain.half_length[p * dim + a];
    start[a] = (middle - points->origin[p * dim + a]) * MpmPointReference(points, dim, p, a);
    most     = PetscMax(most, PetscAbsReal(middle - points->origin[p * dim + a]) / lattice.spacing[a]);
    if (!a) radius = middle;
  }
  *box = (CutBox){.missing = 0.};
  if (divisions || most < WHOLE) return;
  box->missing = (full * MpmTurn(points->F_size, radius) - points->volume0[p]) * MpmPointJ(points, p);
  for (PetscInt a = 0; a < dim; a++) {
    box->toward[a] = (box->missing > 0. ? 1. : -1.) * start[a] / points->domain.half_length[p * dim + a];
    for (PetscInt b = 0; b < dim; b++) box->back[a] += F[a * dim + b] * start[b];
  }
}

/* The share of a face, 2 axis + side, in what is missing: by how far it faces there, among faces that bound it. */
static PetscReal ShareOfMissing(const CutBox *box, PetscInt dim, PetscInt bounds, PetscInt face)
{
  PetscReal sum = 0., own = 0.;

  for (PetscInt f = 0; f < 2 * dim; f++) {
    const PetscReal part = PetscMax((f % 2 ? 1. : -1.) * box->toward[f / 2], 0.);

    if (!(bounds & MpmFaceBit(f / 2, f % 2))) continue;
    sum += part;
    if (f == face) own = part;
  }
  return sum > 0. ? own / sum : 0.;
}

static void Move(const PetscReal by[], const MpmPoints *points, const MpmSpace *space, const MpmBasis *basis,
                 MpmSurfaceFace *face, PetscReal weight[])
{
  const PetscReal before = MpmTurn(points->F_size, face->place[0]);

  for (PetscInt i = 0; i < space->groups[face->group].node_count; i++)
    weight[i] += MpmBasisSlope(basis, space->dim, i, by);
  for (PetscInt a = 0; a < space->dim; a++) face->place[a] += by[a];
  for (PetscInt a = 0; a < space->dim; a++) {
    face->area[a] *= MpmTurn(points->F_size, face->place[0]) / before;
    face->per_area[a] *= MpmTurn(points->F_size, face->place[0]) / before;
  }
}

static void MoveFace(const CutBox *box, const MpmBodySurface *surface, const MpmPoints *points, const MpmSpace *space,
                     const MpmBasis *basis, MpmSurfaceFace *face, PetscReal weight[])
{
  PetscReal square = 0., by[MPM_MAX_DIM] = {0., 0., 0.};

  Move(box->back, points, space, basis, face, weight);
  face->missing =
    face->part * box->missing * ShareOfMissing(box, space->dim, points->domain.faces[face->point], face->side);
  if (!surface->loaded || surface->normal != 0. || surface->drained) return;
  for (PetscInt a = 0; a < space->dim; a++) square += PetscSqr(face->area[a]);
  for (PetscInt a = 0; a < space->dim && square > 0.; a++) by[a] = -face->missing * face->area[a] / square;
  Move(by, points, space, basis, face, weight);
  face->missing = 0.;
}

PetscErrorCode MpmSurfaceFacesToBoxes(MpmSurfaceFaces *faces, const MpmPoints *points, const MpmSpace *space)
{
  MpmBasis  basis;
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < faces->surfaces->count; k++) any = (PetscBool)(any || faces->surfaces->at[k].cut);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    MpmSurfaceFace       *face    = &faces->list.at[k];
    const MpmBodySurface *surface = &faces->surfaces->at[face->surface];
    CutBox                box;

    if (!surface->cut) continue;
    FindCutBox(surface->cut, space->dim, points, face->point, &box);
    if (box.missing == 0.) continue;
    MpmSpaceEvaluate(space, &space->groups[face->group], face->point, &basis);
    MoveFace(&box, surface, points, space, &basis, face, &faces->list.weight[face->weight]);
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}
