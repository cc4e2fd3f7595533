/*
  Points at the edge of a body whose region cuts their domains (`edge: cut`).

  The lattice's boxes with their middle in the body have a point; others that the region meets give their part to the
  nearest box with a point beside them, measured from the centroid of the part. A point stands at the centroid of what
  its box has of the region and of what it was given: volume and first moments of the body are those of its region.
  Where a layer thins out, boxes have no point beside them: what is more than a hundredth of a box is a point there.

  Domains keep the lattice's size: the faces of the outer ones then add up to the area vectors of the surface. With
  domains as large as the volume the displacement of a thick sphere under inner pressure was 13 % off, on any cells.
*/
#include "geometry/geometry.h"
#include "geometry/region_part.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/body_data.h"

#define LEAST 0.01 /* of a box: the smallest point of its own */
#define WHOLE 1e-9 /* of a box: changes of volume and centroid that are none */

void MpmBodyBoxPlace(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal x[])
{
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscInt m = body->cells.per_cell[a];

    x[a] = grid->lower[a] +
           grid->h[a] * ((PetscReal)(body->cells.lower[a] + at[a] / m) + ((PetscReal)(at[a] % m) + 0.5) / (PetscReal)m);
  }
}

/* Boxes about one, itself included: 3 along each axis. */
static PetscInt BoxesBeside(PetscInt dim)
{
  PetscInt boxes = 1;

  for (PetscInt a = 0; a < dim; a++) boxes *= 3;
  return boxes;
}

/* The k-th box beside one; PETSC_FALSE where it lies outside of the body's lattice. */
static PetscBool Beside(const MpmBody body, PetscInt dim, const PetscInt at[], PetscInt k, PetscInt other[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    other[a] = at[a] + (a < dim ? k % 3 - 1 : 0);
    if (other[a] < 0 || other[a] >= body->lattice.count[a]) return PETSC_FALSE;
    k /= 3;
  }
  return PETSC_TRUE;
}

static PetscBool Owns(const void *set, const PetscReal x[])
{
  return MpmBodyOwns(*(const MpmBody *)set, x);
}

static PetscBool HasPoint(const MpmBody body, const MpmGrid *grid, const PetscInt at[])
{
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};

  MpmBodyBoxPlace(body, grid, at, x);
  return (PetscBool)(MpmBodyOwns(body, x) && !MpmBodyIsTaken(body, grid, x));
}

/* The only body that replaces this one in a box about x of this reach; NULL where there is none, or `many`. */
static MpmBody Replaces(const MpmBody body, const PetscReal x[], PetscReal reach, PetscBool *many)
{
  MpmBody  one   = NULL;
  PetscInt count = 0;

  for (PetscInt b = 0; b < body->beside.winner_count; b++) {
    const MpmBody winner = body->beside.winners[b];

    if (!MpmRegionIsNearEdge(winner->region, x, reach) && !MpmRegionContains(winner->region, x)) continue;
    one = winner;
    count++;
  }
  *many = (PetscBool)(count > 1);
  return count == 1 ? one : NULL;
}

/* The region's part of a box less that in a winner which is a box itself. */
static PetscReal LessBox(const MpmBody body, const MpmBody winner, PetscInt dim, const PetscReal low[],
                         const PetscReal high[], PetscReal centroid[])
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], size = 1., full = 1., x[MPM_MAX_DIM] = {0., 0., 0.}, left, lost;

  for (PetscInt a = 0; a < dim; a++) {
    lower[a] = low[a];
    upper[a] = high[a];
  }
  (void)MpmRegionGetBounds(winner->region, lower, upper);
  for (PetscInt a = 0; a < dim; a++) {
    lower[a] = PetscMax(lower[a], low[a]);
    upper[a] = PetscMax(PetscMin(upper[a], high[a]), lower[a]);
    size *= upper[a] - lower[a];
    full *= high[a] - low[a];
  }
  lost = size > 0. ? MpmRegionPart(body->region, lower, upper, x) : 0.;
  size = MpmRegionPart(body->region, low, high, centroid);
  left = size - lost;
  if (!(left > WHOLE * full)) return 0.;
  for (PetscInt a = 0; a < dim; a++) centroid[a] = (size * centroid[a] - lost * x[a]) / left;
  return left;
}

PetscReal MpmBodyPart(const MpmBody body, PetscInt dim, const PetscReal low[], const PetscReal high[],
                      PetscReal centroid[])
{
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.}, square = 0., full = 1., left;
  PetscBool many;
  MpmBody   winner;

  for (PetscInt a = 0; a < dim; a++) {
    x[a] = 0.5 * (low[a] + high[a]);
    full *= high[a] - low[a];
    square += PetscSqr(0.5 * (high[a] - low[a]));
  }
  winner = Replaces(body, x, PetscSqrtReal(square), &many);
  if (!winner && !many) return MpmRegionPart(body->region, low, high, centroid);
  if (winner && MpmRegionGetType(winner->region) == MPM_REGION_BOX)
    return LessBox(body, winner, dim, low, high, centroid);
  if (many || MpmRegionIsNearEdge(body->region, x, PetscSqrtReal(square)))
    return MpmSampledPart(dim, Owns, &body, low, high, centroid);
  if (!MpmRegionContains(body->region, x)) return 0.;
  left = full - MpmRegionPart(winner->region, low, high, centroid);
  for (PetscInt a = 0; a < dim; a++)
    centroid[a] = left > WHOLE * full ? (full * x[a] - (full - left) * centroid[a]) / left : x[a];
  return left > WHOLE * full ? left : 0.;
}

/* The body's part of a box. */
static PetscReal Part(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal centroid[])
{
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.}, half[MPM_MAX_DIM], low[MPM_MAX_DIM], high[MPM_MAX_DIM];

  MpmBodyBoxPlace(body, grid, at, x);
  MpmBodyHalfLengths(body, grid, half);
  for (PetscInt a = 0; a < grid->dim; a++) {
    low[a]  = x[a] - half[a];
    high[a] = x[a] + half[a];
  }
  return MpmBodyPart(body, grid->dim, low, high, centroid);
}

/* The box beside one without a point that takes its part: the nearest to the centroid; -1 where there is none. */
static PetscInt Taker(const MpmBody body, const MpmGrid *grid, const PetscInt at[], const PetscReal centroid[])
{
  PetscReal least = PETSC_INFINITY;
  PetscInt  taker = -1, other[MPM_MAX_DIM];

  for (PetscInt k = 0; k < BoxesBeside(grid->dim); k++) {
    PetscReal x[MPM_MAX_DIM] = {0., 0., 0.}, square = 0.;

    if (!Beside(body, grid->dim, at, k, other) || !HasPoint(body, grid, other)) continue;
    MpmBodyBoxPlace(body, grid, other, x);
    for (PetscInt a = 0; a < grid->dim; a++) square += PetscSqr((x[a] - centroid[a]) / body->lattice.spacing[a]);
    if (square >= least) continue;
    least = square;
    taker = k;
  }
  return taker;
}

PetscInt MpmBodyBoxes(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscInt boxes[][MPM_MAX_DIM])
{
  const PetscInt last  = BoxesBeside(grid->dim) - 1;
  PetscInt       count = 0;
  PetscReal      part[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) boxes[count][a] = at[a];
  count++;
  for (PetscInt k = 0; k <= last; k++) {
    PetscInt *other = boxes[count];

    if (!Beside(body, grid->dim, at, k, other) || HasPoint(body, grid, other)) continue;
    if (k == last / 2 || !(Part(body, grid, other, part) > 0.)) continue;
    if (Taker(body, grid, other, part) == last - k) count++;
  }
  return count;
}

/* Volume and first moments of a box with a point and of what it takes. */
static PetscReal Gather(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal centroid[])
{
  PetscInt       boxes[MPM_BODY_BOXES][MPM_MAX_DIM];
  const PetscInt count = MpmBodyBoxes(body, grid, at, boxes);
  PetscReal      part[MPM_MAX_DIM], volume = 0., moment[MPM_MAX_DIM] = {0., 0., 0.};

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal given = Part(body, grid, boxes[k], part);

    volume += given;
    for (PetscInt a = 0; a < grid->dim && given > 0.; a++) moment[a] += given * part[a];
  }
  for (PetscInt a = 0; a < grid->dim && volume > 0.; a++) centroid[a] = moment[a] / volume;
  return volume;
}

PetscBool MpmBodyIsLeftOver(const MpmBody body, const MpmGrid *grid, const PetscInt at[], const PetscReal x[])
{
  PetscReal half[MPM_MAX_DIM], full = 1., square = 0., centroid[MPM_MAX_DIM];

  MpmBodyHalfLengths(body, grid, half);
  for (PetscInt a = 0; a < grid->dim; a++) {
    full *= 2. * half[a];
    square += half[a] * half[a];
  }
  if (HasPoint(body, grid, at) || !MpmRegionIsNearEdge(body->region, x, PetscSqrtReal(square))) return PETSC_FALSE;
  return (PetscBool)(Part(body, grid, at, centroid) > LEAST * full && Taker(body, grid, at, centroid) < 0);
}

PetscReal MpmBodyCutBox(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal x[])
{
  const PetscInt dim  = grid->dim;
  PetscReal      full = 1., square = 0., most = 0., volume, half[MPM_MAX_DIM], centroid[MPM_MAX_DIM];
  PetscBool      many;

  MpmBodyHalfLengths(body, grid, half);
  for (PetscInt a = 0; a < dim; a++) {
    full *= 2. * half[a];
    square += PetscSqr(3. * half[a]);
  }
  if (!MpmRegionIsNearEdge(body->region, x, PetscSqrtReal(square)) &&
      !Replaces(body, x, PetscSqrtReal(square), &many) && !many)
    return full;
  volume = Gather(body, grid, at, centroid);
  if (!(volume > 0.)) return full;
  for (PetscInt a = 0; a < dim; a++) most = PetscMax(most, PetscAbsReal(centroid[a] - x[a]) / half[a]);
  if (PetscAbsReal(volume - full) < WHOLE * full && most < WHOLE) return full;
  for (PetscInt a = 0; a < dim; a++) x[a] = centroid[a];
  return volume;
}
