/*
  Bodies: where the points come from. Points stand on a regular sub-lattice of every cell; a cell that the body's edge
  cuts keeps the points inside.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/body_file.h"
#include "particles/body_initial.h"
#include "particles/body_stress.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"

struct _p_MpmBody {
  char          *name;
  MpmRegion      region;
  MpmImported    imported; /* where the region is a file */
  MpmBodyInitial initial;
  PetscReal     *stress;       /* Cauchy, with which its points start, Pa; or NULL */
  PetscReal      pressure;     /* of the water, beyond the hydrostatic one */
  PetscBool      own_pressure; /* the block has it, and it counts for points from a file, too */
  PetscBool      of_block;     /* the velocity is its block's, and counts for points from a file, too */
  PetscReal      velocity[MPM_MAX_DIM], spin[3]; /* m/s; rad/s, 2D: the third */
  PetscBool      spins, averaged;                /* averaged: the shape is, over the points' domains */
  PetscInt       degree;                         /* of splines, by which affine velocities are kept (momentum.c) */
  PetscInt       dim, material;
  PetscInt       axis, up; /* gravity's axis, and which way is up, 1 or -1 */
  PetscInt       id_first, id_end;
  PetscInt       per_cell[MPM_MAX_DIM];
  MpmFill        fill;  /* gap down to settled ground where it joins a stage */
  PetscBool      joins; /* joins a stage; room for filling points is left behind its ids */
  PetscInt       count, fill_rows;
  int            wrong; /* fault of its stress, as MpmBodyStressFill() has it */
  MpmBodyLattice lattice;
  PetscInt       cell_lower[MPM_MAX_DIM], cell_upper[MPM_MAX_DIM]; /* the cells that the region's bounds meet */
  PetscInt       before_count;
  MpmBody       *before; /* bodies whose points on a shared edge are not this one's */
};

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

    body->cell_lower[a] = 0;
    body->cell_upper[a] = 1;
    if (a >= grid->dim) continue;
    MpmCheckInput(lower[a] <= PETSC_NINFINITY || upper[a] >= PETSC_INFINITY ||
                    (lower[a] >= grid->lower[a] - tolerance && upper[a] <= grid->upper[a] + tolerance),
                  "-%sregion: the body spans [%g, %g] on axis %c, outside the grid, [%g, %g]; -%sclip_lower and "
                  "-%sclip_upper cut it",
                  block->prefix, (double)lower[a], (double)upper[a], "xyz"[a], (double)(grid->lower[a]),
                  (double)(grid->upper[a]), block -> prefix, block -> prefix);
    lower[a] = PetscMax(lower[a], grid->lower[a]);
    upper[a] = PetscMin(upper[a], grid->upper[a]);
    body->cell_lower[a] =
      PetscMax((PetscInt)PetscFloorReal((lower[a] - grid->lower[a]) / grid->h[a] - MPM_TOLERANCE), 0);
    body->cell_upper[a] =
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
  if (count) PetscCall(PetscCalloc1(6, &body->stress));
  for (PetscInt c = 0; count && c < size; c++) body->stress[c] = count > 1 ? given[c] : c < 3 ? given[0] : 0.;
  PetscCall(PetscFree(given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscInt material_count,
                             const MpmMaterial materials[], MpmBody *body)
{
  char         prefix[256];
  MpmOptions   block = {options->comm, prefix, options->record};
  const char **names;
  PetscReal    tolerance[MPM_MAX_DIM];
  PetscBool    is_file, fill = PETSC_FALSE, given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(body));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(PetscStrallocpy(name, &(*body)->name));
  (*body)->dim = grid->dim;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    (*body)->per_cell[a] = a < grid->dim ? 2 : 1;
    tolerance[a]         = MPM_TOLERANCE * grid->h[a];
  }
  PetscCall(MpmOptionsHeading(&block, "Body"));
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &(*body)->region));
  is_file = (PetscBool)(MpmRegionGetType((*body)->region) == MPM_REGION_FILE);
  if (!is_file || MpmOptionsHelp())
    PetscCall(MpmOptionsInts(&block, "points_per_cell", "points per cell and axis", 1, 64, MPM_OPTIONAL, grid->dim,
                             (*body)->per_cell, NULL));
  PetscCall(PetscCalloc1((material_count + 1), &names));
  for (PetscInt m = 0; m < material_count; m++) names[m] = materials[m].name;
  PetscCall(MpmOptionsWord(&block, "material", "one of -mpm_materials", names, MPM_REQUIRED, &(*body)->material, NULL));
  PetscCall(PetscFree(names));
  if (material_count) PetscCall(MpmBodyInitialCreate(&block, &materials[(*body)->material], &(*body)->initial));
  if (!is_file || MpmOptionsHelp())
    PetscCall(MpmOptionsBool(
      &block, "fill",
      "where the body joins a stage: fill the gap down to settled ground; unless given, gaps within a cell", &fill,
      &given));
  if (!is_file || MpmOptionsHelp()) PetscCall(ReadStress(&block, grid->dim, *body));
  if (given) (*body)->fill = fill ? MPM_FILL_YES : MPM_FILL_NO;
  if (!is_file && !MpmOptionsHelp()) PetscCall(FindCells(&block, grid, *body));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    MpmBodyLattice *lattice = &(*body)->lattice;

    lattice->count[a] = ((*body)->cell_upper[a] - (*body)->cell_lower[a]) * (*body)->per_cell[a];
    if (a >= grid->dim) continue;
    lattice->spacing[a] = grid->h[a] / (PetscReal)(*body)->per_cell[a];
    lattice->lower[a]   = grid->lower[a] + grid->h[a] * (PetscReal)(*body)->cell_lower[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyIsStressed(MpmBody body)
{
  return (PetscBool)(body->stress != NULL);
}

PetscErrorCode MpmBodyReadFile(const MpmOptions *options, const char *name, const MpmGrid *grid,
                               const MpmMaterial materials[], PetscInt field_count, const MpmFileField fields[],
                               MpmBody body)
{
  char             prefix[256];
  const MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  if (MpmRegionGetType(body->region) != MPM_REGION_FILE && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(MpmImportedCreate(&block, grid, &materials[body->material], field_count, fields, &body->imported));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PetscReal *MpmBodyFileField(MpmBody body, const char *name)
{
  return body->imported ? MpmImportedField(body->imported, name) : NULL;
}

PetscBool MpmBodyFileHasMass(MpmBody body)
{
  return (PetscBool)(body->imported && MpmImportedHasMass(body->imported));
}

PetscErrorCode MpmBodyReadPressure(const MpmOptions *options, const char *name, MpmBody body)
{
  char             prefix[256];
  const MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_body_%s_", name));
  PetscCall(MpmOptionsReal(&block, "initial_pressure", "Pa",
                           "pressure of the water to start with, beyond the hydrostatic one", MPM_RANGE_ANY,
                           MPM_OPTIONAL, &body->pressure, &body->own_pressure));
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
                            MPM_RANGE_ANY, MPM_OPTIONAL, body->dim, body->velocity, &moves));
  PetscCall(MpmOptionsReals(
    &block, "spin", "rad/s", "angular velocity about its centre of mass with which its points start; in 3D a vector",
    MPM_RANGE_ANY, MPM_OPTIONAL, body->dim == 2 ? 1 : 3, &body->spin[body->dim == 2 ? 2 : 0], &body->spins));
  body->degree   = MpmShapeDegree(shape);
  body->averaged = MpmShapeHasDomain(shape);
  *given         = moves ? "velocity" : body->spins ? "spin" : NULL;
  *file          = NULL;
  body->of_block = moves;
  if (!MpmOptionsHelp() && body->imported && MpmImportedVelocity(body->imported) && !moves)
    *file = MpmImportedPath(body->imported, run);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PetscReal *MpmBodyFilePressure(MpmBody body, const char *name)
{
  return body->own_pressure ? NULL : MpmBodyFileField(body, name);
}

PetscReal MpmBodyPressure(const MpmBody body)
{
  return body->pressure;
}

PetscErrorCode MpmBodyDestroy(MpmBody *body)
{
  PetscFunctionBeginUser;
  if (!*body) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*body)->name));
  PetscCall(MpmRegionDestroy(&(*body)->region));
  PetscCall(MpmImportedDestroy(&(*body)->imported));
  PetscCall(MpmBodyInitialDestroy(&(*body)->initial));
  PetscCall(PetscFree((*body)->before));
  PetscCall(PetscFree((*body)->stress));
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
             grid->h[a] * ((PetscReal)body->cell_lower[a] + (PetscReal)(body->cell_upper[a] - body->cell_lower[a]) *
                                                              ((PetscReal)sub[a] + 0.5) / (PetscReal)across);
    }
    if (MpmRegionContains(body->region, x)) inside++;
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
    lower[a] = PetscMin(lower[a], body->cell_lower[a]);
    upper[a] = PetscMax(upper[a], body->cell_upper[a]);
    *points *= (PetscReal)(body->cell_upper[a] - body->cell_lower[a]) * (PetscReal)body->per_cell[a];
  }
  if (*points > 1e4) *points *= FilledPart(body, grid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end)
{
  *first = body->id_first;
  *end   = body->id_end;
}

void MpmBodyGetLattice(MpmBody body, MpmBodyLattice *lattice)
{
  *lattice = body->lattice;
}

MpmFill MpmBodyFills(MpmBody body)
{
  return body->fill;
}

void MpmBodySetJoins(MpmBody body)
{
  body->joins = PETSC_TRUE;
}

PetscInt MpmBodyFillId(MpmBody body, const MpmPoints *points, PetscInt column, PetscInt row)
{
  const PetscInt room = points->divisions ? 1 << MPM_DIVISIONS : 1;

  return body->id_first + room * (body->count + column * body->fill_rows + row);
}

PetscReal MpmBodySpacing(MpmBody body)
{
  PetscInt least = PETSC_INT_MAX;

  for (PetscInt a = 0; a < body->dim; a++) least = PetscMin(least, body->per_cell[a]);
  return body->imported ? 0. : 1. / (PetscReal)least;
}

PetscInt MpmBodyMaterial(MpmBody body)
{
  return body->material;
}

PetscBool MpmBodyIsImported(MpmBody body)
{
  return (PetscBool)(body->imported != NULL);
}

MpmRegion MpmBodyRound(MpmBody body)
{
  return !body->imported && MpmRegionIsRound(body->region) ? body->region : NULL;
}

/* ---- whose a place is ---- */

#define INTERIOR 1e-3 /* of a cell: further than this from the edge is inside a region, not on its edge */

MpmHold MpmBodyHolds(MpmBody body, const MpmGrid *grid, const PetscReal x[])
{
  PetscReal y[MPM_MAX_DIM] = {0., 0., 0.};

  if (body->imported) return MPM_HOLD_NONE;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal cell = (x[a] - grid->lower[a]) / grid->h[a];

    if (cell < (PetscReal)body->cell_lower[a] || cell > (PetscReal)body->cell_upper[a]) return MPM_HOLD_NONE;
    y[a] = x[a];
  }
  if (!MpmRegionContains(body->region, x)) return MPM_HOLD_NONE;
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscInt a = k / 2;

    y[a] = x[a] + (k % 2 ? INTERIOR : -INTERIOR) * grid->h[a];
    if (!MpmRegionContains(body->region, y)) return MPM_HOLD_EDGE;
    y[a] = x[a];
  }
  return MPM_HOLD_INSIDE;
}

PetscBool MpmBodyReaches(MpmBody body, const PetscReal x[])
{
  return (PetscBool)(!body->imported && MpmRegionContains(body->region, x));
}

PetscReal MpmBodyExcess(MpmBody body, const PetscReal x[], PetscInt axis, PetscInt side, PetscReal half)
{
  PetscReal end;

  return !body->imported && MpmRegionEnd(body->region, x, axis, side, half, &end) ? end - half : 0.;
}

MpmBody MpmBodyOfPoint(const MpmBodies *bodies, PetscInt id)
{
  for (PetscInt b = 0; bodies && b < bodies->count; b++)
    if (id < bodies->at[b]->id_end) return bodies->at[b];
  return NULL;
}

PetscInt MpmBodyNumber(const MpmBodies *bodies, const MpmPoints *points, PetscInt p)
{
  PetscInt b = 0;

  while (b < bodies->count && points->id[p] >= bodies->at[b]->id_end) b++;
  return b;
}

PetscBool MpmBodiesShareLattice(MpmBody one, MpmBody other)
{
  PetscBool same = (PetscBool)(!one->imported && !other->imported);

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) same = (PetscBool)(same && one->per_cell[a] == other->per_cell[a]);
  return same;
}

void MpmBodyHalfLengths(MpmBody body, const MpmGrid *grid, PetscReal half[])
{
  for (PetscInt a = 0; a < grid->dim; a++) half[a] = 0.5 * grid->h[a] / (PetscReal)body->per_cell[a];
}

PetscErrorCode MpmBodySetBefore(MpmBody body, PetscInt count, const MpmBody before[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &body->before));
  for (PetscInt b = 0; b < count; b++)
    if (MpmBodiesShareLattice(body, before[b])) body->before[body->before_count++] = before[b];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the point stands on an edge shared with an earlier body that has a point at this very place. */
static PetscBool IsTaken(const MpmBody body, const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt b = 0; b < body->before_count; b++) {
    if (MpmBodyHolds(body->before[b], grid, x) == MPM_HOLD_EDGE && MpmBodyHolds(body, grid, x) == MPM_HOLD_EDGE)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- points ---- */

void MpmBodySetVertical(MpmBody body, PetscInt axis, PetscInt up)
{
  body->axis = axis;
  body->up   = up;
}

/* Of a place, up gravity's axis. */
static PetscReal Height(const MpmBody body, const PetscReal x[])
{
  return (PetscReal)body->up * x[body->axis];
}

/*
  Goes through this rank's share of the body's cells; counts the points inside, and writes them from `first` on where
  points is given.
*/
static PetscInt FillCells(const MpmBody body, const MpmGrid *grid, PetscInt64 id, PetscInt first, MpmPoints *points)
{
  const PetscInt dim      = grid->dim;
  PetscInt64     cells    = 1, begin, end;
  PetscInt       per_cell = 1, count = 0, extent[MPM_MAX_DIM];
  PetscReal      volume = 1., x[MPM_MAX_DIM] = {0., 0., 0.};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    extent[a] = body->cell_upper[a] - body->cell_lower[a];
    cells *= extent[a];
    per_cell *= body->per_cell[a];
    volume *= grid->h[a] / (PetscReal)body->per_cell[a];
  }
  begin = cells * grid->rank / grid->size;
  end   = cells * (grid->rank + 1) / grid->size;
  for (PetscInt64 k = begin; k < end; k++) {
    const PetscInt64 cell[MPM_MAX_DIM] = {k % extent[0], (k / extent[0]) % extent[1],
                                          k / ((PetscInt64)extent[0] * extent[1])};

    for (PetscInt q = 0; q < per_cell; q++) {
      const PetscInt *m = body->per_cell, sub[MPM_MAX_DIM] = {q % m[0], (q / m[0]) % m[1], q / (m[0] * m[1])};
      PetscInt        p = first + count;

      for (PetscInt a = 0; a < dim; a++) {
        x[a] = grid->lower[a] + grid->h[a] * ((PetscReal)(body->cell_lower[a] + cell[a]) +
                                              ((PetscReal)sub[a] + 0.5) / (PetscReal)body->per_cell[a]);
      }
      if (!MpmRegionContains(body->region, x) || IsTaken(body, grid, x)) continue;
      count++;
      if (!points) continue;
      points->id[p]       = (PetscInt)(id + count - 1);
      points->material[p] = body->material;
      points->volume0[p]  = volume * MpmTurn(points->F_size, x[0]);
      for (PetscInt a = 0; a < dim; a++) {
        points->x[p * dim + a] = points->x0[p * dim + a] = points->origin[p * dim + a] = x[a];
        if (points->half_length) points->half_length[p * dim + a] = 0.5 * grid->h[a] / (PetscReal)body->per_cell[a];
        for (PetscInt b = 0; b < dim; b++) MpmPointF(points, p)[a * dim + b] = a == b ? 1. : 0.;
      }
      if (points->F_size > dim * dim) MpmPointF(points, p)[dim * dim] = 1.;
    }
  }
  return count;
}

/* The surface of the body's region, where it cut the lattice of points. */
static void FillCuts(const MpmBody body, PetscInt dim, PetscInt first, PetscInt end, MpmPoints *points)
{
  for (PetscInt p = first; points->cut && p < end; p++) {
    PetscReal *cut = &points->cut[p * (dim + 1)];

    if (!body->imported &&
        MpmRegionCut(body->region, &points->x[p * dim], &points->half_length[p * dim], cut, &cut[dim]))
      continue;
    for (PetscInt a = 0; a <= dim; a++) cut[a] = 0.;
  }
}

/* Points of bodies on a lattice start without stress, with the history that the scene gives. */
static void FillAtRest(const MpmBody body, const MpmMaterial materials[], const MpmParticles *particles, PetscInt first,
                       PetscInt end, MpmPoints *points)
{
  for (PetscInt p = first; p < end; p++) {
    const MpmMaterial *material = &materials[points->material[p]];

    if (points->state) {
      PetscReal *state = &points->state[p * particles->state_size];

      MpmMaterialStateAtRest(material, particles->dim, state);
      MpmBodyInitialFill(body->initial, particles->dim, Height(body, &points->x[p * particles->dim]), state);
    }
    if (points->mass)
      points->mass[p] = points->volume0[p] * MpmMaterialDensity(material, MpmPointOwn(points, material, p));
  }
}

/* All points of a body from `first` on; ids from `id` on. Returns where they end. */
static PetscErrorCode FillBody(const MpmBody body, const MpmGrid *grid, const MpmMaterial materials[],
                               const MpmParticles *particles, PetscInt64 id, PetscInt *first, MpmPoints *points)
{
  const PetscInt begin = *first, vertical[2] = {body->axis, body->up};

  PetscFunctionBeginUser;
  if (!body->imported) {
    *first += FillCells(body, grid, id, begin, points);
    FillCuts(body, grid->dim, begin, *first, points);
    MpmPointsSetOwn(materials, vertical, grid->dim, begin, *first, points);
    FillAtRest(body, materials, particles, begin, *first, points);
    if (body->stress)
      PetscCall(MpmBodyStressFill(&materials[body->material], grid->dim, body->stress, particles->state_size,
                                  (const PetscInt[]){begin, *first}, points, &body->wrong));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *first += MpmImportedCount(body->imported);
  for (PetscInt p = begin; p < *first; p++) {
    points->id[p]       = (PetscInt)(id + p - begin);
    points->material[p] = body->material;
  }
  for (PetscInt p = begin; p < *first && points->state; p++)
    MpmMaterialStateAtRest(&materials[body->material], grid->dim, &points->state[p * particles->state_size]);
  FillCuts(body, grid->dim, begin, *first, points);
  PetscCall(MpmImportedPlace(body->imported, grid->dim, begin, points));
  MpmPointsSetOwn(materials, vertical, grid->dim, begin, *first, points);
  for (PetscInt p = begin; p < *first && points->state; p++)
    MpmBodyInitialFill(body->initial, grid->dim, Height(body, &points->x[p * grid->dim]),
                       &points->state[p * particles->state_size]);
  PetscCall(MpmImportedFill(body->imported, grid, &materials[body->material], particles->state_size, begin, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* omega x r */
static void Turn(const PetscReal spin[3], PetscInt dim, const PetscReal r[], PetscReal v[])
{
  const PetscReal z = dim == 3 ? r[2] : 0.;

  v[0] = spin[1] * z - spin[2] * r[1];
  v[1] = spin[2] * r[0] - spin[0] * z;
  if (dim == 3) v[2] = spin[0] * r[1] - spin[1] * r[0];
}

/*
  A body that spins about its centre of mass. A point's affine velocity is W D with v = W r: for splines of degree p >=
  2 over a domain of half-length l the second moment is D = (p + 1) h^2/12 + l^2/3; for linear ones W itself is kept.
*/
static PetscErrorCode FillSpin(const MpmBody body, PetscInt number, const MpmGrid *grid, const MpmMaterial materials[],
                               const PetscInt body_of[], const MpmPoints *points)
{
  const PetscInt dim                     = grid->dim;
  PetscReal      centre[MPM_MAX_DIM + 1] = {0.}, v[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (!body->spins) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal mass = body_of[p] == number ? MpmPointMass(points, materials, p) : 0.;

    for (PetscInt a = 0; a < dim; a++) centre[a] += mass * points->x[p * dim + a];
    centre[MPM_MAX_DIM] += mass;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, centre, MPM_MAX_DIM + 1, MPIU_REAL, MPIU_SUM, grid->comm));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal r[MPM_MAX_DIM] = {0., 0., 0.};

    if (body_of[p] != number) continue;
    for (PetscInt a = 0; a < dim; a++) r[a] = points->x[p * dim + a] - centre[a] / centre[MPM_MAX_DIM];
    Turn(body->spin, dim, r, v);
    for (PetscInt a = 0; a < dim; a++) points->velocity[p * dim + a] += v[a];
    for (PetscInt b = 0; points->affine && b < dim; b++) {
      const PetscReal h = grid->h[b], l = body->averaged && points->half_length ? points->half_length[p * dim + b] : 0.;
      PetscReal       unit[MPM_MAX_DIM] = {0., 0., 0.};

      unit[b] = body->degree < 2 ? 1. : (PetscReal)(body->degree + 1) * h * h / 12. + l * l / 3.;
      Turn(body->spin, dim, unit, v);
      for (PetscInt a = 0; a < dim; a++) points->affine[(p * dim + a) * dim + b] = v[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the points move as they are made. */
static PetscErrorCode FillMotion(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, const MpmPoints *points)
{
  const PetscInt dim = grid->dim;
  PetscInt      *body_of, row = 0;

  PetscFunctionBeginUser;
  if (!points->velocity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(points->count, &body_of));
  MpmBodiesOfPoints(body_count, bodies, points, body_of);
  for (PetscInt p = 0; p < points->count; p++, row++) {
    const MpmBody    body = bodies[body_of[p]];
    const PetscReal *velocity;

    if (!p || body_of[p] != body_of[p - 1]) row = 0;
    velocity = body->imported && !body->of_block ? MpmImportedVelocity(body->imported) : NULL;
    for (PetscInt a = 0; a < dim; a++)
      points->velocity[p * dim + a] = velocity ? velocity[row * dim + a] : body->velocity[a];
  }
  if (points->affine) PetscCall(PetscArrayzero(points->affine, points->count * dim * dim));
  if (points->acceleration) PetscCall(PetscArrayzero(points->acceleration, points->count * dim));
  for (PetscInt b = 0; b < body_count; b++) PetscCall(FillSpin(bodies[b], b, grid, materials, body_of, points));
  PetscCall(PetscFree(body_of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room between the ids, where points may be divided. */
static PetscErrorCode MakeRoom(PetscInt body_count, const MpmBody bodies[], MPI_Comm comm, PetscInt64 total,
                               const MpmPoints *points)
{
  const PetscInt64 room = points->divisions ? 1 << MPM_DIVISIONS : 1, ids = room * total;

  PetscFunctionBeginUser;
  PetscCheck(ids < PETSC_INT_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "ids of points up to %" PetscInt64_FMT " need PETSc with 64-bit indices", ids);
  if (room == 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < body_count; b++) {
    bodies[b]->id_first *= (PetscInt)room;
    bodies[b]->id_end *= (PetscInt)room;
  }
  for (PetscInt p = 0; p < points->count; p++) points->id[p] *= (PetscInt)room;
  PetscCall(PetscArrayzero(points->divisions, points->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ids that are left for points with which a body fills the gap beneath: all rows of the grid in each column. */
static PetscInt64 FillIds(MpmBody body, const MpmGrid *grid)
{
  PetscInt64 columns = 1;

  if (!body->joins || body->imported || body->fill == MPM_FILL_NO) return 0;
  for (PetscInt a = 0; a < grid->dim; a++)
    if (a != body->axis) columns *= body->lattice.count[a];
  body->fill_rows = grid->cells[body->axis] * body->per_cell[body->axis];
  return columns * body->fill_rows;
}

PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles)
{
  PetscInt64 *count, *before, *total, id = 0;
  PetscInt    local = 0, first = 0;
  MpmPoints   points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(body_count, &count, body_count, &before, body_count, &total));
  for (PetscInt b = 0; b < body_count; b++) {
    count[b] = bodies[b]->imported ? MpmImportedCount(bodies[b]->imported) : FillCells(bodies[b], grid, 0, 0, NULL);
    local += (PetscInt)count[b];
  }
  PetscCallMPI(MPI_Scan(count, before, (PetscMPIInt)body_count, MPIU_INT64, MPI_SUM, grid->comm));
  PetscCall(MPIU_Allreduce(count, total, (PetscMPIInt)body_count, MPIU_INT64, MPI_SUM, grid->comm));
  for (PetscInt b = 0; b < body_count; b++) {
    MpmCheckInput(total[b] > 0, "-mpm_body_%s_region: there is no point in it", bodies[b]->name);
  }
  particles->total = 0;
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, local, MPM_PARTICLES_SPARE));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(PetscArrayzero(points.stress, local * particles->stress_size));
  if (points.across) PetscCall(PetscArrayzero(points.across, local));
  if (points.state) PetscCall(PetscArrayzero(points.state, local * particles->state_size));
  for (PetscInt b = 0; b < body_count; b++) {
    PetscCall(FillBody(bodies[b], grid, materials, particles, id + before[b] - count[b], &first, &points));
    bodies[b]->count    = (PetscInt)total[b];
    bodies[b]->id_first = (PetscInt)id;
    id += total[b] + FillIds(bodies[b], grid);
    particles->total += total[b];
    bodies[b]->id_end = (PetscInt)id;
  }
  for (PetscInt b = 0; b < body_count; b++) {
    PetscCall(MpmBodyInitialCheck(bodies[b]->initial, grid->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bodies[b]->wrong, 1, MPI_INT, MPI_MAX, grid->comm));
    MpmCheckInput(!bodies[b]->wrong, "-mpm_body_%s_initial_stress: %s of material %s", bodies[b]->name,
                  bodies[b]->wrong == 1 ? "lies outside of the yield surface" : "is none that a state has",
                  materials[bodies[b]->material].name);
  }
  if (points.increment) PetscCall(PetscArrayzero(points.increment, local * MPM_INCREMENT(grid->dim)));
  if (points.value) PetscCall(PetscArrayzero(points.value, local * particles->rates));
  if (points.value) PetscCall(PetscArrayzero(points.value_gradient, local * particles->rates * grid->dim));
  PetscCall(FillMotion(body_count, bodies, materials, grid, &points));
  PetscCall(MakeRoom(body_count, bodies, grid->comm, id, &points));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(PetscFree3(count, before, total));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBodiesOfPoints(PetscInt body_count, const MpmBody bodies[], const MpmPoints *points, PetscInt body_of[])
{
  for (PetscInt p = 0; p < points->count; p++) {
    PetscInt b = 0;

    while (b + 1 < body_count && points->id[p] >= bodies[b]->id_end) b++;
    body_of[p] = b;
  }
}
