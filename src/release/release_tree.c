/*
  Points of a release that stand for equal parts of a weight: of the mass, or of the area of a steep surface.

  The rectangle about the outline is cut in two across its longer side, so that the weights on both sides are as the
  numbers of points there, and so on until each part has one point (Bentley 1975, doi:10.1145/361002.361007). Parts fill
  the outline; a point stands at the centroid of its part, of which those without depth at its sides are taken off.
*/
#include "release/release_impl.h"

#define WHOLE  1e-12 /* part of a rectangle that is rounding */
#define STRIPS 16    /* among which the place of a cut is looked for first */
#define WIDE   8     /* pixels across, from which on it is */
#define STEPS  80    /* of the search, most */
#define CLOSE  1e-14 /* of the weight: error of a cut */

typedef struct {
  MpmRelease       release;
  const MpmMap    *map;    /* of the weight; without pixels it is that of `number` */
  const PetscReal *number; /* by feature; NULL: 1 */
  MpmRings         spare[2];
  PetscInt64       own[2], room; /* [first, end) of this rank's points */
} Tree;

/* A rectangle with its part of the outline. */
typedef struct {
  PetscReal lower[2], upper[2];
  PetscInt  whole; /* feature that fills it, without rings; or -1 */
  MpmRings *rings; /* [feature] */
} Part;

/* The part between two corners within a part: area, moments, and the integral of a weight. */
static PetscErrorCode Integrate(Tree *tree, const Part *part, const PetscReal lower[2], const PetscReal upper[2],
                                const MpmMap *map, const PetscReal number[], MpmPart *sum)
{
  PetscFunctionBeginUser;
  *sum = (MpmPart){.area = 0.};
  if (part->whole < 0) {
    for (PetscInt f = 0; f < tree->release->features; f++)
      PetscCall(MpmPartAdd(&part->rings[f], lower, upper, map, number ? number[f] : 1., tree->spare, sum));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  sum->area = (upper[0] - lower[0]) * (upper[1] - lower[1]);
  for (PetscInt a = 0; a < 2; a++) sum->moment[a] = 0.5 * (lower[a] + upper[a]) * sum->area;
  if (map->value) PetscCall(MpmReleaseRectangle(map, lower, upper, &sum->volume));
  else sum->volume = sum->area * (number ? number[part->whole] : 1.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weight between two places along an axis. */
static PetscErrorCode Weight(Tree *tree, const Part *part, PetscInt axis, PetscReal from, PetscReal to,
                             PetscReal *weight)
{
  PetscReal lower[2], upper[2];
  MpmPart   sum;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < 2; a++) {
    lower[a] = a == axis ? from : part->lower[a];
    upper[a] = a == axis ? to : part->upper[a];
  }
  PetscCall(Integrate(tree, part, lower, upper, tree->map, tree->number, &sum));
  *weight = sum.volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The place along an axis before which a part has a share of its weight (Illinois: Dowell and Jarratt 1971,
   doi:10.1007/BF01934364). */
static PetscErrorCode FindCut(Tree *tree, const Part *part, PetscInt axis, PetscReal share, PetscReal *cut)
{
  const PetscReal start = part->lower[axis], extent = part->upper[axis] - start;
  const PetscInt  strips = tree->map->value && extent > WIDE * tree->map->cell[axis] ? STRIPS : 1;
  PetscReal       all = 0., more = 0., from, ends[2] = {start, start + extent}, off[2], least;
  PetscInt        last = -1;

  PetscFunctionBeginUser;
  PetscCall(Weight(tree, part, axis, ends[0], ends[1], &all));
  off[1] = -share * all;
  for (PetscInt k = 0; k < strips; k++) {
    ends[0] = start + extent * (PetscReal)k / (PetscReal)strips;
    ends[1] = start + extent * (PetscReal)(k + 1) / (PetscReal)strips;
    off[0]  = off[1];
    more    = all;
    if (strips > 1) PetscCall(Weight(tree, part, axis, ends[0], ends[1], &more));
    off[1] += more;
    if (off[1] >= 0.) break;
  }
  from  = ends[0];
  least = off[0];
  *cut  = 0.5 * (ends[0] + ends[1]);
  for (PetscInt k = 0; k < STEPS && off[1] > off[0]; k++) {
    PetscInt side;

    *cut = ends[0] - off[0] * (ends[1] - ends[0]) / (off[1] - off[0]);
    PetscCall(Weight(tree, part, axis, from, *cut, &more));
    more += least;
    if (PetscAbsReal(more) <= CLOSE * all || ends[1] - ends[0] <= CLOSE * extent) break;
    side       = more > 0.;
    ends[side] = *cut;
    off[side]  = more;
    if (side == last) off[1 - side] *= 0.5;
    last = side;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sides without depth are taken off, to a millionth of the part. */
static PetscErrorCode TakeOffDry(Tree *tree, Part *part)
{
  const MpmReleaseDepth *depth = &tree->release->depth;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; depth->map.value && k < 4; k++) {
    const PetscInt  a       = k / 2;
    const PetscReal ends[2] = {part->lower[a], part->upper[a]};
    PetscReal       dry = 0., wet = 1.;

    for (PetscInt n = 0; n < 20; n++) {
      const PetscReal way = n ? 0.5 * (dry + wet) : 1. / STRIPS,
                      at  = ends[k % 2] + way * (ends[1 - k % 2] - ends[k % 2]);
      PetscReal lower[2] = {part->lower[0], part->lower[1]}, upper[2] = {part->upper[0], part->upper[1]};
      MpmPart   sum;

      *(k % 2 ? &lower[a] : &upper[a]) = at;
      PetscCall(Integrate(tree, part, lower, upper, &depth->map, depth->number, &sum));
      if (sum.volume > 0.) wet = way;
      else dry = way;
      if (!n && sum.volume > 0.) break;
    }
    *(k % 2 ? &part->upper[a] : &part->lower[a]) += (k % 2 ? -dry : dry) * (ends[1] - ends[0]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddPoint(Tree *tree, Part *part)
{
  MpmRelease      release = tree->release;
  MpmReleasePoint point;
  MpmPart         sum;
  PetscReal       volume;

  PetscFunctionBeginUser;
  PetscCall(Integrate(tree, part, part->lower, part->upper, &release->depth.map, release->depth.number, &sum));
  volume = sum.volume;
  if (!(volume > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TakeOffDry(tree, part));
  PetscCall(Integrate(tree, part, part->lower, part->upper, &release->depth.map, release->depth.number, &sum));
  point = (MpmReleasePoint){.area = sum.area, .volume = volume};
  for (PetscInt a = 0; a < 2; a++) {
    point.x[a]    = sum.moment[a] / sum.area;
    point.half[a] = 0.5 * PetscMin(part->upper[a] - part->lower[a], release->grid->h[a]);
  }
  if (release->parts.count == tree->room) {
    tree->room = 2 * tree->room + 64;
    PetscCall(PetscRealloc((size_t)tree->room * sizeof(*release->parts.point), &release->parts.point));
  }
  release->parts.point[release->parts.count++] = point;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The side of a part before a cut, or behind it. */
static PetscErrorCode Take(Tree *tree, const Part *from, PetscInt axis, PetscInt side, PetscReal cut, Part *part)
{
  const PetscInt features = tree->release->features;
  PetscReal      lower[2] = {PETSC_INFINITY, PETSC_INFINITY}, upper[2] = {PETSC_NINFINITY, PETSC_NINFINITY};

  PetscFunctionBeginUser;
  *part                                             = *from;
  part->rings                                       = NULL;
  *(side ? &part->lower[axis] : &part->upper[axis]) = cut;
  if (part->whole >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(features, &part->rings));
  for (PetscInt f = 0; f < features; f++) {
    MpmRings *rings = &part->rings[f];
    MpmPart   sum   = {.area = 0.};

    if (!from->rings[f].rings) continue;
    PetscCall(MpmRingsCut(&from->rings[f], axis, part->lower[axis], part->upper[axis], rings));
    if (!rings->rings) continue;
    for (PetscInt v = 0; v < 2 * rings->start[rings->rings]; v++) {
      lower[v % 2] = PetscMin(lower[v % 2], rings->at[v]);
      upper[v % 2] = PetscMax(upper[v % 2], rings->at[v]);
    }
    PetscCall(MpmPartAdd(rings, part->lower, part->upper, &(MpmMap){0}, 1., tree->spare, &sum));
    if (sum.area >= (1. - WHOLE) * (part->upper[0] - part->lower[0]) * (part->upper[1] - part->lower[1]))
      part->whole = f;
  }
  for (PetscInt a = 0; a < 2 && lower[a] < upper[a]; a++) {
    part->lower[a] = PetscMax(part->lower[a], lower[a]);
    part->upper[a] = PetscMin(part->upper[a], upper[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Drop(Tree *tree, Part *part)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; part->rings && f < tree->release->features; f++) PetscCall(MpmRingsDestroy(&part->rings[f]));
  PetscCall(PetscFree(part->rings));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points [first, first + count) of all are those of a part. */
static PetscErrorCode Divide(Tree *tree, Part *part, PetscInt64 first, PetscInt64 count)
{
  const PetscInt64 before = count / 2;
  PetscInt         axis   = part->upper[1] - part->lower[1] > part->upper[0] - part->lower[0];
  PetscReal        cut    = 0.;
  Part             half;

  PetscFunctionBeginUser;
  if (first + count <= tree->own[0] || first >= tree->own[1]) PetscFunctionReturn(PETSC_SUCCESS);
  if (count == 1) {
    PetscCall(AddPoint(tree, part));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FindCut(tree, part, axis, (PetscReal)before / (PetscReal)count, &cut));
  for (PetscInt side = 0; side < 2; side++) {
    PetscCall(Take(tree, part, axis, side, cut, &half));
    PetscCall(Divide(tree, &half, side ? first + before : first, side ? count - before : before));
    PetscCall(Drop(tree, &half));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- weights ---- */

/* Slope of a map at the centre of a pixel, by those beside it. */
static PetscReal Slope(const MpmMap *map, PetscInt i, PetscInt j)
{
  const PetscInt   west = PetscMax(i - 1, 0), east = PetscMin(i + 1, map->columns - 1);
  const PetscInt   south = PetscMax(j - 1, 0), north = PetscMin(j + 1, map->rows - 1);
  const PetscReal *row = &map->value[(PetscInt64)j * map->columns];
  const PetscReal  x   = east > west ? (row[east] - row[west]) / ((PetscReal)(east - west) * map->cell[0]) : 0.;
  const PetscReal  y =
    north > south
       ? (map->value[(PetscInt64)north * map->columns + i] - map->value[(PetscInt64)south * map->columns + i]) /
          ((PetscReal)(north - south) * map->cell[1])
       : 0.;

  return PetscSqrtReal(x * x + y * y);
}

/* True where a map of depths has none in and about a pixel of another map. */
static PetscBool IsDry(const MpmMap *depth, const MpmMap *map, PetscInt i, PetscInt j)
{
  for (PetscInt k = 0; depth->value && k < 9; k++) {
    const PetscReal x[] = {map->x0 + (PetscReal)(i + k % 3 - 1) * map->cell[0],
                           map->y0 + (PetscReal)(j + k / 3 - 1) * map->cell[1]};

    if (MpmMapAt(depth, x) > 0.) return PETSC_FALSE;
  }
  return (PetscBool)(depth->value != NULL);
}

/*
  sqrt(1 + (steep |slope|)^2) on a map's pixels: area of the surface, whose heights are `steep` times as large; 0 where
  there is no depth.
*/
static PetscErrorCode WeighSlopes(const MpmMap *surface, const MpmMap *depth, PetscReal steep, MpmMap *weight)
{
  PetscFunctionBeginUser;
  if (!surface->value) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMapLike(surface, weight));
  PetscCall(PetscMalloc1((size_t)surface->columns * (size_t)surface->rows, &weight->value));
  for (PetscInt j = 0; j < surface->rows; j++) {
    for (PetscInt i = 0; i < surface->columns; i++) {
      const PetscReal slope = steep * Slope(surface, i, j);

      weight->value[(PetscInt64)j * surface->columns + i] = IsDry(depth, surface, i, j) ? 0.
                                                            : PetscIsNanReal(slope)     ? 1.
                                                                                    : PetscSqrtReal(1. + slope * slope);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseDivide(MpmRelease release, const MpmBed *bed, PetscInt64 number, MpmReleaseSpread spread,
                                PetscReal steep)
{
  const PetscMPIInt rank = release->grid->rank, size = release->grid->size;
  MpmMap            weight = {0};
  Tree tree = {.release = release, .map = &weight, .own = {number * rank / size, number * (rank + 1) / size}};
  Part all  = {.whole = -1, .rings = release->rings};

  PetscFunctionBeginUser;
  if (PetscIsNanReal(release->exact)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmReleaseForget(release));
  if (spread == MPM_SPREAD_MASS) {
    tree.map    = &release->depth.map;
    tree.number = release->depth.number;
  } else
    PetscCall(
      WeighSlopes(spread == MPM_SPREAD_BED ? &bed->map : &release->depth.map, &release->depth.map, steep, &weight));
  MpmReleaseBounds(release, all.lower, all.upper);
  PetscCall(Divide(&tree, &all, 0, number));
  PetscCall(MpmMapDestroy(&weight));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MpmRingsDestroy(&tree.spare[k]));
  release->parts.on = PETSC_TRUE;
  PetscCall(MpmReleaseSum(release));
  PetscFunctionReturn(PETSC_SUCCESS);
}
