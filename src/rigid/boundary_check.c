/*
  Points of a scene that suit a boundary: contact candidates, none of them behind it at the start.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "rigid/rigid.h"
#include "selection/air_points.h"

/* How far a box of these half-lengths reaches along n. */
static PetscReal Reach(PetscInt dim, const PetscReal half[], const PetscReal n[])
{
  PetscReal reach = PETSC_INFINITY;

  for (PetscInt a = 0; a < dim; a++)
    if (n[a] != 0.) reach = PetscMin(reach, half[a] / PetscAbsReal(n[a]));
  return reach;
}

/* Fraction of its reach at which the point stands at the start: 1 for all but nearer ones. Also its distance. */
static PetscReal InitialShare(const MpmBoundary *boundary, const MpmPoints *points, PetscInt p, PetscReal *distance,
                              PetscReal *reach)
{
  const MpmPose still = {.growth = 0.};
  MpmSurface    surface;

  MpmBoundaryDistance(boundary, &still, &points->origin[p * boundary->dim], &surface);
  *distance = surface.distance;
  *reach    = Reach(boundary->dim, &points->domain.half_length[p * boundary->dim], surface.normal);
  return PetscMin(1., PetscMax(0., *distance / *reach));
}

PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmMaterials *materials, const MpmGrid *grid,
                                MpmParticles *particles)
{
  PetscInt  count[3] = {0, 0, 0}; /* contact candidates, behind the boundary, at it */
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscReal distance, reach;

    if (MpmPointIsAir(materials->at, &points, p)) continue;
    if (!MpmRegionContains(boundary->region, &points.origin[p * grid->dim])) continue;
    (void)InitialShare(boundary, &points, p, &distance, &reach);
    count[0]++;
    count[1] += distance < -MPM_TOLERANCE * reach;
    count[2] += distance <= (1. + MPM_TOLERANCE) * reach;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 3, MPIU_INT, MPI_SUM, grid->comm));
  MpmCheckInput(count[0], "-mpm_boundary_%s_points_region: there is no point in it", boundary->name);
  MpmCheckInput(!count[1],
                "-mpm_boundary_%s_type: %" PetscInt_FMT
                " points lie behind it at the start; turn its normal or side, or "
                "choose the contact candidates with its points_region",
                boundary->name, count[1]);
  MpmCheckInput(!boundary->bilateral || count[2],
                "-mpm_boundary_%s_contact bilateral: no point lies at it at the start", boundary->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}
