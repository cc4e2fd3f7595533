/*
  Search for nearby contact. A box around all points answers first; where contact may be near, boxes around a few points
  with outer faces do, so that far contact is cheap.

  No distance from a surface grows faster than the displacement: a surface farther from the middle of a box than half
  its diagonal and the margin is too far from all points in it. The answers thus agree with those of the single points.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "rigid/rigid_motion.h"
#include "facets/contact_search.h"

#define SIDE_BY_SIDE 64   /* points of a box, */
#define TOGETHER     8    /* and boxes that are asked about together first */
#define HALVINGS     5    /* of the box around all points */
#define ROUNDING     1e-9 /* of the lengths that are compared */
#define REACH        3.   /* times half the edges: so far a facet may stand from its point */
#define MOST_LANES   48   /* numbers that are compared side by side */

static MpmFaceBox None(void)
{
  MpmFaceBox box = {.square = 0.};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    box.lower[a] = PETSC_INFINITY;
    box.upper[a] = PETSC_NINFINITY;
  }
  return box;
}

/* Half the edges of a point's domain, their sum, m. */
static PetscReal Edges(PetscInt dim, const MpmPoints *points, PetscInt p)
{
  PetscReal sum = 0.;

  for (PetscInt axis = 0; axis < dim; axis++) {
    PetscReal square = 0.;

    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(MpmPointF(points, p)[a * dim + axis]);
    sum += points->domain.half_length[p * dim + axis] * PetscSqrtReal(square);
  }
  return sum;
}

/* The first of points [begin, end) that has an outer face, or `end`. Few have one. */
static inline PetscInt NextWithFace(const PetscInt faces[], PetscInt begin, PetscInt end)
{
  const PetscInt *f = &faces[begin], *const last = &faces[end];

  if (f < last && *f) return begin;
  while (f + 8 <= last && !(f[0] | f[1] | f[2] | f[3] | f[4] | f[5] | f[6] | f[7])) f += 8;
  while (f < last && !*f) f++;
  return (PetscInt)(f - faces);
}

/* Widens a box to hold point p. */
MPM_INLINE void Include(const PetscInt dim, const MpmPoints *points, PetscInt p, MpmFaceBox *box)
{
  const PetscReal *x = &points->x[p * dim], *F = MpmPointF(points, p), *half = &points->domain.half_length[p * dim];
  PetscReal        longest = half[0], square = PetscSqr(F[0]);

  for (PetscInt k = 1; k < dim * dim; k++) square += PetscSqr(F[k]);
  for (PetscInt a = 1; a < dim; a++) longest = PetscMax(longest, half[a]);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal place = x[a];

    box->lower[a] = PetscMin(box->lower[a], place);
    box->upper[a] = PetscMax(box->upper[a], place);
  }
  box->square = PetscMax(box->square, square * PetscSqr(longest));
}

/* The box of points [begin, end) that have outer faces. */
MPM_INLINE void BoxOf(const PetscInt dim, const MpmPoints *points, PetscInt begin, PetscInt end, MpmFaceBox *box)
{
  MpmFaceBox wide = None(); /* in registers */

  for (PetscInt p = NextWithFace(points->domain.faces, begin, end); p < end;
       p          = NextWithFace(points->domain.faces, p + 1, end))
    Include(dim, points, p, &wide);
  *box = wide;
}

/* Widens a box to hold another. */
static void Unite(PetscInt dim, const MpmFaceBox *other, MpmFaceBox *box)
{
  for (PetscInt a = 0; a < dim; a++) {
    box->lower[a] = PetscMin(box->lower[a], other->lower[a]);
    box->upper[a] = PetscMax(box->upper[a], other->upper[a]);
  }
  box->square = PetscMax(box->square, other->square);
}

typedef enum { VALUE, OPPOSITE, SQUARE } Measure;

MPM_INLINE PetscReal MeasureOf(const Measure measure, PetscReal value)
{
  return measure == SQUARE ? value * value : measure == OPPOSITE ? -value : value;
}

/* Largest measure of each of the components of count rows; rows of `abreast` stand side by side, which vectorises. */
MPM_INLINE void Most(const PetscInt components, const PetscInt abreast, const Measure measure, PetscInt count,
                     const PetscReal value[], PetscReal most[])
{
  PetscReal lane[MOST_LANES];
  PetscInt  row = 0;

  for (PetscInt k = 0; k < components * abreast; k++) lane[k] = PETSC_NINFINITY;
  for (; row + abreast <= count; row += abreast) {
    for (PetscInt k = 0; k < components * abreast; k++) {
      const PetscReal of = MeasureOf(measure, value[row * components + k]);

      lane[k] = of > lane[k] ? of : lane[k];
    }
  }
  for (PetscInt half = components * abreast / 2; half >= components; half /= 2)
    for (PetscInt k = 0; k < half; k++) lane[k] = lane[k + half] > lane[k] ? lane[k + half] : lane[k];
  for (PetscInt k = 0; k < components; k++) most[k] = lane[k];
  for (; row < count; row++)
    for (PetscInt k = 0; k < components; k++)
      most[k] = PetscMax(most[k], MeasureOf(measure, value[row * components + k]));
}

/*
  The box of all points [begin, end), with faces or not: visiting every number costs less than selecting points with
  faces. No F is larger than the largest of each of its entries.
*/
MPM_INLINE void BoxOfAll(const PetscInt dim, const MpmPoints *points, PetscInt begin, PetscInt end, MpmFaceBox *box)
{
  const PetscInt   count = end - begin;
  const PetscReal *x     = &points->x[begin * dim];
  PetscReal        opposite[MPM_MAX_DIM], square[MPM_MAX_DIM * MPM_MAX_DIM + 1], longest;

  Most(dim, 16, VALUE, count, x, box->upper);
  Most(dim, 16, OPPOSITE, count, x, opposite);
  if (points->F_size > dim * dim) Most(dim * dim + 1, 4, SQUARE, count, MpmPointF(points, begin), square);
  else Most(dim * dim, 1 << (5 - dim), SQUARE, count, MpmPointF(points, begin), square);
  Most(1, 32, VALUE, count * dim, &points->domain.half_length[begin * dim], &longest);
  box->square = 0.;
  for (PetscInt a = 0; a < dim; a++) box->lower[a] = -opposite[a];
  for (PetscInt k = 0; k < dim * dim; k++) box->square += square[k] * PetscSqr(longest);
}

/* The end of the points from `begin` on that are of one part: mostly many. */
static PetscInt EndOfPart(const PetscInt part[], PetscInt begin, PetscInt count)
{
  PetscInt end = begin;

  for (PetscInt other = 0; end + SIDE_BY_SIDE <= count && !other;) {
    for (PetscInt k = 0; k < SIDE_BY_SIDE; k++) other |= part[end + k] ^ part[begin];
    if (!other) end += SIDE_BY_SIDE;
  }
  while (end < count && part[end] == part[begin]) end++;
  return end;
}

/* Where parts alternate, as among points that have come from other ranks, they are taken one by one. */
MPM_INLINE void BoxesOfParts(const PetscInt dim, const MpmPoints *points, MpmFaceBox boxes[])
{
  MpmFaceBox box = None();

  for (PetscInt begin = 0, end; begin < points->count; begin = end) {
    MpmFaceBox *whole = &boxes[points->domain.part[begin]];

    end = EndOfPart(points->domain.part, begin, points->count);
    if (end - begin < SIDE_BY_SIDE) {
      for (PetscInt p = begin; p < end; p++) Include(dim, points, p, whole);
    } else {
      BoxOfAll(dim, points, begin, end, &box);
      Unite(dim, &box, whole);
    }
  }
}

/* The functions of a box above, compiled for each dimension. */
typedef void (*Box)(const MpmPoints *points, PetscInt begin, PetscInt end, MpmFaceBox *box);
typedef struct {
  Box of_faces, of_all;
  void (*of_parts)(const MpmPoints *points, MpmFaceBox boxes[]);
} Kernels;

#define KERNELS(dim) \
  static void BoxOf##dim(const MpmPoints *points, PetscInt begin, PetscInt end, MpmFaceBox *box) \
  { \
    BoxOf(dim, points, begin, end, box); \
  } \
  static void BoxOfAll##dim(const MpmPoints *points, PetscInt begin, PetscInt end, MpmFaceBox *box) \
  { \
    BoxOfAll(dim, points, begin, end, box); \
  } \
  static void BoxesOfParts##dim(const MpmPoints *points, MpmFaceBox boxes[]) \
  { \
    BoxesOfParts(dim, points, boxes); \
  }
KERNELS(2)
KERNELS(3)

static const Kernels kernels[] = {[2] = {BoxOf2, BoxOfAll2, BoxesOfParts2}, [3] = {BoxOf3, BoxOfAll3, BoxesOfParts3}};

void MpmFaceBoxesOfParts(PetscInt dim, PetscInt parts, const MpmPoints *points, MpmFaceBox boxes[])
{
  for (PetscInt k = 0; k < parts; k++) boxes[k] = None();
  kernels[dim].of_parts(points, boxes);
}

PetscErrorCode MpmFaceBoxesCreate(MpmFaceBoxes **boxes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(boxes));
  PetscCall(MpmContactSearchRegister(&(*boxes)->search));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFaceBoxesBegin(MpmFacets *facets, const MpmPoints *points)
{
  const PetscInt dim   = facets->boundaries[0].dim;
  PetscBool      any   = PETSC_FALSE;
  MpmFaceBoxes  *boxes = facets->boxes;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < facets->boundary_count; b++) any = (PetscBool)(any || !facets->boundaries[b].bilateral);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  boxes->made = PETSC_FALSE;
  boxes->all  = None();
  if (!points->count) PetscFunctionReturn(PETSC_SUCCESS);
  kernels[dim].of_all(points, 0, points->count, &boxes->all);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The boxes of few points, made on request. */
static PetscErrorCode Make(MpmFaceBoxes *boxes, PetscInt dim, const MpmPoints *points)
{
  const PetscInt count = (points->count + SIDE_BY_SIDE - 1) / SIDE_BY_SIDE;

  PetscFunctionBeginUser;
  if (boxes->made) PetscFunctionReturn(PETSC_SUCCESS);
  if (count > boxes->capacity) {
    PetscCall(PetscFree2(boxes->box, boxes->far));
    PetscCall(PetscMalloc2(count, &boxes->box, count, &boxes->far));
    boxes->capacity = count;
  }
  boxes->count = count;
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt begin = k * SIDE_BY_SIDE, end = PetscMin(points->count, begin + SIDE_BY_SIDE);

    kernels[dim].of_faces(points, begin, end, &boxes->box[k]);
  }
  boxes->made = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFaceBoxesDestroy(MpmFaceBoxes **boxes)
{
  PetscFunctionBeginUser;
  if (*boxes) PetscCall(PetscFree2((*boxes)->box, (*boxes)->far));
  PetscCall(PetscFree(*boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmFacetsMargin(const MpmFacets *facets, const MpmGrid *grid, PetscInt b, const PetscReal x[])
{
  const MpmPose *before = &facets->before[b], *after = &facets->after[b];
  PetscReal      margin = PetscAbsReal(after->growth - before->growth), y[MPM_MAX_DIM];

  MpmPoseCarry(grid->dim, after, before, x, y);
  for (PetscInt a = 0; a < grid->dim; a++) margin += 2. * grid->h[a] + PetscAbsReal(y[a] - x[a]);
  if (MpmFacetsBody(facets, b))
    for (PetscInt k = 0; k < 6; k++) margin += 2. * PetscAbsReal(facets->bodies[b].guess[k]);
  return margin;
}

PetscBool MpmFacetsAreFar(const MpmFacets *facets, PetscInt b, PetscReal margin, const MpmPoints *points, PetscInt p)
{
  const PetscInt dim = facets->boundaries[b].dim;
  MpmSurface     surface;

  MpmFacetsDistance(facets, b, &points->x[p * dim], &surface);
  return (PetscBool)(surface.distance > margin + REACH * Edges(dim, points, p));
}

/* The test for all points in a box. The motion of a surface is largest in a corner. */
static PetscBool BoxIsFar(const MpmFacets *facets, PetscInt b, const MpmGrid *grid, const MpmFaceBox *box)
{
  const PetscInt  dim                 = grid->dim;
  const PetscBool turns               = (PetscBool)(facets->before[b].turned || facets->after[b].turned);
  const PetscInt  corners             = turns ? PetscPowInt(2, dim) : 1;
  PetscReal       middle[MPM_MAX_DIM] = {0., 0., 0.}, square = 0., margin = 0.;
  MpmSurface      surface;

  if (box->lower[0] > box->upper[0]) return PETSC_TRUE;
  for (PetscInt a = 0; a < dim; a++) {
    middle[a] = 0.5 * (box->lower[a] + box->upper[a]);
    square += PetscSqr(box->upper[a] - box->lower[a]);
  }
  for (PetscInt k = 0; k < corners; k++) {
    PetscReal at[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) at[a] = k >> a & 1 ? box->upper[a] : box->lower[a];
    margin = PetscMax(margin, MpmFacetsMargin(facets, grid, b, at));
  }
  MpmFacetsDistance(facets, b, middle, &surface);
  /* sum_a |F e_a| l_a <= sqrt(dim) |F| times the longest l_a */
  margin += 0.5 * PetscSqrtReal(square) + REACH * PetscSqrtReal((PetscReal)dim * box->square);
  return (PetscBool)(surface.distance * (1. - ROUNDING) > margin * (1. + ROUNDING));
}

/* BoxIsFar() by halves of the box, and of these where needed: bodies are mostly longer than they are thick. */
static PetscBool IsFarInHalves(const MpmFacets *facets, PetscInt b, const MpmGrid *grid, const MpmFaceBox *box,
                               PetscInt halvings)
{
  MpmFaceBox half[2] = {*box, *box};
  PetscInt   axis    = 0;

  if (BoxIsFar(facets, b, grid, box)) return PETSC_TRUE;
  if (!halvings) return PETSC_FALSE;
  for (PetscInt a = 1; a < grid->dim; a++)
    if (box->upper[a] - box->lower[a] > box->upper[axis] - box->lower[axis]) axis = a;
  half[0].upper[axis] = half[1].lower[axis] = 0.5 * (box->lower[axis] + box->upper[axis]);
  return (PetscBool)(IsFarInHalves(facets, b, grid, &half[0], halvings - 1) &&
                     IsFarInHalves(facets, b, grid, &half[1], halvings - 1));
}

PetscErrorCode MpmFaceBoxesFind(const MpmFacets *facets, PetscInt b, const MpmGrid *grid, const MpmPoints *points,
                                PetscBool *far)
{
  MpmFaceBoxes *boxes = facets->boxes;

  PetscFunctionBeginUser;
  *far = PETSC_FALSE;
  if (facets->boundaries[b].bilateral) PetscFunctionReturn(PETSC_SUCCESS);
  *far = IsFarInHalves(facets, b, grid, &boxes->all, HALVINGS);
  if (*far) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Make(boxes, grid->dim, points));
  *far = PETSC_TRUE;
  for (PetscInt begin = 0; begin < boxes->count; begin += TOGETHER) {
    const PetscInt end   = PetscMin(boxes->count, begin + TOGETHER);
    MpmFaceBox     whole = None();
    PetscBool      all;

    for (PetscInt k = begin; k < end; k++) Unite(grid->dim, &boxes->box[k], &whole);
    all = BoxIsFar(facets, b, grid, &whole);
    for (PetscInt k = begin; k < end; k++) {
      boxes->far[k] = (PetscBool)(all || BoxIsFar(facets, b, grid, &boxes->box[k]));
      *far          = (PetscBool)(*far && boxes->far[k]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmFaceBoxIsFar(const MpmFacets *facets, PetscInt b, PetscInt p)
{
  return (PetscBool)(!facets->boundaries[b].bilateral && facets->boxes->far[p / SIDE_BY_SIDE]);
}

PetscErrorCode MpmContactSearchRegister(PetscLogEvent *event)
{
  PetscClassId class;

  PetscFunctionBeginUser;
  PetscCall(PetscLogEventGetId("MpmContactSearch", event));
  if (*event >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscClassIdRegister("Talus contact", &class));
  PetscCall(PetscLogEventRegister("MpmContactSearch", class, event));
  PetscFunctionReturn(PETSC_SUCCESS);
}
