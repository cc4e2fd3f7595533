/*
  Boundaries that do not follow the grid: surfaces that hold the material by a penalty (rigid_contact.c). Here they are read
  and measured.

    type      plane     point, normal (towards the material)
              sphere    center, radius; a disc in 2D
              cylinder  3D: point, axis (any length, default 0,0,1), radius; endless
              polygon   2D: vertices x1,y1,x2,y2,... in order round it
    side      of a sphere, cylinder or polygon on which the material is: outside (default) or inside
    contact   unilateral (default): pushes what would pass it; bilateral: holds the points that lie at it at the start
    friction  frictionless (default) or stick
    penalty   times Young's modulus over the smallest cell size: pressure by depth
    motion    displacement of the surface in total, times ramp; also rotation about a pivot, or a table (motion.c)
    growth    of a sphere's or cylinder's radius in total, times ramp; what sticks to it moves straight away from its middle
    points    a region: the points in it at the start are the contact candidates
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "terms/rigid.h"

#include <math.h>

static const char *const types[] = {"plane", "sphere", "cylinder", "polygon", NULL};

/* A direction of any length but 0, made 1. */
static PetscErrorCode ReadDirection(const MpmOptions *block, const char *name, const char *help, MpmNeed need,
                                    PetscInt dim, PetscReal direction[])
{
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, name, "-", help, MPM_RANGE_ANY, need, dim, direction, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  norm = hypot(hypot(direction[0], direction[1]), direction[2]);
  MpmCheckInput(norm > 0. && norm < PETSC_INFINITY, "-%s%s: the direction has no length", block->prefix, name);
  for (PetscInt a = 0; a < dim; a++) direction[a] /= norm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertices in counterclockwise order, so that the outward normal of an edge (dx, dy) is (dy, -dx). */
static PetscErrorCode ReadPolygon(const MpmOptions *block, MpmBoundary *boundary)
{
  PetscReal area = 0., *v;
  PetscInt  n;

  PetscFunctionBeginUser;
  PetscCall(MpmPolygonRead(block, &n, &v));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt j = (i + 1) % n;

    area += v[2 * i] * v[2 * j + 1] - v[2 * j] * v[2 * i + 1];
  }
  for (PetscInt i = 0; area < 0. && i < n / 2; i++) {
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal other = v[2 * i + a];

      v[2 * i + a]           = v[2 * (n - 1 - i) + a];
      v[2 * (n - 1 - i) + a] = other;
    }
  }
  boundary->vertex_count = n;
  boundary->vertices     = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadGeometry(const MpmOptions *block, MpmBoundary *boundary)
{
  static const char *const sides[] = {"outside", "inside", NULL};
  const PetscInt           dim     = boundary->dim;
  const PetscBool          help    = MpmOptionsHelp();
  PetscInt                 inside  = 0;

  PetscFunctionBeginUser;
  MpmCheckInput(help || dim == 3 || boundary->type != MPM_BOUNDARY_CYLINDER,
                "-%stype cylinder: exists in 3 dimensions only; in 2, a sphere is a disc", block->prefix);
  MpmCheckInput(help || dim == 2 || boundary->type != MPM_BOUNDARY_POLYGON,
                "-%stype polygon: exists in 2 dimensions only", block->prefix);
  if (help || boundary->type == MPM_BOUNDARY_PLANE || boundary->type == MPM_BOUNDARY_CYLINDER)
    PetscCall(MpmOptionsReals(block, "point", "m", "a point of the plane, or of a cylinder's axis", MPM_RANGE_ANY,
                              MPM_REQUIRED, dim, boundary->point, NULL));
  if (help || boundary->type == MPM_BOUNDARY_PLANE)
    PetscCall(ReadDirection(block, "normal", "normal of the plane, towards the material, of any length but 0",
                            MPM_REQUIRED, dim, boundary->direction));
  if (help || boundary->type == MPM_BOUNDARY_SPHERE)
    PetscCall(MpmOptionsReals(block, "center", "m", "centre of the sphere (2D: disc)", MPM_RANGE_ANY, MPM_REQUIRED, dim,
                              boundary->point, NULL));
  if (help || boundary->type == MPM_BOUNDARY_SPHERE || boundary->type == MPM_BOUNDARY_CYLINDER)
    PetscCall(
      MpmOptionsReal(block, "radius", "m", "radius", MPM_RANGE_POSITIVE, MPM_REQUIRED, &boundary->radius, NULL));
  if (help || boundary->type == MPM_BOUNDARY_CYLINDER) {
    boundary->direction[2] = help ? 0. : 1.;
    PetscCall(ReadDirection(block, "axis", "direction of a cylinder's axis, of any length but 0", MPM_OPTIONAL, dim,
                            boundary->direction));
  }
  if (help || boundary->type == MPM_BOUNDARY_POLYGON) PetscCall(ReadPolygon(block, boundary));
  if (help || boundary->type != MPM_BOUNDARY_PLANE)
    PetscCall(MpmOptionsWord(block, "side", "where the material is", sides, MPM_OPTIONAL, &inside, NULL));
  boundary->side = inside ? -1. : 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* About which it turns by default: its point or centre, or a polygon's centroid. */
static void Middle(const MpmBoundary *boundary, PetscReal middle[])
{
  const PetscInt   n     = boundary->vertex_count;
  const PetscReal *v     = boundary->vertices;
  PetscReal        twice = 0.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) middle[a] = n ? 0. : boundary->point[a];
  for (PetscInt i = 0; i < n; i++) { /* from the first vertex, so that far from the origin no digits are lost */
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)];
    const PetscReal  area = (p[0] - v[0]) * (q[1] - v[1]) - (q[0] - v[0]) * (p[1] - v[1]);

    twice += area;
    for (PetscInt a = 0; a < 2; a++) middle[a] += area * (p[a] + q[a] - 2. * v[a]) / 3.;
  }
  for (PetscInt a = 0; n && a < 2; a++) middle[a] = v[a] + middle[a] / twice;
}

/* Which points are contact candidates. */
static PetscErrorCode ReadPoints(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary)
{
  char       prefix[256];
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_boundary_%s_points_", name));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &boundary->region));
  MpmCheckInput(MpmOptionsHelp() || MpmRegionGetType(boundary->region) != MPM_REGION_FILE,
                "-%sregion file: only bodies are read from files", prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The motion, and what it makes of the radius. */
static PetscErrorCode ReadMotion(const MpmOptions *block, MpmBoundary *boundary)
{
  const PetscBool help  = MpmOptionsHelp();
  const PetscBool round = (PetscBool)(boundary->type == MPM_BOUNDARY_SPHERE || boundary->type == MPM_BOUNDARY_CYLINDER);
  MpmMotion      *motion = &boundary->motion;
  PetscReal       least, most;

  PetscFunctionBeginUser;
  Middle(boundary, motion->pivot);
  if (help || round)
    PetscCall(MpmOptionsReal(block, "growth", "m", "growth of a sphere's or cylinder's radius in total", MPM_RANGE_ANY,
                             MPM_OPTIONAL, &motion->growth, NULL));
  PetscCall(MpmMotionRead(block, boundary->dim, motion));
  if (help || !round || !motion->ramp) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRampBounds(motion->ramp, &least, &most);
  least = boundary->radius + PetscMin(motion->growth * least, motion->growth * most);
  MpmCheckInput(least > 0., "-%sgrowth %g: the radius falls to %g m; it has to stay positive", block->prefix,
                (double)motion->growth, (double)least);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* frictionless, stick, Coulomb's coefficient, or an angle; and adhesion. */
static PetscErrorCode ReadFriction(const MpmOptions *block, MpmBoundary *boundary)
{
  char *text, *end;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "friction",
                           "along the surface: frictionless, stick, Coulomb's coefficient, or its angle (20deg)",
                           "frictionless", MPM_OPTIONAL, &text));
  PetscCall(MpmOptionsReal(block, "adhesion", "Pa", "traction along the surface that is carried without pressure",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &boundary->adhesion, NULL));
  boundary->stick = (PetscBool)!strcmp(text, "stick");
  if (!boundary->stick && strcmp(text, "frictionless")) {
    boundary->friction    = strtod(text, &end);
    const PetscBool angle = (PetscBool)!strcmp(end, "deg");

    MpmCheckInput(MpmOptionsHelp() || (end != text && (angle || !*end) && boundary->friction >= 0. &&
                                       boundary->friction < (angle ? 90. : PETSC_INFINITY)),
                  "-%sfriction %s: must be frictionless, stick, a coefficient >= 0 or an angle in [0deg, 90deg)",
                  block->prefix, text);
    if (angle) boundary->friction = tan(boundary->friction * PETSC_PI / 180.);
  }
  boundary->tangential = (PetscBool)(boundary->stick || boundary->friction > 0. || boundary->adhesion > 0.);
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary)
{
  static const char *const contacts[] = {"unilateral", "bilateral", NULL};
  char                     prefix[256], field[256];
  MpmOptions               block = {options->comm, prefix, options->record};
  PetscInt                 type = 0, bilateral = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(boundary, sizeof(*boundary)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_boundary_%s_", name));
  PetscCall(PetscStrallocpy(name, &boundary->name));
  boundary->dim     = grid->dim;
  boundary->penalty = 20.;
  PetscCall(MpmOptionsHeading(&block, "Boundary"));
  PetscCall(MpmOptionsWord(&block, "type", "its surface", types, MPM_REQUIRED, &type, NULL));
  boundary->type = (MpmBoundaryType)type;
  PetscCall(ReadGeometry(&block, boundary));
  PetscCall(MpmOptionsWord(&block, "contact", "unilateral: pushes only; bilateral: holds the points at it at the start",
                           contacts, MPM_OPTIONAL, &bilateral, NULL));
  PetscCall(ReadFriction(&block, boundary));
  boundary->bilateral = (PetscBool)bilateral;
  PetscCall(MpmOptionsReal(&block, "penalty", "E/h", "pressure by depth, times Young's modulus over the cell size",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &boundary->penalty, NULL));
  PetscCall(ReadMotion(&block, boundary));
  PetscCall(ReadPoints(options, name, grid, boundary));
  for (PetscInt a = 0; boundary->tangential && a < grid->dim; a++) {
    PetscCall(PetscSNPrintf(field, sizeof(field), "slip_%s_%c", name, "xyz"[a]));
    PetscCall(PetscStrallocpy(field, &boundary->slip_field[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(boundary->name));
  PetscCall(PetscFree(boundary->vertices));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(boundary->slip_field[a]));
  PetscCall(MpmRegionDestroy(&boundary->region));
  PetscCall(MpmMotionDestroy(&boundary->motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBoundaryPlace(const MpmBoundary *boundary, PetscReal x[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) x[a] = boundary->point[a];
  for (PetscInt k = 0; k < 2 * boundary->vertex_count; k++)
    x[k % 2] += boundary->vertices[k] / (PetscReal)boundary->vertex_count;
}

MpmPose MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time)
{
  return MpmMotionPose(&boundary->motion, time);
}

/* ---- distance ---- */

/*
  Distance from a centre line or point, r being the vector from it: positive outside the radius; the second derivative is
  (I - n n^T - a a^T)/|r|, a the direction of a line.
*/
static void RoundDistance(PetscInt dim, const PetscReal r[], PetscReal radius, const PetscReal *along,
                          MpmSurface *surface)
{
  PetscReal length = 0.;

  for (PetscInt a = 0; a < dim; a++) length += r[a] * r[a];
  length            = PetscSqrtReal(length);
  surface->distance = length - radius;
  if (length == 0.) { /* the centre is as far from every side */
    surface->normal[0] = 1.;
    return;
  }
  for (PetscInt a = 0; a < dim; a++) surface->normal[a] = r[a] / length;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      PetscReal projection = (a == b ? 1. : 0.) - surface->normal[a] * surface->normal[b];

      if (along) projection -= along[a] * along[b];
      surface->second[a][b] = projection / length;
    }
  }
}

/* Is the place inside the polygon? Edges cross the ray from it along +x. */
static PetscBool InPolygon(PetscInt n, const PetscReal v[], const PetscReal x[])
{
  PetscBool inside = PETSC_FALSE;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)];

    if ((p[1] > x[1]) != (q[1] > x[1]) && x[0] < p[0] + (q[0] - p[0]) * (x[1] - p[1]) / (q[1] - p[1])) inside = !inside;
  }
  return inside;
}

/* The nearest edge counts; beyond its ends, the vertex, which is round. */
static void PolygonDistance(const MpmBoundary *boundary, const PetscReal x[], MpmSurface *surface)
{
  const PetscInt   n = boundary->vertex_count;
  const PetscReal *v = boundary->vertices, *nearest = NULL;
  PetscReal        best = PETSC_INFINITY;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)], dx = q[0] - p[0], dy = q[1] - p[1];
    const PetscReal  length = hypot(dx, dy), along = ((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / length;
    const PetscReal  across = ((x[0] - p[0]) * dy - (x[1] - p[1]) * dx) / length,
                    corner  = hypot(x[0] - p[0], x[1] - p[1]);

    if (corner < best) {
      best    = corner;
      nearest = p;
    }
    if (along > 0. && along < length && PetscAbsReal(across) <= best) {
      best               = PetscAbsReal(across);
      nearest            = NULL;
      surface->distance  = across;
      surface->normal[0] = dy / length;
      surface->normal[1] = -dx / length;
    }
  }
  if (nearest) {
    const PetscReal r[MPM_MAX_DIM] = {x[0] - nearest[0], x[1] - nearest[1], 0.};

    RoundDistance(2, r, 0., NULL, surface);
    if (!InPolygon(n, v, x)) return;
    surface->distance = -surface->distance;
    for (PetscInt a = 0; a < 2; a++) {
      surface->normal[a] = -surface->normal[a];
      for (PetscInt b = 0; b < 2; b++) surface->second[a][b] = -surface->second[a][b];
    }
  }
}

/* At a place of the boundary at rest. */
static void DistanceAtRest(const MpmBoundary *boundary, PetscReal growth, const PetscReal at[], MpmSurface *surface)
{
  const PetscInt dim            = boundary->dim;
  PetscReal      r[MPM_MAX_DIM] = {0., 0., 0.}, along = 0.;

  for (PetscInt a = 0; a < dim; a++) {
    r[a] = at[a] - boundary->point[a];
    along += r[a] * boundary->direction[a];
  }
  switch (boundary->type) {
  case MPM_BOUNDARY_PLANE:
    surface->distance = along;
    for (PetscInt a = 0; a < dim; a++) surface->normal[a] = boundary->direction[a];
    break;
  case MPM_BOUNDARY_SPHERE:
    RoundDistance(dim, r, boundary->radius + growth, NULL, surface);
    break;
  case MPM_BOUNDARY_CYLINDER:
    for (PetscInt a = 0; a < dim; a++) r[a] -= along * boundary->direction[a];
    RoundDistance(dim, r, boundary->radius + growth, boundary->direction, surface);
    break;
  case MPM_BOUNDARY_POLYGON:
    PolygonDistance(boundary, at, surface);
    break;
  }
  if (boundary->side > 0.) return;
  surface->distance = -surface->distance;
  for (PetscInt a = 0; a < dim; a++) {
    surface->normal[a] = -surface->normal[a];
    for (PetscInt b = 0; b < dim; b++) surface->second[a][b] = -surface->second[a][b];
  }
}

/* n becomes R n, the second derivative R S R^T. */
static void TurnSurface(PetscInt dim, const MpmPose *pose, MpmSurface *surface)
{
  const MpmPose rest = {.growth = 0.};
  PetscReal     half[MPM_MAX_DIM][MPM_MAX_DIM]; /* S R^T, by columns */

  MpmPoseTurn(dim, &rest, pose, surface->normal, surface->normal);
  for (PetscInt a = 0; a < dim; a++) MpmPoseTurn(dim, &rest, pose, surface->second[a], half[a]);
  for (PetscInt b = 0; b < dim; b++) {
    PetscReal column[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) column[a] = half[a][b];
    MpmPoseTurn(dim, &rest, pose, column, column);
    for (PetscInt a = 0; a < dim; a++) surface->second[a][b] = column[a];
  }
}

void MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface)
{
  const MpmPose rest            = {.growth = 0.};
  PetscReal     at[MPM_MAX_DIM] = {0., 0., 0.};

  *surface = (MpmSurface){0};
  if (pose->turned) MpmPoseCarry(boundary->dim, pose, &rest, x, at);
  for (PetscInt a = 0; !pose->turned && a < boundary->dim; a++) at[a] = x[a] - pose->translation[a];
  DistanceAtRest(boundary, pose->growth, at, surface);
  if (pose->turned) TurnSurface(boundary->dim, pose, surface);
}
