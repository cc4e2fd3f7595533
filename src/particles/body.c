/*
  Bodies: where the points come from (body_points.c). Points stand on a regular sub-lattice of every cell; a cell that
  the body's edge cuts keeps the points inside.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "voxels/row_labels.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/body_data.h"
#include "particles/body_file.h"
#include "particles/body_initial.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"

/* The cells that the region meets; a bounded region must lie inside the grid. */
static PetscErrorCode FindCells(const MpmOptions *block, const MpmGrid *grid, MpmBody body)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = PETSC_NINFINITY;
    upper[a] = PETSC_INFINITY;
  }
  PetscCall(MpmRegionGetBounds(body->region, lower, upper));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscReal tolerance = 3. * MPM_TOLERANCE * grid->h[a]; /* the bounds come with the region's own */

    body->cells.lower[a] = 0;
    body->cells.upper[a] = 1;
    if (a >= grid->dim) continue;
    MpmCheckInput((MpmRegionGetType(body->region) == MPM_REGION_RASTER && a < 2) || lower[a] <= PETSC_NINFINITY ||
                    upper[a] >= PETSC_INFINITY ||
                    (lower[a] >= grid->lower[a] - tolerance && upper[a] <= grid->upper[a] + tolerance),
                  "-%sregion: the body spans [%g, %g] on axis %c, outside the grid, [%g, %g]; -%sclip_lower and "
                  "-%sclip_upper cut it",
                  block->prefix, (double)lower[a], (double)upper[a], "xyz"[a], (double)(grid->lower[a]),
                  (double)(grid->upper[a]), block -> prefix, block -> prefix);
    lower[a] = PetscMax(lower[a], grid->lower[a]);
    upper[a] = PetscMin(upper[a], grid->upper[a]);
    body->cells.lower[a] =
      PetscMax((PetscInt)PetscFloorReal((lower[a] - grid->lower[a]) / grid->h[a] - MPM_TOLERANCE), 0);
    body->cells.upper[a] =
      PetscMin((PetscInt)PetscCeilReal((upper[a] - grid->lower[a]) / grid->h[a] + MPM_TOLERANCE), grid->cells[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One number, alike in all directions, or all components; in 2D also six, of which two are 0. */
static PetscErrorCode ReadStress(const MpmOptions *block, PetscInt dim, MpmBody body)
{
  const PetscInt size = MpmSymSize(dim);
  PetscInt       count;
  PetscReal     *given;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsRealList(block, "initial_stress", "Pa",
                       "Cauchy's, with which its points start: xx, yy, zz, xy, in 3D yz, xz; or one number, alike "
                       "in all directions",
                       MPM_OPTIONAL, &count, &given));
  MpmCheckInput(!count || count == 1 || count == size || (count == 6 && given[4] == 0. && given[5] == 0.),
                "-%sinitial_stress has %" PetscInt_FMT " numbers: must be 1 or %" PetscInt_FMT, block->prefix, count,
                size);
  if (count) PetscCall(PetscCalloc1(6, &body->start.stress));
  for (PetscInt c = 0; count && c < size; c++) body->start.stress[c] = count > 1 ? given[c] : c < 3 ? given[0] : 0.;
  PetscCall(PetscFree(given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The layer above, whose lower end is the top of this one. */
static PetscErrorCode ReadBelow(const MpmOptions *block, const MpmBodies *bodies, PetscInt b)
{
  const MpmBody body  = bodies->at[b];
  PetscInt      above = -1;
  PetscBool     given;
  const char  **names;

  PetscFunctionBeginUser;
  if (!MpmRegionIsLayer(body->region) && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHas(block, "below", &given));
  MpmCheckInput(!given || b > 0 || MpmOptionsHelp(), "-%sbelow: must be a body that is named before this one",
                block->prefix);
  if (!b && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((b + 2), &names));
  for (PetscInt c = 0; c < PetscMax(b, 1); c++) names[c] = bodies->names[c];
  PetscCall(MpmOptionsWord(block, "below",
                           "in place of top: a body of region layers, or in 3D raster, named before this one, at whose "
                           "lower end it begins",
                           names, MPM_OPTIONAL, &above, &given));
  PetscCall(PetscFree(names));
  if (!given || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(MpmRegionGetType(bodies->at[above]->region) == MpmRegionGetType(body->region) &&
                  MpmRegionIsBoundedBelow(bodies->at[above]->region),
                "-%sbelow %s: must be a body of region %s with a bottom", block->prefix, bodies->names[above],
                MpmRegionGetType(body->region) == MPM_REGION_LAYERS ? "layers" : "raster");
  PetscCall(MpmRegionSetAbove(body->region, bodies->at[above]->region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of bodies on a lattice, which those from a file do not have. */
static PetscErrorCode ReadLattice(const MpmOptions *block, const MpmGrid *grid, MpmBody body)
{
  static const char *const edges[] = {"centers", "cut", NULL};
  PetscBool                fill = PETSC_FALSE, given = PETSC_FALSE;
  PetscInt                 edge = MpmRegionIsLayer(body->region) && MpmRegionGetType(body->region) != MPM_REGION_LAYERS;

  PetscFunctionBeginUser;
  if (MpmRegionGetType(body->region) >= MPM_REGION_FILE && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsInts(block, "points_per_cell", "points per cell and axis; order + 1 with elements, else 2", 1, 64,
                           MPM_OPTIONAL, grid->dim, body->cells.per_cell, NULL));
  PetscCall(MpmOptionsBool(
    block, "fill",
    "where the body joins a stage: fill the gap down to settled ground; unless given, gaps within a cell", &fill,
    &given));
  if (given) body->filling.fill = fill ? MPM_FILL_YES : MPM_FILL_NO;
  PetscCall(MpmOptionsBool(block, "priority",
                           "the body replaces others where it overlaps them, unless it joins a later stage than they "
                           "do; of two such bodies the one named later",
                           &body->beside.priority, NULL));
  PetscCall(MpmOptionsWord(block, "edge",
                           "centers: points whose domains' centres lie in the region, with whole domains; cut: these "
                           "points with the volume and centroid of what the region has of their domains",
                           edges, MPM_OPTIONAL, &edge, NULL));
  body->cut = (PetscBool)(edge == 1);
  PetscCall(ReadStress(block, grid->dim, body));
  MpmCheckInput(!MpmRegionVoxels(body->region) || !(body->cut || body->start.stress) || MpmOptionsHelp(),
                "-%s%s: not available with region voxels", block->prefix, body->cut ? "edge cut" : "initial_stress");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void SetLattice(const MpmGrid *grid, MpmBody body)
{
  MpmBodyLattice *lattice = &body->lattice;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lattice->count[a] = (body->cells.upper[a] - body->cells.lower[a]) * body->cells.per_cell[a];
    if (a >= grid->dim) continue;
    lattice->spacing[a] = grid->h[a] / (PetscReal)body->cells.per_cell[a];
    lattice->lower[a]   = grid->lower[a] + grid->h[a] * (PetscReal)body->cells.lower[a];
  }
}

static PetscErrorCode ReadMaterial(const MpmOptions *block, const MpmMaterials *materials, MpmBody body)
{
  const PetscBool by_row = (PetscBool)(MpmRegionGetType(body->region) == MPM_REGION_FILE && !MpmOptionsHelp());
  const char    **names;

  PetscFunctionBeginUser;
  if (MpmRegionGetType(body->region) == MPM_REGION_VOXELS && !MpmOptionsHelp())
    PetscFunctionReturn(MpmBodyNameLabels(block, materials, body));
  PetscCall(PetscCalloc1((materials->count + 1), &names));
  for (PetscInt m = 0; m < materials->count; m++) names[m] = materials->names[m];
  if (by_row) body->material.first = -1;
  PetscCall(MpmOptionsWord(block, "material", "one of -mpm_materials; of region file, unless its points have their own",
                           names, by_row ? MPM_OPTIONAL : MPM_REQUIRED, &body->material.first, NULL));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyCreate(const MpmOptions *options, const MpmGrid *grid, const MpmMaterials *materials,
                             MpmBodies *bodies, PetscInt b)
{
  char       prefix[256];
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];
  MpmBody    body;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&body));
  bodies->at[b] = body;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", bodies->names[b]));
  PetscCall(PetscStrallocpy(bodies->names[b], &body->name));
  body->dim = grid->dim;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    body->cells.per_cell[a] = a < grid->dim ? PetscMax(2, grid->order + 1) : 1;
    tolerance[a]            = MPM_TOLERANCE * grid->h[a];
  }
  PetscCall(MpmOptionsHeading(&block, "Body"));
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &body->region));
  PetscCall(ReadBelow(&block, bodies, b));
  PetscCall(ReadMaterial(&block, materials, body));
  if (materials->count && !MpmRegionVoxels(body->region) && body->material.first >= 0)
    PetscCall(MpmBodyInitialCreate(&block, &materials->at[body->material.first], &body->initial));
  PetscCall(ReadLattice(&block, grid, body));
  if (MpmRegionGetType(body->region) < MPM_REGION_FILE && !MpmOptionsHelp()) PetscCall(FindCells(&block, grid, body));
  SetLattice(grid, body);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyIsCut(MpmBody body)
{
  return body->cut;
}

PetscBool MpmBodyIsStressed(MpmBody body)
{
  return (PetscBool)(body->start.stress != NULL);
}

PetscErrorCode MpmBodyReadFile(const MpmOptions *options, const char *name, const MpmGrid *grid,
                               const MpmMaterials *materials, PetscInt field_count, const MpmFileField fields[],
                               MpmBody body)
{
  char             prefix[256];
  const MpmOptions block  = {options->comm, prefix, options->record};
  PetscBool        given  = PETSC_FALSE;
  MpmRowChoice     choice = {materials->count, (const char *const *)materials->names, body->material.first, NULL};

  PetscFunctionBeginUser;
  if (MpmRegionGetType(body->region) < MPM_REGION_FILE && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(MpmOptionsHas(&block, "region", &given));
  if (MpmRegionGetType(body->region) > MPM_REGION_FILE || (MpmOptionsHelp() && !given))
    PetscCall(MpmImportedHandover(&block, MpmRegionGetType(body->region), grid,
                                  &materials->at[PetscMax(body->material.first, 0)], &body->imported));
  if (MpmRegionGetType(body->region) != MPM_REGION_FILE && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (body->material.first < 0) PetscCall(PetscCalloc1(materials->count + 1, &body->material.has));
  choice.has = body->material.has;
  PetscCall(MpmImportedCreate(&block, grid, &choice, materials->at, field_count, fields, &body->imported));
  if (body->material.has && !MpmOptionsHelp())
    PetscCall(MpmBodySetMaterials(&block, materials->count, "file: no point has a material", body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const struct MpmHandover *MpmBodyHandover(MpmBody body)
{
  return body->imported ? MpmImportedGetHandover(body->imported) : NULL;
}

const PetscReal *MpmBodyFileField(MpmBody body, const char *name)
{
  return body->imported ? MpmImportedField(body->imported, name) : NULL;
}

PetscBool MpmBodyFileHasMass(MpmBody body)
{
  return (PetscBool)(body->imported && MpmImportedHasMass(body->imported));
}

PetscErrorCode MpmBodyReadDepth(const MpmOptions *options, const char *name, const MpmGrid *grid, const MpmBed *bed,
                                MpmShapeType shape, MpmEdgeType edge, MpmBody body)
{
  char             prefix[256];
  const MpmOptions block  = {options->comm, prefix, options->record};
  const PetscBool  ground = (PetscBool)(body->dim > 2 && MpmRegionIsLayer(body->region));
  const PetscBool  raster = (PetscBool)(MpmRegionGetType(body->region) == MPM_REGION_RASTER && !ground);
  const PetscBool  flows  = (PetscBool)(MpmRegionGetType(body->region) == MPM_REGION_HYDROGRAPH);

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  MpmCheckInput(bed || !(raster || flows) || MpmOptionsHelp(), "-%sregion %s: is for -mpm_physics depth_averaged%s",
                block.prefix, raster ? "raster" : "hydrograph", raster ? ", or for -mpm_dim 3" : "");
  if (!bed && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(
    !bed || (MpmRegionGetType(body->region) != MPM_REGION_FILE && MpmRegionGetType(body->region) != MPM_REGION_COLUMNS),
    "-%sregion: points on a bed are made from region depth, or from a region with a depth or a level", block.prefix);
  if (body->imported && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (!raster || MpmOptionsHelp()) PetscCall(MpmBodyDepthCreate(&block, bed, shape, edge, &body->depth));
  if (raster || MpmOptionsHelp())
    PetscCall(
      MpmReleaseCreate(&block, grid, bed, MpmRegionOutline(body->region), body->cells.per_cell, &body->release));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyVolume(MpmBody body, PetscReal *exact, PetscReal *points)
{
  if (body->release) MpmReleaseVolume(body->release, exact, points);
  if (body->release || !(body->volume[0] > 0.)) return (PetscBool)(body->release != NULL);
  *exact  = body->volume[0];
  *points = body->volume[1];
  return PETSC_TRUE;
}

PetscErrorCode MpmBodyReadStart(const MpmOptions *options, const char *name, const char *field, MpmBody body)
{
  char             prefix[256], key[64];
  const PetscBool  water = (PetscBool)!strcmp(field, "pressure");
  const MpmRange   range = strcmp(field, "damage") ? MPM_RANGE_ANY : (MpmRange){0., 1., PETSC_FALSE};
  const MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(PetscSNPrintf(key, sizeof(key), "initial_%s", field));
  PetscCall(MpmOptionsReal(&block, key, water ? "Pa" : "-",
                           water ? "pressure of the water to start with, beyond the hydrostatic one"
                                 : "value of the field to start with",
                           range, MPM_OPTIONAL, &body->start.value, &body->start.own_value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyReadVelocity(const MpmOptions *options, const char *name, MpmShapeType shape, MpmBody body,
                                   const char **given, const char **file, PetscBool *run)
{
  char             prefix[256];
  const MpmOptions block = {options->comm, prefix, options->record};
  PetscBool        moves;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(MpmOptionsReals(&block, "velocity", "m/s", "with which its points start, in scenes with a dynamic stage",
                            MPM_RANGE_ANY, MPM_OPTIONAL, body->dim, body->motion.velocity, &moves));
  PetscCall(MpmOptionsReals(&block, "spin", "rad/s",
                            "angular velocity about its centre of mass with which its points start; in 3D a vector",
                            MPM_RANGE_ANY, MPM_OPTIONAL, body->dim == 2 ? 1 : 3,
                            &body->motion.spin[body->dim == 2 ? 2 : 0], &body->motion.spins));
  body->motion.degree   = MpmShapeDegree(shape);
  body->motion.averaged = MpmShapeHasDomain(shape);
  *given                = moves ? "velocity" : body->motion.spins ? "spin" : NULL;
  *file                 = NULL;
  body->motion.of_block = moves;
  if (!MpmOptionsHelp() && body->imported && MpmImportedVelocity(body->imported) && !moves)
    *file = MpmImportedPath(body->imported, run);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PetscReal *MpmBodyFileStart(MpmBody body, const char *name)
{
  return body->start.own_value ? NULL : MpmBodyFileField(body, name);
}

PetscReal MpmBodyStart(const MpmBody body)
{
  return body->start.value;
}

PetscErrorCode MpmBodyDestroy(MpmBody *body)
{
  PetscFunctionBeginUser;
  if (!*body) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBodyDepthDestroy(&(*body)->depth));
  PetscCall(MpmReleaseDestroy(&(*body)->release));
  PetscCall(PetscFree((*body)->name));
  PetscCall(MpmRegionDestroy(&(*body)->region));
  PetscCall(MpmImportedDestroy(&(*body)->imported));
  PetscCall(MpmBodyInitialDestroy(&(*body)->initial));
  PetscCall(PetscFree((*body)->beside.before));
  PetscCall(PetscFree((*body)->beside.winners));
  PetscCall(PetscFree((*body)->start.stress));
  PetscCall(PetscFree((*body)->material.has));
  PetscCall(PetscFree(*body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of the body's box that it fills, from a coarse lattice; never none. */
static PetscReal FilledPart(const MpmBody body, const MpmGrid *grid)
{
  const PetscInt across = grid->dim == 2 ? 64 : 24, total = grid->dim == 2 ? 64 * 64 : 24 * 24 * 24;
  PetscInt       inside = 0;

  for (PetscInt k = 0; k < total; k++) {
    const PetscInt sub[MPM_MAX_DIM] = {k % across, (k / across) % across, k / (across * across)};
    PetscReal      x[MPM_MAX_DIM];

    for (PetscInt a = 0; a < grid->dim; a++) {
      x[a] = grid->lower[a] +
             grid->h[a] * ((PetscReal)body->cells.lower[a] + (PetscReal)(body->cells.upper[a] - body->cells.lower[a]) *
                                                               ((PetscReal)sub[a] + 0.5) / (PetscReal)across);
    }
    if (MpmBodyOwns(body, x)) inside++;
  }
  return (PetscReal)PetscMax(inside, 1) / (PetscReal)total;
}

PetscErrorCode MpmBodyEstimate(const MpmBody body, const MpmGrid *grid, PetscInt lower[], PetscInt upper[],
                               PetscReal *points)
{
  PetscFunctionBeginUser;
  *points = 0.;
  if (body->imported) PetscFunctionReturn(PETSC_SUCCESS); /* its points are in memory already */
  *points = 1.;
  for (PetscInt a = 0; a < grid->dim; a++) {
    lower[a] = PetscMin(lower[a], body->cells.lower[a]);
    upper[a] = PetscMax(upper[a], body->cells.upper[a]);
    *points *= (PetscReal)(body->cells.upper[a] - body->cells.lower[a]) * (PetscReal)body->cells.per_cell[a];
  }
  if (body->release) *points = (PetscReal)MpmReleaseTotal(body->release);
  else if (*points > 1e4) *points *= FilledPart(body, grid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end)
{
  *first = body->ids.first;
  *end   = body->ids.end;
}

void MpmBodyGetLattice(MpmBody body, MpmBodyLattice *lattice)
{
  *lattice = body->lattice;
}

MpmFill MpmBodyFills(MpmBody body)
{
  return body->filling.fill;
}

void MpmBodySetJoins(MpmBody body)
{
  body->filling.joins = PETSC_TRUE;
}

PetscInt MpmBodyFillId(MpmBody body, const MpmPoints *points, PetscInt column, PetscInt row)
{
  const PetscInt room = points->domain.divisions ? 1 << MPM_DIVISIONS : 1;

  return body->ids.first + room * (body->ids.count + column * body->filling.rows + row);
}

PetscReal MpmBodySpacing(MpmBody body)
{
  PetscInt least = PETSC_INT_MAX;

  for (PetscInt a = 0; a < body->dim; a++) least = PetscMin(least, body->cells.per_cell[a]);
  if (body->release) return MpmReleaseSpacing(body->release);
  return body->imported ? 0. : 1. / (PetscReal)least;
}

PetscInt MpmBodyMaterial(MpmBody body)
{
  return body->material.first;
}

PetscBool MpmBodyIsImported(MpmBody body)
{
  return (PetscBool)(body->imported || body->release);
}

PetscBool MpmBodyIsReleased(MpmBody body)
{
  return (PetscBool)(body->release != NULL);
}

MpmRegion MpmBodyRound(MpmBody body)
{
  return !MpmBodyIsImported(body) && MpmRegionIsRound(body->region) ? body->region : NULL;
}

/* ---- whose a place is ---- */

PetscBool MpmBodyOwns(MpmBody body, const PetscReal x[])
{
  if (!MpmRegionContains(body->region, x)) return PETSC_FALSE;
  for (PetscInt b = 0; b < body->beside.winner_count; b++)
    if (MpmRegionContains(body->beside.winners[b]->region, x)) return PETSC_FALSE;
  return PETSC_TRUE;
}

#define INTERIOR 1e-3 /* of a cell: further than this from the edge is inside a region, not on its edge */

MpmHold MpmBodyHolds(MpmBody body, const MpmGrid *grid, const PetscReal x[])
{
  PetscReal y[MPM_MAX_DIM] = {0., 0., 0.};

  if (MpmBodyIsImported(body)) return MPM_HOLD_NONE;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal cell = (x[a] - grid->lower[a]) / grid->h[a];

    if (cell < (PetscReal)body->cells.lower[a] || cell > (PetscReal)body->cells.upper[a]) return MPM_HOLD_NONE;
    y[a] = x[a];
  }
  if (!MpmBodyOwns(body, x)) return MPM_HOLD_NONE;
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscInt a = k / 2;

    y[a] = x[a] + (k % 2 ? INTERIOR : -INTERIOR) * grid->h[a];
    if (!MpmBodyOwns(body, y)) return MPM_HOLD_EDGE;
    y[a] = x[a];
  }
  return MPM_HOLD_INSIDE;
}

PetscBool MpmBodyReaches(MpmBody body, const PetscReal x[])
{
  return (PetscBool)(!MpmBodyIsImported(body) && MpmBodyOwns(body, x));
}

PetscReal MpmBodyExcess(MpmBody body, const PetscReal x[], PetscInt axis, PetscInt side, PetscReal half)
{
  PetscReal end;

  return !MpmBodyIsImported(body) && MpmRegionEnd(body->region, x, axis, side, half, &end) ? end - half : 0.;
}

MpmBody MpmBodyOfPoint(const MpmBodies *bodies, PetscInt id)
{
  for (PetscInt b = 0; bodies && b < bodies->count; b++)
    if (id < bodies->at[b]->ids.end) return bodies->at[b];
  return NULL;
}

PetscInt MpmBodyNumber(const MpmBodies *bodies, const MpmPoints *points, PetscInt p)
{
  PetscInt b = 0;

  while (b < bodies->count && points->id[p] >= bodies->at[b]->ids.end) b++;
  return b;
}

PetscBool MpmBodiesShareLattice(MpmBody one, MpmBody other)
{
  PetscBool same = (PetscBool)(!MpmBodyIsImported(one) && !MpmBodyIsImported(other));

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    same = (PetscBool)(same && one->cells.per_cell[a] == other->cells.per_cell[a]);
  return same;
}

void MpmBodyHalfLengths(MpmBody body, const MpmGrid *grid, PetscReal half[])
{
  for (PetscInt a = 0; a < grid->dim; a++) half[a] = 0.5 * grid->h[a] / (PetscReal)body->cells.per_cell[a];
}

PetscErrorCode MpmBodySetBefore(MpmBody body, PetscInt count, const MpmBody before[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &body->beside.before));
  for (PetscInt b = 0; b < count; b++)
    if (MpmBodiesShareLattice(body, before[b])) body->beside.before[body->beside.before_count++] = before[b];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyHasPriority(MpmBody body)
{
  return body->beside.priority;
}

PetscErrorCode MpmBodySetWinners(MpmBody body, PetscInt count, const MpmBody winners[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &body->beside.winners));
  PetscCall(PetscArraycpy(body->beside.winners, winners, count));
  body->beside.winner_count = count;
  PetscFunctionReturn(PETSC_SUCCESS);
}
