/*
  The shapes of rigid bodies, read from the options of a block.

    type      plane     point, normal (towards the material)
              box       lower, upper: corners
              sphere    center, radius; a disc in 2D
              cylinder  3D: point, axis (any length, default 0,0,1), radius; endless
              cone      tip, axis (from the tip; default 0,1 or 0,0,1), angle at the tip (default 60 degrees),
                        radius of the endless shaft above; a wedge in 2D
              polygon   2D: vertices x1,y1,x2,y2,... in order round it
              stl       3D: file, scale (m in the file's unit, default 1), origin (of the file; default 0,0,0)
              terrain   3D: the bed of the scene, -mpm_terrain_file or -mpm_bed
    side      of all but a plane and a terrain, on which the material is: outside (default) or inside
*/
#include "options/options.h"
#include "files/stl_file.h"
#include "maps/bed.h"
#include "geometry/geometry.h"
#include "geometry/solid.h"
#include "geometry/solid_types.h"
#include "geometry/triangles.h"

#include <math.h>

const char *const MpmSolidTypes[] = {"plane", "box", "sphere", "cylinder", "cone", "polygon", "stl", "terrain", NULL};

/* True for an option of the type, or of one of two. With -help, all are. */
static PetscBool Has(const MpmSolid *solid, MpmSolidType type, MpmSolidType other)
{
  return (PetscBool)(MpmOptionsHelp() || solid->type == type || solid->type == other);
}

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

static PetscErrorCode ReadBox(const MpmOptions *block, MpmSolid *solid)
{
  PetscReal lower[MPM_MAX_DIM] = {0., 0., 0.}, upper[MPM_MAX_DIM] = {0., 0., 0.};
  char      low[MPM_NUMBER_TEXT], high[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "lower", "m", "lower corner of the box", MPM_RANGE_ANY, MPM_REQUIRED, solid->dim,
                            lower, NULL));
  PetscCall(MpmOptionsReals(block, "upper", "m", "upper corner of the box", MPM_RANGE_ANY, MPM_REQUIRED, solid->dim,
                            upper, NULL));
  for (PetscInt a = 0; a < solid->dim; a++) {
    MpmRealText(lower[a], low);
    MpmRealText(upper[a], high);
    MpmCheckInput(MpmOptionsHelp() || lower[a] < upper[a], "-%supper %s on axis %c: must be > -%slower, which is %s",
                  block->prefix, high, "xyz"[a], block -> prefix, low);
    solid->point[a] = 0.5 * (lower[a] + upper[a]);
    solid->half[a]  = 0.5 * (upper[a] - lower[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadCone(const MpmOptions *block, MpmSolid *solid)
{
  PetscReal angle = 60.;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsReals(block, "tip", "m", "tip of the cone", MPM_RANGE_ANY, MPM_REQUIRED, solid->dim, solid->point, NULL));
  PetscCall(MpmOptionsReal(block, "angle", "degrees", "angle at the cone's tip, from flank to flank",
                           ((MpmRange){0., 180., PETSC_TRUE}), MPM_OPTIONAL, &angle, NULL));
  solid->slope[0] = PetscSinReal(angle * PETSC_PI / 360.);
  solid->slope[1] = PetscCosReal(angle * PETSC_PI / 360.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertices in counterclockwise order, so that the outward normal of an edge (dx, dy) is (dy, -dx). */
static PetscErrorCode ReadPolygon(const MpmOptions *block, MpmSolid *solid)
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
  solid->vertex_count = n;
  solid->vertices     = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 reads the file, every rank holds the surface. */
static PetscErrorCode ReadTriangles(const MpmOptions *block, MpmSolid *solid)
{
  char        message[MPM_STL_MESSAGE] = "", *file;
  PetscReal   scale = 1., origin[MPM_MAX_DIM] = {0., 0., 0.}, *corners = NULL;
  PetscInt    count = 0;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsPath(block, "file", "STL file, binary or ASCII, of a closed surface", MPM_REQUIRED, &file));
  PetscCall(MpmOptionsReal(block, "scale", "m", "length of the STL file's unit", MPM_RANGE_POSITIVE, MPM_OPTIONAL,
                           &scale, NULL));
  PetscCall(MpmOptionsReals(block, "origin", "m", "where the STL file's origin stands", MPM_RANGE_ANY, MPM_OPTIONAL,
                            solid->dim, origin, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(file));
  MpmCheckInput(
    MpmTrianglesSupported(),
    "-%stype stl: this build cannot search triangles; install Embree (Debian: libembree-dev) and build again",
    block->prefix);
  PetscCallMPI(MPI_Comm_rank(block->comm, &rank));
  if (!rank) PetscCall(MpmStlRead(file, &count, &corners, message));
  PetscCallMPI(MPI_Bcast(message, MPM_STL_MESSAGE, MPI_CHAR, 0, block->comm));
  MpmCheckInput(!message[0], "-%sfile %s: %s", block->prefix, file, message);
  PetscCallMPI(MPI_Bcast(&count, 1, MPIU_INT, 0, block->comm));
  if (rank) PetscCall(PetscMalloc1(9 * (size_t)count, &corners));
  PetscCallMPI(MPI_Bcast(corners, (PetscMPIInt)(9 * count), MPIU_REAL, 0, block->comm));
  for (PetscInt k = 0; k < 9 * count; k++) corners[k] = origin[k % 3] + scale * corners[k];
  PetscCall(MpmTrianglesCreate(count, corners, &solid->triangles, message));
  PetscCall(PetscFree(corners));
  MpmCheckInput(!message[0], "-%sfile %s: %s", block->prefix, file, message);
  PetscCall(PetscFree(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckDim(const MpmOptions *block, const MpmSolid *solid)
{
  const PetscBool flat = (PetscBool)(solid->dim == 2 && !MpmOptionsHelp());

  PetscFunctionBeginUser;
  MpmCheckInput(!flat || solid->type != MPM_SOLID_CYLINDER,
                "-%stype cylinder: exists in 3 dimensions only; in 2, a sphere is a disc", block->prefix);
  MpmCheckInput(!flat || solid->type != MPM_SOLID_STL,
                "-%stype stl: exists in 3 dimensions only; in 2, there are polygons", block->prefix);
  MpmCheckInput(!flat || solid->type != MPM_SOLID_TERRAIN, "-%stype terrain: exists in 3 dimensions only",
                block->prefix);
  MpmCheckInput(flat || MpmOptionsHelp() || solid->type != MPM_SOLID_POLYGON,
                "-%stype polygon: exists in 2 dimensions only", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the built-in types and of those that have been registered. */
static PetscErrorCode ReadType(const MpmOptions *block, MpmSolid *solid)
{
  const MpmContactBodyType *added;
  const char              **words;
  PetscInt                  count = 0, type = 0;

  PetscFunctionBeginUser;
  while (MpmContactBodyTypeAt(count)) count++;
  PetscCall(PetscCalloc1((MPM_SOLID_ADDED + count + 1), &words));
  for (PetscInt k = 0; k < MPM_SOLID_ADDED; k++) words[k] = MpmSolidTypes[k];
  for (PetscInt k = 0; k < count; k++) words[MPM_SOLID_ADDED + k] = MpmContactBodyTypeAt(k)->name;
  PetscCall(MpmOptionsWord(block, "type", "its surface", words, MPM_REQUIRED, &type, NULL));
  PetscCall(PetscFree(words));
  solid->type = (MpmSolidType)PetscMin(type, MPM_SOLID_ADDED);
  added       = MpmContactBodyTypeAt(type - MPM_SOLID_ADDED);
  if (solid->type != MPM_SOLID_ADDED) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&solid->added));
  solid->added->type = added;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolidRead(const MpmOptions *block, PetscInt dim, MpmSolid *solid)
{
  static const char *const sides[] = {"outside", "inside", NULL};
  PetscInt                 inside  = 0;

  PetscFunctionBeginUser;
  solid->dim = dim;
  PetscCall(ReadType(block, solid));
  PetscCall(CheckDim(block, solid));
  if (Has(solid, MPM_SOLID_PLANE, MPM_SOLID_CYLINDER))
    PetscCall(MpmOptionsReals(block, "point", "m", "a point of the plane, or of a cylinder's axis", MPM_RANGE_ANY,
                              MPM_REQUIRED, dim, solid->point, NULL));
  if (Has(solid, MPM_SOLID_PLANE, MPM_SOLID_PLANE))
    PetscCall(ReadDirection(block, "normal", "normal of the plane, towards the material, of any length but 0",
                            MPM_REQUIRED, dim, solid->direction));
  if (Has(solid, MPM_SOLID_SPHERE, MPM_SOLID_SPHERE))
    PetscCall(MpmOptionsReals(block, "center", "m", "centre of the sphere (2D: disc)", MPM_RANGE_ANY, MPM_REQUIRED, dim,
                              solid->point, NULL));
  if (Has(solid, MPM_SOLID_SPHERE, MPM_SOLID_CYLINDER) || solid->type == MPM_SOLID_CONE)
    PetscCall(MpmOptionsReal(block, "radius", "m", "radius; of a cone: that of the shaft above it", MPM_RANGE_POSITIVE,
                             MPM_REQUIRED, &solid->radius, NULL));
  if (Has(solid, MPM_SOLID_CYLINDER, MPM_SOLID_CONE)) {
    for (PetscInt a = 0; a < dim; a++) solid->direction[a] = a == dim - 1 ? 1. : 0.;
    PetscCall(ReadDirection(block, "axis",
                            "direction of a cylinder's axis, or of a cone's from its tip; any length but 0",
                            MPM_OPTIONAL, dim, solid->direction));
  }
  if (Has(solid, MPM_SOLID_BOX, MPM_SOLID_BOX)) PetscCall(ReadBox(block, solid));
  if (Has(solid, MPM_SOLID_CONE, MPM_SOLID_CONE)) PetscCall(ReadCone(block, solid));
  if (Has(solid, MPM_SOLID_POLYGON, MPM_SOLID_POLYGON)) PetscCall(ReadPolygon(block, solid));
  if (Has(solid, MPM_SOLID_STL, MPM_SOLID_STL)) PetscCall(ReadTriangles(block, solid));
  if (MpmOptionsHelp() || !Has(solid, MPM_SOLID_PLANE, MPM_SOLID_TERRAIN))
    PetscCall(MpmOptionsWord(block, "side", "where the material is", sides, MPM_OPTIONAL, &inside, NULL));
  solid->side = inside ? -1. : 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolidDestroy(MpmSolid *solid)
{
  PetscFunctionBeginUser;
  if (solid->bed) PetscCall(MpmBedDestroy(solid->bed));
  PetscCall(PetscFree(solid->bed));
  PetscCall(PetscFree(solid->vertices));
  PetscCall(MpmTrianglesDestroy(&solid->triangles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSolidIsRound(const MpmSolid *solid)
{
  return (PetscBool)(solid->type == MPM_SOLID_SPHERE || solid->type == MPM_SOLID_CYLINDER);
}

/* Middle and size of a body from outside the tree. */
static PetscReal AskAdded(const MpmSolid *solid, PetscReal middle[MPM_MAX_DIM])
{
  PetscReal size = 1.;

  if (solid->added->type->middle) solid->added->type->middle(&solid->added->body, middle, &size);
  return size;
}

PetscReal MpmSolidSize(const MpmSolid *solid)
{
  PetscReal  middle[MPM_MAX_DIM], size = 0.;
  MpmSurface surface;

  if (solid->type == MPM_SOLID_BOX) return hypot(hypot(solid->half[0], solid->half[1]), solid->half[2]);
  if (solid->radius > 0.) return solid->radius;
  if (solid->added) return AskAdded(solid, middle);
  MpmSolidMiddle(solid, middle);
  for (PetscInt k = 0; k < solid->vertex_count; k++)
    size = PetscMax(size, hypot(solid->vertices[2 * k] - middle[0], solid->vertices[2 * k + 1] - middle[1]));
  if (solid->type == MPM_SOLID_STL) {
    MpmSolidDistance(solid, 0., middle, &surface);
    size = PetscAbsReal(surface.distance);
  }
  return size > 0. ? size : 1.;
}

void MpmSolidMiddle(const MpmSolid *solid, PetscReal middle[MPM_MAX_DIM])
{
  const PetscInt   n     = solid->vertex_count;
  const PetscReal *v     = solid->vertices;
  PetscReal        twice = 0.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) middle[a] = n ? 0. : solid->point[a];
  if (solid->triangles) MpmTrianglesCentroid(solid->triangles, middle);
  if (solid->added) (void)AskAdded(solid, middle);
  for (PetscInt i = 0; i < n; i++) { /* from the first vertex, so that far from the origin no digits are lost */
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)];
    const PetscReal  area = (p[0] - v[0]) * (q[1] - v[1]) - (q[0] - v[0]) * (p[1] - v[1]);

    twice += area;
    for (PetscInt a = 0; a < 2; a++) middle[a] += area * (p[a] + q[a] - 2. * v[a]) / 3.;
  }
  for (PetscInt a = 0; n && a < 2; a++) middle[a] = v[a] + middle[a] / twice;
}
