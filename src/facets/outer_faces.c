/*
  Faces of the points' domains that bound the material.

  The domain of a point is its initial box, of half-lengths l_a, carried by F: the parallelepiped x + F diag(l) xi,
  |xi_a| <= 1. A face bounds the material where a probe a little beyond its middle lies in no domain of the same part.
  Probe and domains are widened, so that the gaps and overlaps of deformed domains neither open nor close the material.

  Every rank treats its own points, with copies of those of other ranks within reach.
*/
#include "base/outcome.h"
#include "grid/grid.h"
#include "facets/outer_faces.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "selection/air_points.h"

#define PROBE 1.2 /* of the way from the centre to a face's middle */
#define WIDE  1.1 /* of a domain that covers a probe */

void MpmOuterFace(PetscInt dim, const PetscReal F[], const PetscReal half[], PetscInt axis, PetscInt side,
                  PetscReal arm[], PetscReal area[])
{
  const PetscReal sign = side ? 1. : -1.;
  const PetscInt  p = (axis + 1) % dim, q = (axis + 2) % dim;

  for (PetscInt a = 0; a < dim; a++) arm[a] = sign * F[a * dim + axis] * half[axis];
  if (dim == 2) { /* the other edge, turned: det F F^-T e_a */
    const PetscReal scale = (axis ? -1. : 1.) * sign * 2. * half[p];

    area[0] = scale * F[2 + p];
    area[1] = -scale * F[p];
    return;
  }
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    area[a] = sign * 4. * half[p] * half[q] * (F[b * 3 + p] * F[c * 3 + q] - F[c * 3 + p] * F[b * 3 + q]);
  }
}

PetscReal MpmOuterNormal(PetscInt dim, const PetscReal F[], const PetscReal N[], PetscReal n[])
{
  const PetscReal half[MPM_MAX_DIM]     = {0.5, 0.5, 0.5};
  PetscReal       cofactor[MPM_MAX_DIM] = {0., 0., 0.}, length = 0.;

  for (PetscInt axis = 0; axis < dim; axis++) {
    PetscReal unused[MPM_MAX_DIM], area[MPM_MAX_DIM];

    MpmOuterFace(dim, F, half, axis, 1, unused, area);
    for (PetscInt a = 0; a < dim; a++) cofactor[a] += N[axis] * area[a];
  }
  for (PetscInt a = 0; a < dim; a++) length += PetscSqr(cofactor[a]);
  length = PetscSqrtReal(length);
  for (PetscInt a = 0; a < dim; a++) n[a] = cofactor[a] / length;
  return MpmDeterminant(dim * dim, F) / length;
}

/* A domain that may cover a probe: its place, its part, and the inverse of F diag(l). */
typedef struct {
  PetscReal x[MPM_MAX_DIM], inverse[MPM_MAX_DIM * MPM_MAX_DIM], part;
} Domain;

/* How far the domain reaches along each axis. */
static void Reach(PetscInt dim, const PetscReal F[], const PetscReal half[], PetscReal reach[])
{
  for (PetscInt a = 0; a < dim; a++) {
    reach[a] = 0.;
    for (PetscInt b = 0; b < dim; b++) reach[a] += PetscAbsReal(F[a * dim + b]) * half[b];
  }
}

static Domain MakeDomain(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt part)
{
  const PetscReal *F = MpmPointF(points, p), *half = &points->domain.half_length[p * dim];
  const PetscReal  J      = MpmDeterminant(dim * dim, F);
  Domain           domain = {.part = (PetscReal)part};

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal unused[MPM_MAX_DIM], area[MPM_MAX_DIM], size = 1.;

    domain.x[a] = points->x[p * dim + a];
    MpmOuterFace(dim, F, half, a, 1, unused, area);
    for (PetscInt b = 0; b < dim; b++) size *= b == a ? 1. : 2. * half[b];
    for (PetscInt b = 0; b < dim; b++) domain.inverse[a * dim + b] = area[b] / (size * J * half[a]);
  }
  return domain;
}

static PetscBool Covers(PetscInt dim, const Domain *domain, const PetscReal z[])
{
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal xi = 0.;

    for (PetscInt b = 0; b < dim; b++) xi += domain->inverse[a * dim + b] * (z[b] - domain->x[b]);
    if (!(PetscAbsReal(xi) <= WIDE)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The domains by cells of their centres, in bins of a hash of the cell. */
typedef struct {
  const MpmGrid *grid;
  PetscInt       count, bins, *start, *order;
  Domain        *domain;
  PetscReal      reach[MPM_MAX_DIM]; /* the longest, over all ranks */
} Bins;

static PetscInt Bin(const Bins *bins, const PetscInt cell[])
{
  PetscInt64 key = 0;

  for (PetscInt a = bins->grid->dim - 1; a >= 0; a--) key = key * bins->grid->cells[a] + cell[a];
  return (PetscInt)(key % bins->bins);
}

static PetscErrorCode FillBins(Bins *bins)
{
  PetscInt *bin, cell[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBeginUser;
  bins->bins = PetscMax(1, bins->count);
  PetscCall(PetscMalloc1(bins->count, &bin));
  PetscCall(PetscCalloc1((bins->bins + 1), &bins->start));
  PetscCall(PetscMalloc1(bins->count, &bins->order));
  for (PetscInt k = 0; k < bins->count; k++) {
    MpmGridFindCell(bins->grid, bins->domain[k].x, cell);
    bin[k] = Bin(bins, cell);
    bins->start[bin[k] + 1]++;
  }
  for (PetscInt b = 0; b < bins->bins; b++) bins->start[b + 1] += bins->start[b];
  for (PetscInt k = bins->count - 1; k >= 0; k--) bins->order[--bins->start[bin[k] + 1]] = k;
  /* start[b + 1] is the begin of bin b now */
  PetscCall(PetscFree(bin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells that may hold the centre of a domain near the box about x, widened on each side by as many cells as `more` is
   long. */
static void CellsAround(const Bins *bins, const PetscReal x[], PetscReal more, PetscInt lower[], PetscInt upper[])
{
  const MpmGrid *grid = bins->grid;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) lower[a] = upper[a] = 0;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal at = (x[a] - grid->lower[a]) / grid->h[a], reach = more * bins->reach[a] / grid->h[a];

    lower[a] = (PetscInt)PetscMax(0., PetscMin(PetscFloorReal(at - reach), (PetscReal)grid->cells[a] - 1.));
    upper[a] = (PetscInt)PetscMax(0., PetscMin(PetscFloorReal(at + reach), (PetscReal)grid->cells[a] - 1.));
  }
}

static PetscBool Covered(const Bins *bins, const PetscReal z[], PetscInt part)
{
  PetscInt lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], cell[MPM_MAX_DIM];

  CellsAround(bins, z, WIDE, lower, upper);
  for (cell[2] = lower[2]; cell[2] <= upper[2]; cell[2]++) {
    for (cell[1] = lower[1]; cell[1] <= upper[1]; cell[1]++) {
      for (cell[0] = lower[0]; cell[0] <= upper[0]; cell[0]++) {
        const PetscInt b = Bin(bins, cell), end = b + 2 <= bins->bins ? bins->start[b + 2] : bins->count;

        for (PetscInt k = bins->start[b + 1]; k < end; k++) {
          const Domain *domain = &bins->domain[bins->order[k]];

          if (domain->part == (PetscReal)part && Covers(bins->grid->dim, domain, z)) return PETSC_TRUE;
        }
      }
    }
  }
  return PETSC_FALSE;
}

/* Copies of the domains that other ranks' probes may meet, to these ranks; theirs stand behind the own ones. */
static PetscErrorCode ShareDomains(Bins *bins)
{
  PetscInt *boxes;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((2 * MPM_MAX_DIM * bins->count), &boxes));
  for (PetscInt k = 0; k < bins->count; k++) {
    PetscInt *box = &boxes[2 * MPM_MAX_DIM * k];

    CellsAround(bins, bins->domain[k].x, PROBE + WIDE, box, box + MPM_MAX_DIM);
  }
  PetscCall(MpmGridShare(bins->grid, sizeof(Domain), boxes, &bins->count, (void **)&bins->domain));
  PetscCall(PetscFree(boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOuterFacesFind(const MpmGrid *grid, const MpmPoints *points, const MpmMaterial *materials,
                                 const PetscInt part[], const PetscInt asked[], PetscInt faces[])
{
  const PetscInt dim  = grid->dim;
  Bins           bins = {.grid = grid, .count = points->count};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(points->count, &bins.domain));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal reach[MPM_MAX_DIM];

    Reach(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], reach);
    for (PetscInt a = 0; a < dim; a++) bins.reach[a] = PetscMax(bins.reach[a], reach[a]);
    bins.domain[p] = MakeDomain(dim, points, p, MpmPointIsAir(materials, points, p) ? -1 : part ? part[p] : 0);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, bins.reach, MPM_MAX_DIM, MPIU_REAL, MPIU_MAX, grid->comm));
  PetscCall(ShareDomains(&bins));
  PetscCall(FillBins(&bins));
  for (PetscInt p = 0; p < points->count; p++) {
    faces[p] = 0;
    if (MpmPointIsAir(materials, points, p)) continue;
    for (PetscInt k = 0; k < 2 * dim; k++) {
      PetscReal arm[MPM_MAX_DIM], area[MPM_MAX_DIM], probe[MPM_MAX_DIM];

      if (asked && !(asked[p] & MpmFaceBit(k / 2, k % 2))) continue;
      MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], k / 2, k % 2, arm, area);
      for (PetscInt a = 0; a < dim; a++) probe[a] = points->x[p * dim + a] + PROBE * arm[a];
      if (grid->axial && probe[0] < 0.) continue; /* on the axis of symmetry */
      if (!Covered(&bins, probe, part ? part[p] : 0)) faces[p] |= MpmFaceBit(k / 2, k % 2);
    }
  }
  PetscCall(PetscFree(bins.domain));
  PetscCall(PetscFree(bins.start));
  PetscCall(PetscFree(bins.order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOuterFacesUpdate(MpmParticles *particles, const MpmMaterials *materials, MpmGrid *grid)
{
  MpmOutcome outcome;
  MpmPoints  points;

  PetscFunctionBeginUser;
  if (!MpmParticlesHaveField(particles, "faces")) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesDistribute(particles, grid, &outcome));
  MpmCheckInput(!outcome.code, "-mpm_bodies: %s", outcome.text);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmOuterFacesFind(grid, &points, materials->at, points.domain.part, NULL, points.domain.faces));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
