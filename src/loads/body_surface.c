/*
  Surfaces of bodies: their blocks.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "rigid/rigid.h"
#include "loads/body_surface.h"

static const char *const sides[] = {"-x", "+x", "-y", "+y", "-z", "+z", "all", NULL};

static PetscErrorCode ReadBody(const MpmOptions *block, const MpmBodies *bodies, PetscInt *body)
{
  char *name;

  PetscFunctionBeginUser;
  *body = 0;
  PetscCall(MpmOptionsText(block, "body", "the body whose surface it is", NULL, MPM_REQUIRED, &name));
  if (!MpmOptionsHelp()) {
    while (*body < bodies->count && strcmp(bodies->names[*body], name)) (*body)++;
    MpmCheckInput(*body < bodies->count, "-%sbody %s: must be in -mpm_bodies", block->prefix, name);
  }
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bits of the faces on a side of the lattice. */
static PetscErrorCode ReadSide(const MpmOptions *block, PetscInt dim, PetscInt *faces)
{
  const PetscInt all  = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(sides) - 2;
  PetscInt       side = all;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsWord(block, "side",
                   "faces of the points' domains that bound the material and look, in the initial lattice, this "
                   "way; all: all that bound it",
                   sides, MPM_REQUIRED, &side, NULL));
  MpmCheckInput(side == all || side < 2 * dim || MpmOptionsHelp(),
                "-%sside %s: must be one of -x, +x, -y, +y, all in two dimensions", block->prefix, sides[side]);
  *faces = side == all ? (1 << (2 * dim)) - 1 : MpmFaceBit(side / 2, side % 2);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions for water. */
static PetscErrorCode ReadWater(const MpmOptions *block, const MpmLayout *layout, MpmBodySurface *surface,
                                PetscBool *any)
{
  PetscBool drained = PETSC_FALSE, said, pressure;

  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  PetscCall(MpmOptionsBool(block, "drained",
                           "water passes, at the pressure of open water there, or none; other faces are sealed",
                           &drained, &said));
  PetscCall(MpmOptionsReal(block, "pressure", "Pa", "water passes, at this pressure, times the ramp where one is given",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &surface->pressure, &pressure));
  PetscCall(MpmOptionsHas(block, "ramp", &surface->ramped));
  *any             = (PetscBool)(said || pressure);
  surface->held    = (PetscBool)(drained || pressure);
  surface->drained = drained;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!*any || MpmPressureComponent(layout) >= 0, "-%s%s: there is no water in the scene's physics",
                block->prefix, said ? "drained" : "pressure");
  MpmCheckInput(!drained || !pressure, "-%spressure: a surface is drained or has a pressure, not both", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodySurfaceCreate(const MpmOptions *options, const char *name, const MpmLayout *layout,
                                    const PetscReal tolerance[], const MpmBodies *bodies, MpmBodySurface *surface)
{
  char       prefix[256];
  MpmOptions block = {options->comm, prefix, options->record};
  PetscBool  traction, normal, water = PETSC_FALSE, has_region;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_surface_%s_", name));
  PetscCall(PetscStrallocpy(name, &surface->name));
  PetscCall(MpmOptionsHeading(&block, "Surface of a body"));
  surface->boundary = -1;
  PetscCall(ReadBody(&block, bodies, &surface->body));
  PetscCall(ReadSide(&block, layout->dim, &surface->faces));
  PetscCall(MpmOptionsHas(&block, "region", &has_region));
  if (has_region || MpmOptionsHelp()) PetscCall(MpmRegionCreate(&block, layout->dim, tolerance, &surface->region));
  PetscCall(MpmOptionsReals(&block, "traction", "Pa", "force by area of the faces as they stand at a step's end",
                            MPM_RANGE_ANY, MPM_OPTIONAL, layout->dim, surface->traction, &traction));
  PetscCall(MpmOptionsReal(&block, "normal", "Pa",
                           "stress along the faces' outward normal, which it follows; a pressure is negative",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &surface->normal, &normal));
  PetscCall(ReadWater(&block, layout, surface, &water));
  PetscCall(MpmRampCreate(&block, "ramp", "0:0,1:1", &surface->ramp));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!traction || !normal, "-%snormal: a surface has a traction or a normal stress, not both", prefix);
  MpmCheckInput(
    traction || normal || water,
    "-%straction is missing: nothing acts on the surface; it must have a traction or a normal stress, or be "
    "drained or have a pressure",
    prefix);
  surface->loaded = (PetscBool)(traction || normal);
  surface->cut    = MpmBodyIsCut(bodies->at[surface->body]) ? bodies : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodySurfacesAddDrained(const MpmBoundaries *boundaries, MpmBodySurfaces *surfaces)
{
  PetscInt more = 0;

  PetscFunctionBeginUser;
  surfaces->named = surfaces->count;
  for (PetscInt b = 0; b < boundaries->count; b++)
    more += boundaries->at[b].water.drained || boundaries->at[b].water.led;
  PetscCall(PetscCalloc1((surfaces->count + more), &surfaces->at));
  if (more) PetscCall(PetscRealloc(sizeof(*surfaces->names) * (size_t)(surfaces->count + more), &surfaces->names));
  for (PetscInt b = 0; b < boundaries->count; b++) {
    MpmBodySurface *surface = &surfaces->at[surfaces->count];

    if (!boundaries->at[b].water.drained && !boundaries->at[b].water.led) continue;
    for (PetscInt k = 0; k < surfaces->named; k++)
      MpmCheckInput(strcmp(surfaces->names[k], boundaries->names[b]),
                    "-mpm_surfaces %s: there is a drained boundary of this name", surfaces->names[k]);
    *surface = (MpmBodySurface){.body     = -1,
                                .boundary = b,
                                .faces    = ~0,
                                .held     = PETSC_TRUE,
                                .drained  = boundaries->at[b].water.drained,
                                .pressure = boundaries->at[b].water.pressure};
    PetscCall(PetscStrallocpy(boundaries->names[b], &surface->name));
    PetscCall(PetscStrallocpy(boundaries->names[b], &surfaces->names[surfaces->count++]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSurfacesOpen(const MpmBodySurfaces *surfaces)
{
  for (PetscInt k = 0; k < surfaces->count; k++)
    if (surfaces->at[k].drained) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmBodySurfacesDestroy(MpmBodySurfaces *surfaces)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; surfaces->at && k < surfaces->count; k++) {
    PetscCall(PetscFree(surfaces->at[k].name));
    PetscCall(MpmRampDestroy(&surfaces->at[k].ramp));
    PetscCall(MpmRegionDestroy(&surfaces->at[k].region));
  }
  PetscCall(MpmNamesDestroy(surfaces->count, &surfaces->names));
  PetscCall(PetscFree(surfaces->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}
