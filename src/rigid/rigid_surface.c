/*
  Boundaries that do not follow the grid: surfaces in contact with the material by a penalty (rigid_contact.c). Here
  their options are read, and distances measured.

    type      with its options: geometry/solid.c
    contact   unilateral (default): only pushes; bilateral: also pulls the points that lie at it at the start
    friction  frictionless (default) or stick
    basal     in its place: a law of the bed (basal_friction.c)
    penalty   times Young's modulus over the smallest cell size: pressure by depth
    motion    displacement of the surface in total, times ramp; also rotation about a pivot, or a table (motion.c)
    growth    of a sphere's or cylinder's radius in total, times ramp; material that sticks moves straight away from the
              middle
    points    a region: the points in it at the start are the contact candidates
*/
#include "options/options.h"
#include "maps/bed.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "rigid/added_body.h"
#include "rigid/basal_friction.h"
#include "rigid/rigid.h"
#include "rigid/rigid_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
  MpmCheckInput(MpmOptionsHelp() || MpmRegionGetType(boundary->region) < MPM_REGION_FILE,
                "-%sregion file: only bodies are read from files", prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The motion, and the growth of the radius. */
static PetscErrorCode ReadMotion(const MpmOptions *block, MpmBoundary *boundary)
{
  const PetscBool help = MpmOptionsHelp(), round = MpmSolidIsRound(&boundary->solid);
  MpmMotion      *motion = &boundary->motion;
  PetscReal       least, most;

  PetscFunctionBeginUser;
  MpmSolidMiddle(&boundary->solid, motion->pivot);
  if (help || round)
    PetscCall(MpmOptionsReal(block, "growth", "m", "growth of a sphere's or cylinder's radius in total", MPM_RANGE_ANY,
                             MPM_OPTIONAL, &motion->growth, NULL));
  PetscCall(MpmMotionRead(block, boundary->dim, motion));
  if (help || !round || !motion->ramp) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRampBounds(motion->ramp, &least, &most);
  least = boundary->solid.radius + PetscMin(motion->growth * least, motion->growth * most);
  MpmCheckInput(least > 0., "-%sgrowth %g: the radius falls to %g m; it has to stay positive", block->prefix,
                (double)motion->growth, (double)least);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFrictionRead(const MpmOptions *block, PetscReal *friction, PetscReal *adhesion, PetscBool *stick)
{
  char     *text, *end;
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, "friction", &given));
  PetscCall(MpmOptionsText(block, "friction",
                           "along the surface: frictionless, stick, Coulomb's coefficient, or its angle (20deg)",
                           "frictionless", MPM_OPTIONAL, &text));
  PetscCall(MpmOptionsReal(block, "adhesion", "Pa", "traction along the surface that is carried without pressure",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, adhesion, NULL));
  *stick = (PetscBool)!strcmp(text, "stick");
  MpmCheckInput(MpmOptionsHelp() || !given || *adhesion == 0. || !(*stick || !strcmp(text, "frictionless")),
                "-%sadhesion %g: not with -%sfriction %s; friction 0 is a surface with adhesion alone", block->prefix,
                (double)*adhesion, block->prefix, text);
  if (!*stick && strcmp(text, "frictionless")) {
    *friction             = strtod(text, &end);
    const PetscBool angle = (PetscBool)!strcmp(end, "deg");

    MpmCheckInput(MpmOptionsHelp() ||
                    (end != text && (angle || !*end) && *friction >= 0. && *friction < (angle ? 90. : PETSC_INFINITY)),
                  "-%sfriction %s: must be frictionless, stick, a coefficient >= 0 or an angle in [0deg, 90deg)",
                  block->prefix, text);
    if (angle) *friction = tan(*friction * PETSC_PI / 180.);
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How it holds the material. */
static PetscErrorCode ReadMethod(const MpmOptions *block, MpmBoundary *boundary)
{
  static const char *const methods[] = {"penalty", "augmented", NULL};
  PetscReal                share     = 1e-8;
  PetscInt                 augmented = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "method",
                           "penalty: a depth for a pressure; augmented: pressures are corrected until depths are below "
                           "`penetration`",
                           methods, MPM_OPTIONAL, &augmented, NULL));
  boundary->augmented = (PetscBool)augmented;
  if (!augmented && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsReal(block, "penetration", "of its size", "mean depth in a cell that method augmented leaves",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &share, NULL));
  boundary->bounds.penetration = share * MpmSolidSize(&boundary->solid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bed of a terrain. */
static PetscErrorCode ReadTerrain(const MpmOptions *options, const MpmGrid *grid, MpmSolid *solid)
{
  PetscBool map, plane;

  PetscFunctionBeginUser;
  if (solid->type != MPM_SOLID_TERRAIN || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHas(options, "terrain_file", &map));
  PetscCall(MpmOptionsHas(options, "bed", &plane));
  MpmCheckInput(map || plane, "-mpm_terrain_file is missing: a boundary of type terrain needs it, or -mpm_bed");
  PetscCall(PetscNew(&solid->bed));
  PetscCall(MpmBedRead(options, grid->lower, grid->upper, solid->bed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names of the fields in which points keep something of its contact. */
static PetscErrorCode NameFields(MpmBoundary *boundary, PetscBool tears)
{
  char field[256];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(field, sizeof(field), "pressure_%s", boundary->name));
  if (boundary->augmented || boundary->basal || boundary->fields.face)
    PetscCall(PetscStrallocpy(field, &boundary->fields.pressure));
  PetscCall(PetscSNPrintf(field, sizeof(field), "held_%s", boundary->name));
  if (boundary->bilateral) PetscCall(PetscStrallocpy(field, &boundary->fields.gap));
  PetscCall(PetscSNPrintf(field, sizeof(field), "broken_%s", boundary->name));
  if (tears) PetscCall(PetscStrallocpy(field, &boundary->fields.broken));
  for (PetscInt a = 0; boundary->tangential && a < boundary->dim; a++) {
    PetscCall(PetscSNPrintf(field, sizeof(field), "slip_%s_%c", boundary->name, "xyz"[a]));
    PetscCall(PetscStrallocpy(field, &boundary->fields.slip[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBoundaryKeepRest(MpmBoundary *boundary)
{
  char field[256];

  PetscFunctionBeginUser;
  if (boundary->augmented || boundary->basal || boundary->fields.rest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(field, sizeof(field), "rest_%s", boundary->name));
  PetscCall(PetscStrallocpy(field, &boundary->fields.rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary)
{
  static const char *const contacts[] = {"unilateral", "bilateral", NULL};
  char                     prefix[256];
  MpmOptions               block     = {options->comm, prefix, options->record};
  PetscInt                 bilateral = 0;
  PetscBool                tears;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(boundary, sizeof(*boundary)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_boundary_%s_", name));
  PetscCall(PetscStrallocpy(name, &boundary->name));
  boundary->dim     = grid->dim;
  boundary->penalty = 500.;
  PetscCall(MpmOptionsHeading(&block, "Boundary"));
  PetscCall(MpmSolidRead(&block, grid->dim, &boundary->solid));
  PetscCall(ReadTerrain(options, grid, &boundary->solid));
  PetscCall(MpmAddedBodyRead(&block, boundary->name, &boundary->solid));
  PetscCall(MpmOptionsBool(&block, "drained",
                           "water passes where the material touches it, at the pressure of open water there, or none",
                           &boundary->water.drained, NULL));
  PetscCall(MpmOptionsReal(&block, "pressure", "Pa", "water passes where the material touches it, at this pressure",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &boundary->water.pressure, &boundary->water.led));
  MpmCheckInput(!boundary->water.drained || !boundary->water.led || MpmOptionsHelp(),
                "-%spressure: a boundary is drained or has a pressure, not both", prefix);
  PetscCall(MpmOptionsWord(&block, "contact", "unilateral: pushes only; bilateral: holds the points at it at the start",
                           contacts, MPM_OPTIONAL, &bilateral, NULL));
  PetscCall(MpmFrictionRead(&block, &boundary->friction, &boundary->adhesion, &boundary->stick));
  PetscCall(MpmBasalFrictionRead(options, &block, boundary));
  boundary->tangential =
    (PetscBool)(boundary->stick || boundary->basal || boundary->friction > 0. || boundary->adhesion > 0.);
  boundary->bilateral = (PetscBool)bilateral;
  PetscCall(
    MpmOptionsReal(&block, "tension", "Pa",
                   "pull by area at a step's end with which a bilateral boundary lets go for good; by default it holds",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &boundary->bounds.tension, &tears));
  MpmCheckInput(MpmOptionsHelp() || !tears || bilateral,
                "-%stension: a unilateral boundary carries none; must be with -%scontact bilateral", prefix, prefix);
  PetscCall(MpmOptionsReal(&block, "penalty", "E/h",
                           "pressure by depth, times Young's modulus over the cell size; unless given, 10 on materials "
                           "that flow, whose pressures are small beside it",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &boundary->penalty, &boundary->firm));
  PetscCall(ReadMotion(&block, boundary));
  PetscCall(MpmFreedomRead(&block, boundary, &boundary->freedom));
  PetscCall(ReadMethod(&block, boundary));
  PetscCall(MpmOptionsBool(&block, "face",
                           "the history has the largest pressure on the surface and the height of contact along it",
                           &boundary->fields.face, NULL));
  PetscCall(ReadPoints(options, name, grid, boundary));
  PetscCall(NameFields(boundary, tears));
  if (MpmOptionsHelp()) PetscCall(MpmAddedBodiesPrint(&block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary)
{
  PetscFunctionBeginUser;
  PetscCall(MpmAddedBodyDestroy(&boundary->solid));
  PetscCall(MpmBasalFrictionDestroy(boundary));
  PetscCall(PetscFree(boundary->name));
  PetscCall(PetscFree(boundary->fields.pressure));
  PetscCall(PetscFree(boundary->fields.rest));
  PetscCall(PetscFree(boundary->fields.gap));
  PetscCall(PetscFree(boundary->fields.broken));
  PetscCall(MpmSolidDestroy(&boundary->solid));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(boundary->fields.slip[a]));
  PetscCall(MpmRegionDestroy(&boundary->region));
  PetscCall(MpmMotionDestroy(&boundary->motion));
  PetscCall(MpmFreedomDestroy(&boundary->freedom));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmPose MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time)
{
  return MpmMotionPose(&boundary->motion, time);
}

void MpmBoundaryReference(const MpmBoundary *boundary, const MpmPose *pose, PetscReal x[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) x[a] = boundary->motion.pivot[a] + pose->translation[a];
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

/* Where the place x is on a boundary at rest. */
static void AtRest(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], PetscReal at[])
{
  const MpmPose rest = {.growth = 0.};

  if (pose->turned) MpmPoseCarry(boundary->dim, pose, &rest, x, at);
  for (PetscInt a = 0; !pose->turned && a < boundary->dim; a++) at[a] = x[a] - pose->translation[a];
}

void MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface)
{
  PetscReal at[MPM_MAX_DIM] = {0., 0., 0.};

  AtRest(boundary, pose, x, at);
  MpmSolidDistance(&boundary->solid, pose->growth, at, surface);
  if (pose->turned) TurnSurface(boundary->dim, pose, surface);
}
