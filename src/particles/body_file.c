/*
  Points that a body reads from a file.

    file           HDF5 or CSV, see point_table.c
    step           of a file with /points: a number, or latest
    materials      of the points: voxels/row_labels.c

  Position (x, y (, z)) and volume are required, as they stand. Optional are:

    F             deformation gradient, 9 components; the initial volume is then volume/det F
    half_length   of the domain that F deforms; else a cube of the volume
    mass          else density times the volume
    velocity      else that of the body's block, which counts where both are given
    stress        Cauchy, xx, yy, zz, xy, yz, xz; F or the law's history are searched for it where they are not given
    ...           the law's history by its names, and fields of the physics, such as pressure and porosity

  Displacements start at zero. Other columns are refused, and datasets of files that are no run's.
*/
#include "options/options.h"
#include "io/io.h"
#include "files/point_table.h"
#include "voxels/row_labels.h"
#include "point/material.h"
#include "point/registry.h"
#include "point/stress_inversion.h"
#include "grid/grid.h"
#include "handover/handover.h"
#include "handover/hydrograph.h"
#include "particles/body_file.h"
#include "particles/point_mass.h"
#include "particles/points.h"

enum { POSITION, VOLUME, DEFORMATION, HALF_LENGTH, MASS, STRESS, VELOCITY, STATES };

#define WIDER 1.01 /* a domain over its volume, from where on it is wider and not rounded */

/* `components` values a point, or NULL where the file has none. */
typedef struct {
  const char *name;
  PetscInt    components;
  PetscReal  *value;
} Quantity;

struct _p_MpmImported {
  PetscInt    count, quantity_count;
  PetscInt    state_count; /* of the history of all laws */
  Quantity   *quantity;    /* by the names above, then the laws' history, then the physics' fields */
  PetscInt   *material;    /* row by row; NULL: the body's */
  char       *path;
  PetscBool   run;      /* another run has written the file */
  MpmHandover handover; /* of columns and depths; the quantities are its arrays then */
};

/* Leaves out rows that make no point; of those of a body with one material the choice is then forgotten. */
static PetscErrorCode DropRows(PetscBool one, MpmImported imported)
{
  PetscInt kept = 0;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; imported->material && p < imported->count; p++) {
    if (imported->material[p] < 0) continue;
    for (PetscInt q = 0; q < imported->quantity_count && kept < p; q++) {
      const PetscInt n = imported->quantity[q].components;

      for (PetscInt c = 0; imported->quantity[q].value && c < n; c++)
        imported->quantity[q].value[kept * n + c] = imported->quantity[q].value[p * n + c];
    }
    imported->material[kept++] = imported->material[p];
  }
  if (imported->material) imported->count = kept;
  if (one) PetscCall(PetscFree(imported->material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fault of a point's own numbers, or NULL. */
static const char *WrongPoint(const MpmImported imported, const MpmGrid *grid, PetscReal density, PetscInt p)
{
  const PetscInt   dim = grid->dim;
  const PetscReal *x = &imported->quantity[POSITION].value[p * dim], *F = imported->quantity[DEFORMATION].value;
  const PetscReal *half = imported->quantity[HALF_LENGTH].value;
  const PetscReal  turn = grid->axial ? MpmGridTurn(grid, x[0]) : 0.;
  PetscReal        plane[MPM_MAX_DIM * MPM_MAX_DIM], room = 1., domain = 1.;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal slack = MPM_TOLERANCE * grid->h[a], extent = grid->upper[a] - grid->lower[a];

    room *= a == 0 && grid->axial ? MpmGridTurn(grid, grid->upper[0]) * extent : extent;
    if (!(x[a] >= grid->lower[a] - slack && x[a] <= grid->upper[a] + slack)) return "is outside the grid";
    if (half && !(half[p * dim + a] > 0.)) return "has a half_length that is not positive";
    if (half && half[p * dim + a] > extent) return "has a half_length that is more than the grid's extent";
    if (half) domain *= 2. * half[p * dim + a];
    for (PetscInt b = 0; F && b < dim; b++) plane[a * dim + b] = F[9 * p + 3 * a + b];
  }
  if (!(imported->quantity[VOLUME].value[p] > 0.)) return "has a volume that is not positive";
  if (imported->quantity[VOLUME].value[p] > room) return "has a volume that is more than the grid's";
  if (imported->quantity[MASS].value && !(imported->quantity[MASS].value[p] >= 0.)) return "has a negative mass";
  if (imported->quantity[MASS].value && imported->quantity[MASS].value[p] == 0. && density > 0.)
    return "has a mass of 0, and its material a density: without the column the mass is density times volume";
  if (F && !(MpmDeterminant(dim * dim, plane) * (turn > 0. ? F[9 * p + 8] : 1.) > 0.))
    return "has an F whose determinant is not positive";
  if (half && !imported->run &&
      domain * (F ? MpmDeterminant(dim * dim, plane) : 1.) * (turn > 0. ? turn : 1.) >
        WIDER * imported->quantity[VOLUME].value[p])
    return "has half_lengths whose domain, the product of their doubles, is larger than its volume";
  return NULL;
}

/* Material of a row; `own`: the body's. */
static PetscInt MaterialOf(const MpmImported imported, PetscInt own, PetscInt row)
{
  return imported->material ? imported->material[row] : own;
}

static PetscErrorCode CheckPoints(const MpmOptions *block, const MpmGrid *grid, const MpmMaterial materials[],
                                  PetscInt own, const MpmImported imported)
{
  const char *why          = NULL;
  PetscMPIInt rank         = grid->size;
  char        message[256] = "";
  PetscInt    p;

  PetscFunctionBeginUser;
  for (p = 0; p < imported->count && !why; p++) {
    why = WrongPoint(imported, grid, materials[MaterialOf(imported, own, p)].density, p);
  }
  if (why) {
    const PetscReal *x = &imported->quantity[POSITION].value[(p - 1) * grid->dim];

    rank = grid->rank;
    if (grid->dim == 2)
      PetscCall(PetscSNPrintf(message, sizeof(message), "the point at (%g, %g) %s", (double)x[0], (double)x[1], why));
    else
      PetscCall(PetscSNPrintf(message, sizeof(message), "the point at (%g, %g, %g) %s", (double)x[0], (double)x[1],
                              (double)x[2], why));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, grid->comm));
  if (rank == grid->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(message, (PetscMPIInt)sizeof(message), MPI_CHAR, rank, grid->comm));
  MpmCheckInput(PETSC_FALSE, "-%sfile %s: %s", block->prefix, imported->path, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt StateComponents(const MpmStateVariable *state)
{
  return state->kind == MPM_STATE_SYM ? 6 : 1;
}

/* The quantity of a law's history, or NULL. */
static const Quantity *FindHistory(const MpmImported imported, const MpmStateVariable *state)
{
  for (PetscInt q = STATES; q < STATES + imported->state_count; q++)
    if (imported->quantity[q].components == StateComponents(state) && !strcmp(imported->quantity[q].name, state->name))
      return &imported->quantity[q];
  return NULL;
}

/* Adds variables of a law's history that are not there yet. */
static PetscErrorCode AddHistory(const MpmMaterial *material, MpmImported imported)
{
  PetscFunctionBeginUser;
  for (size_t v = 0; v < material->info.state_count; v++) {
    const MpmStateVariable *state = &material->info.states[v];
    const PetscInt          end   = STATES + imported->state_count;

    if (FindHistory(imported, state)) continue;
    PetscCall(PetscRealloc(sizeof(*imported->quantity) * (size_t)(end + 1), &imported->quantity));
    imported->quantity[end] = (Quantity){state->name, StateComponents(state), NULL};
    imported->state_count++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadQuantities(MpmPointFile file, PetscInt dim, const MpmRowChoice *choice,
                                     const MpmMaterial *materials, PetscInt field_count, const MpmFileField fields[],
                                     MpmImported imported)
{
  static const char *const names[STATES] = {"position", "volume", "F", "half_length", "mass", "stress", "velocity"};
  const PetscInt           components[STATES] = {dim, 1, 9, dim, 1, 6, dim};
  PetscInt                 first;

  PetscFunctionBeginUser;
  imported->count = MpmPointFileCount(file);
  PetscCall(PetscCalloc1(STATES, &imported->quantity));
  for (PetscInt q = 0; q < STATES; q++) imported->quantity[q] = (Quantity){names[q], components[q], NULL};
  for (PetscInt m = 0; m < choice->count; m++)
    if (choice->own < 0 ? choice->has[m] : m == choice->own) PetscCall(AddHistory(&materials[m], imported));
  first                    = STATES + imported->state_count;
  imported->quantity_count = first + field_count;
  PetscCall(PetscRealloc(sizeof(*imported->quantity) * (size_t)imported->quantity_count, &imported->quantity));
  for (PetscInt f = 0; f < field_count; f++)
    imported->quantity[first + f] = (Quantity){fields[f].name, fields[f].components, NULL};
  for (PetscInt q = 0; q < imported->quantity_count; q++)
    PetscCall(MpmPointFileGet(file, imported->quantity[q].name, imported->quantity[q].components,
                              q <= VOLUME ? MPM_REQUIRED : MPM_OPTIONAL, &imported->quantity[q].value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Quantities out of a passage between columns and points; of a law's history, the depth of columns alone. */
static void TakeHandover(PetscInt dim, const MpmMaterial *material, MpmImported imported)
{
  MpmHandover *from = &imported->handover;
  Quantity    *to   = imported->quantity;

  imported->count = from->count;
  to[POSITION]    = (Quantity){"position", dim, from->position};
  to[VOLUME]      = (Quantity){"volume", 1, from->volume};
  to[DEFORMATION] = (Quantity){"F", 9, NULL};
  to[HALF_LENGTH] = (Quantity){"half_length", dim, from->half_length};
  to[MASS]        = (Quantity){"mass", 1, from->mass};
  to[STRESS]      = (Quantity){"stress", 6, from->stress};
  to[VELOCITY]    = (Quantity){"velocity", dim, from->velocity};
  for (size_t v = 0; v < material->info.state_count; v++) {
    const MpmStateVariable *state = &material->info.states[v];

    to[STATES + v] = (Quantity){state->name, StateComponents(state), NULL};
    if (from->depth && !strcmp(state->name, "depth")) to[STATES + v].value = from->depth;
  }
}

PetscErrorCode MpmImportedHandover(const MpmOptions *block, MpmRegionType region, const MpmGrid *grid,
                                   const MpmMaterial *material, MpmImported *handle)
{
  MpmImported imported;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  imported = *handle;
  if (region == MPM_REGION_COLUMNS || MpmOptionsHelp())
    PetscCall(MpmHandoverColumns(block, grid, material->density, &imported->handover));
  if (region == MPM_REGION_HYDROGRAPH || MpmOptionsHelp())
    PetscCall(MpmHandoverHydrograph(block, grid, material->density, &imported->handover));
  if (region == MPM_REGION_DEPTH) PetscCall(MpmHandoverDepth(block, grid, &imported->handover));
  if (MpmOptionsHelp()) PetscFunctionReturn(MpmImportedDestroy(handle));
  imported->state_count    = (PetscInt)material->info.state_count;
  imported->quantity_count = STATES + imported->state_count;
  PetscCall(PetscCalloc1(imported->quantity_count, &imported->quantity));
  TakeHandover(grid->dim, material, imported);
  PetscCall(PetscStrallocpy(imported->handover.path ? imported->handover.path : "(maps)", &imported->path));
  imported->run = PETSC_TRUE;
  PetscCall(CheckPoints(block, grid, material, 0, imported));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const struct MpmHandover *MpmImportedGetHandover(MpmImported imported)
{
  return imported->handover.position ? &imported->handover : NULL;
}

PetscErrorCode MpmImportedCreate(const MpmOptions *block, const MpmGrid *grid, const MpmRowChoice *choice,
                                 const MpmMaterial *materials, PetscInt field_count, const MpmFileField fields[],
                                 MpmImported *handle)
{
  MpmPointFile file;
  MpmImported  imported;
  char        *step;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  imported = *handle;
  PetscCall(
    MpmOptionsPath(block, "file", "HDF5 or CSV file of points, for region file", MPM_REQUIRED, &imported->path));
  PetscCall(MpmOptionsText(block, "step", "which step of a file with /points: a number, or latest", "latest",
                           MPM_OPTIONAL, &step));
  if (MpmOptionsHelp()) {
    PetscCall(MpmRowLabelsRead(block, imported->path, NULL, choice, &imported->material));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmPointFileOpen(block, grid->dim, imported->path, step, &file));
  PetscCall(MpmRowLabelsRead(block, imported->path, file, choice, &imported->material));
  PetscCall(ReadQuantities(file, grid->dim, choice, materials, field_count, fields, imported));
  PetscCall(DropRows((PetscBool)(choice->own >= 0), imported));
  PetscCall(MpmPointFileCheck(file));
  imported->run = MpmPointFileIsRun(file);
  PetscCall(CheckPoints(block, grid, materials, choice->own, imported));
  PetscCall(MpmPointFileClose(&file));
  PetscCall(PetscFree(step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmImportedDestroy(MpmImported *handle)
{
  PetscFunctionBeginUser;
  if (!*handle) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt q = 0; q < (*handle)->quantity_count && !(*handle)->handover.position; q++)
    PetscCall(PetscFree((*handle)->quantity[q].value));
  PetscCall(MpmHandoverDestroy(&(*handle)->handover));
  PetscCall(PetscFree((*handle)->quantity));
  PetscCall(PetscFree((*handle)->material));
  PetscCall(PetscFree((*handle)->path));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmImportedCount(MpmImported imported)
{
  return imported->count;
}

const PetscInt *MpmImportedMaterial(MpmImported imported)
{
  return imported->material;
}

const PetscReal *MpmImportedVelocity(MpmImported imported)
{
  return imported->quantity[VELOCITY].value;
}

const PetscReal *MpmImportedField(MpmImported imported, const char *name)
{
  for (PetscInt q = STATES; q < imported->quantity_count; q++)
    if (!strcmp(imported->quantity[q].name, name)) return imported->quantity[q].value;
  return NULL;
}

PetscBool MpmImportedHasMass(MpmImported imported)
{
  return (PetscBool)(imported->quantity[MASS].value != NULL);
}

const char *MpmImportedPath(MpmImported imported, PetscBool *run)
{
  *run = imported->run;
  return imported->path;
}

/* ---- into the particles ---- */

PetscErrorCode MpmImportedPlace(MpmImported imported, PetscInt dim, PetscInt first, MpmPoints *points)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(&points->x[first * dim], imported->quantity[POSITION].value, imported->count * dim));
  PetscCall(PetscArraycpy(&points->origin[first * dim], imported->quantity[POSITION].value, imported->count * dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the row's history, as far as the file has it; true when it has all of it. */
static PetscBool TakeState(const MpmImported imported, const MpmMaterial *material, PetscInt dim, PetscInt row,
                           PetscReal state[])
{
  PetscBool all = PETSC_TRUE;

  for (size_t v = 0; v < material->info.state_count; v++) {
    const Quantity *quantity = FindHistory(imported, &material->info.states[v]);
    const PetscInt  n        = MpmStateComponents(&material->info.states[v], dim);

    for (PetscInt c = 0; quantity->value && c < n; c++) state[c] = quantity->value[row * quantity->components + c];
    if (!quantity->value) all = PETSC_FALSE;
    state += n;
  }
  return all;
}

/* Position, volume, F, domain and mass. */
static void TakeGeometry(const MpmImported imported, PetscInt dim, PetscReal density, PetscInt row, PetscInt p,
                         MpmPoints *points)
{
  const Quantity *quantity = imported->quantity;
  const PetscReal volume   = quantity[VOLUME].value[row];
  PetscReal      *F        = MpmPointF(points, p), U[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) {
    points->x[p * dim + a] = points->x0[p * dim + a] = points->origin[p * dim + a] =
      quantity[POSITION].value[row * dim + a];
    for (PetscInt b = 0; b < dim; b++)
      F[a * dim + b] =
        quantity[DEFORMATION].value ? quantity[DEFORMATION].value[9 * row + 3 * a + b] : (a == b ? 1. : 0.);
  }
  if (points->F_size > dim * dim) F[4] = quantity[DEFORMATION].value ? quantity[DEFORMATION].value[9 * row + 8] : 1.;
  points->volume0[p] = volume / MpmPointJ(points, p);
  points->mass[p]    = quantity[MASS].value ? quantity[MASS].value[row] : density * volume;
  for (PetscInt a = 0; points->domain.half_length && a < dim; a++)
    points->domain.half_length[p * dim + a] =
      quantity[HALF_LENGTH].value ? quantity[HALF_LENGTH].value[row * dim + a]
                                  : 0.5 * PetscPowReal(MpmPointExtent(points, dim, p), 1. / (PetscReal)dim);
  if (points->domain.drawn == points->domain.half_length || MpmStretchFind(dim)(F, U)) return;
  for (PetscInt a = 0; a < dim; a++) points->domain.drawn[p * dim + a] = points->domain.half_length[p * dim + a] * U[a];
}

/*
  The row's stress, and F or history that give it where the file does not have them. Returns MpmInitialFind()'s result.
*/
static int TakeStress(const MpmImported imported, const MpmInitial *initial, PetscInt row, PetscBool has_state,
                      PetscInt p, MpmPoints *points, PetscReal state[])
{
  const PetscInt  dim = initial->model_dim, size = MpmSymSize(dim);
  const PetscBool has_F  = (PetscBool)(imported->quantity[DEFORMATION].value != NULL);
  PetscReal      *stress = &points->stress[p * size], *F = MpmPointF(points, p), own[MPM_INITIAL_STATE],
            found[MPM_MAX_DIM * MPM_MAX_DIM], U[MPM_MAX_DIM], J;
  int answer;

  if (!imported->quantity[STRESS].value) return 0;
  for (PetscInt c = 0; c < size; c++) stress[c] = imported->quantity[STRESS].value[6 * row + c];
  if (initial->stateful ? has_state : has_F)
    return points->across && MpmInitialAcross(initial, F, state, stress, &points->across[p]) ? 2 : 0;
  J = MpmPointJ(points, p);
  for (PetscInt c = 0; initial->stateful && c < size; c++) stress[c] *= J; /* history holds the Kirchhoff stress */
  answer = MpmInitialFind(initial, state, stress, found, own, points->across ? &points->across[p] : NULL);
  if (answer == 2) return 2;
  for (PetscInt k = 0; k < initial->material->state_size; k++) state[k] = own[k];
  for (PetscInt c = 0; initial->stateful && c < size; c++) stress[c] /= J;
  if (initial->stateful) return answer;
  if (MpmStretchFind(dim)(found, U)) return 2;
  for (PetscInt k = 0; k < points->F_size; k++) F[k] = found[k];
  points->volume0[p] /= MpmPointJ(points, p);
  for (PetscInt a = 0; points->domain.half_length && a < dim; a++) points->domain.half_length[p * dim + a] /= U[a];
  return answer;
}

/* Rows by their materials, those of one material in their order; NULL: all are of one material. */
static PetscErrorCode SortRows(const MpmImported imported, PetscInt **order)
{
  PetscInt *start, most = 0;

  PetscFunctionBeginUser;
  *order = NULL;
  if (!imported->material) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt row = 0; row < imported->count; row++) most = PetscMax(most, imported->material[row] + 1);
  PetscCall(PetscCalloc1(most + 1, &start));
  PetscCall(PetscMalloc1(imported->count + 1, order));
  for (PetscInt row = 0; row < imported->count; row++) start[imported->material[row] + 1]++;
  for (PetscInt m = 0; m < most; m++) start[m + 1] += start[m];
  for (PetscInt row = 0; row < imported->count; row++) (*order)[start[imported->material[row]]++] = row;
  PetscCall(PetscFree(start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row as point p, with its history; PETSC_FALSE where its material cannot have its stress. */
static PetscBool FillRow(const MpmImported imported, const MpmInitial *initial, PetscInt row, PetscInt p,
                         MpmPoints *points, PetscReal state[])
{
  const PetscInt dim = initial->model_dim;
  PetscBool      has_state;

  TakeGeometry(imported, dim, MpmMaterialDensity(initial->material, initial->own), row, p, points);
  has_state = TakeState(imported, initial->material, dim, row, state);
  if (TakeStress(imported, initial, row, has_state, p, points, state) != 2) return PETSC_TRUE;
  if (!imported->handover.position) return PETSC_FALSE;
  for (PetscInt c = 0; c < MpmSymSize(dim); c++) /* columns start with a stress where the law has it */
    points->stress[p * MpmSymSize(dim) + c] = 0.;
  return PETSC_TRUE;
}

PetscErrorCode MpmImportedFill(MpmImported imported, const MpmGrid *grid, const MpmMaterial materials[],
                               PetscInt state_size, PetscInt first, MpmPoints *points)
{
  PetscInt   failed[2] = {PETSC_INT_MAX, 0}, *order; /* the first material, and points of all */
  PetscReal *state;
  MpmInitial initial = {NULL};

  PetscFunctionBeginUser;
  PetscCall(SortRows(imported, &order));
  PetscCall(PetscCalloc1((state_size + 1), &state));
  for (PetscInt k = 0; k < imported->count; k++) {
    const PetscInt     row = order ? order[k] : k, p = first + row;
    const MpmMaterial *material = &materials[points->material[p]];

    if (material != initial.material) PetscCall(MpmInitialCreate(material, grid->dim, &initial));
    initial.own = MpmPointOwn(points, material, p);
    for (PetscInt c = 0; c < state_size; c++) state[c] = points->state[p * state_size + c];
    if (!FillRow(imported, &initial, row, p, points, state)) {
      failed[0] = PetscMin(failed[0], points->material[p]);
      failed[1]++;
    }
    for (PetscInt c = 0; c < state_size; c++) points->state[p * state_size + c] = state[c];
  }
  PetscCall(PetscFree(order));
  PetscCall(PetscFree(state));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed[0], 1, MPIU_INT, MPI_MIN, grid->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed[1], 1, MPIU_INT, MPI_SUM, grid->comm));
  MpmCheckInput(!failed[1], "%s: material %s cannot have the stress of %" PetscInt_FMT " points", imported->path,
                materials[failed[0]].name, failed[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
