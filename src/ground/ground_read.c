/*
  The fields of a scene, read from its options.

    fields: stiff
    field_stiff: {of: soil.E, by: cell, file: stiffness.csv}

    by      body      a value each, by name: a file with two columns, or bodies and values
            region    likewise, regions and values; each has a block of its own, and the first that holds a place counts
            cell      of the background grid at the start, by a place in it or its numbers, or all of them, x fastest
            point     in the order of the points' ids
            pilots    at places, between which ordinary kriging interpolates with the correlation length (kriging.c)
    values  replaces those of the file, in its order; by cell without a file: one for all cells, or one each

  The field takes the place of the material's number, which may be left out.
*/
#include <math.h>
#include <stdlib.h>
#include "options/options.h"
#include "geometry/geometry.h"
#include "ground/ground.h"

/* ---- rows ---- */

/* Values in the order of their ids. */
static PetscErrorCode SortById(MpmGroundTable *table)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 1; table->id && k < table->rows; k++)
    if (table->id[k] < table->id[k - 1]) {
      PetscInt  *order;
      PetscReal *value;

      PetscCall(PetscMalloc2(table->rows, &order, table->rows, &value));
      for (PetscInt i = 0; i < table->rows; i++) order[i] = i;
      PetscCall(PetscSortRealWithPermutation(table->rows, table->id, order));
      for (PetscInt i = 0; i < table->rows; i++) value[i] = table->value[order[i]];
      PetscCall(PetscArraycpy(table->value, value, table->rows));
      PetscCall(PetscFree2(order, value));
      break;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Number of the cell of row k, or -1 where it is outside of the grid. */
static PetscInt CellOfRow(const MpmGroundTable *table, const MpmGroundGrid *grid, PetscInt k)
{
  PetscInt cell = 0;

  if (!table->at && !table->cell) return k;
  for (PetscInt a = grid->dim - 1; a >= 0; a--) {
    const PetscReal part = table->cell ? table->cell[k * grid->dim + a]
                                       : PetscFloorReal((table->at[k * grid->dim + a] - grid->lower[a]) / grid->h[a]);

    if (!(part >= 0. && part < (PetscReal)grid->cells[a]) || part != PetscFloorReal(part)) return -1;
    cell = cell * grid->cells[a] + (PetscInt)part;
  }
  return cell;
}

static PetscInt CountCells(const MpmGroundGrid *grid)
{
  PetscInt count = 1;

  for (PetscInt a = 0; a < grid->dim; a++) count *= grid->cells[a];
  return count;
}

/* The cells' numbers and middles. */
static PetscErrorCode TakeCells(const MpmOptions *block, const char path[], const MpmGroundTable *table,
                                MpmGround *field)
{
  const MpmGroundGrid *grid  = &field->grid;
  const PetscInt       count = CountCells(grid), dim = grid->dim;

  PetscFunctionBeginUser;
  MpmCheckInput(table->at || table->cell || table->rows == count,
                "-%sfile %s: has %" PetscInt_FMT " values without places, must have %" PetscInt_FMT
                ", one for each cell of the grid",
                block->prefix, path, table->rows, count);
  PetscCall(PetscMalloc1(count, &field->cell));
  PetscCall(PetscMalloc1((size_t)(table->rows * dim), &field->at));
  for (PetscInt k = 0; k < count; k++) field->cell[k] = -1;
  for (PetscInt k = 0; k < table->rows; k++) {
    const PetscInt cell = CellOfRow(table, grid, k);
    PetscInt       rest = cell;

    MpmCheckInput(cell >= 0, "-%sfile %s: row %" PetscInt_FMT " is in no cell of the grid", block->prefix, path, k + 1);
    MpmCheckInput(field->cell[cell] < 0,
                  "-%sfile %s: rows %" PetscInt_FMT " and %" PetscInt_FMT " are in the same cell", block->prefix, path,
                  field->cell[cell] + 1, k + 1);
    field->cell[cell] = k;
    for (PetscInt a = 0; a < dim; rest /= grid->cells[a++])
      field->at[k * dim + a] = grid->lower[a] + ((PetscReal)(rest % grid->cells[a]) + 0.5) * grid->h[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows by place, for a search for equal ones. */
static int ComparePlaces(const void *a, const void *b)
{
  const PetscReal *x = (const PetscReal *)a, *y = (const PetscReal *)b;

  for (PetscInt k = 0; k < MPM_MAX_DIM; k++)
    if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
  return 0;
}

static PetscErrorCode TakePilots(const MpmOptions *block, const char path[], MpmGroundTable *table, MpmGround *field)
{
  const PetscInt cells = CountCells(&field->grid), dim = field->dim;
  PetscReal     *row;

  PetscFunctionBeginUser;
  MpmCheckInput(table->at, "-%sfile %s: must have the columns x, y%s of the pilot points", block->prefix, path,
                dim == 3 ? ", z" : "");
  MpmCheckInput(table->rows <= cells,
                "-%sfile %s: has %" PetscInt_FMT " pilot points, more than cells of the grid, %" PetscInt_FMT,
                block->prefix, path, table->rows, cells);
  PetscCall(PetscCalloc1((size_t)(table->rows * MPM_MAX_DIM), &row));
  for (PetscInt k = 0; k < table->rows * dim; k++) row[k / dim * MPM_MAX_DIM + k % dim] = table->at[k];
  qsort(row, (size_t)table->rows, MPM_MAX_DIM * sizeof(*row), ComparePlaces);
  for (PetscInt k = 1; k < table->rows; k++)
    MpmCheckInput(ComparePlaces(&row[(k - 1) * MPM_MAX_DIM], &row[k * MPM_MAX_DIM]),
                  "-%sfile %s: two pilot points are at %g, %g", block->prefix, path, (double)row[k * MPM_MAX_DIM],
                  (double)row[k * MPM_MAX_DIM + 1]);
  PetscCall(PetscFree(row));
  field->at = table->at;
  table->at = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- blocks ---- */

/* -of, "soil.E". */
static PetscErrorCode ReadOf(const MpmOptions *block, MpmGround *field)
{
  char *of, *dot;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsText(block, "of", "MATERIAL.NUMBER that differs from place to place: soil.E", NULL, MPM_REQUIRED, &of));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(of));
  dot = strrchr(of, '.');
  MpmCheckInput(dot && dot > of && dot[1],
                "-%sof %s: must be MATERIAL.NUMBER, a material by its name and a number of it", block->prefix, of);
  *dot             = '\0';
  field->material  = of;
  field->parameter = dot + 1;
  if (!strncmp(of, "material_", 9)) PetscCall(PetscMemmove(of, of + 9, strlen(of) - 8));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The regions of their names. */
static PetscErrorCode ReadRegions(const MpmOptions *block, PetscInt count, char *const names[], MpmGround *field)
{
  PetscReal tolerance[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < field->dim; a++) tolerance[a] = MPM_TOLERANCE * field->grid.h[a];
  PetscCall(PetscCalloc1(count, &field->region));
  for (PetscInt k = 0; k < count; k++) {
    char             prefix[256];
    const MpmOptions of = {block->comm, prefix, block->record};

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "%s%s_", block->prefix, names[k]));
    PetscCall(MpmRegionCreate(&of, field->dim, tolerance, &field->region[k]));
    MpmCheckInput(MpmRegionGetType(field->region[k]) < MPM_REGION_FILE, "-%sregion file: is for bodies alone", prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names of bodies or regions that the block has: NULL where they stand in a file. */
static PetscErrorCode ReadNames(const MpmOptions *block, PetscInt *count, char ***names, MpmGround *field)
{
  PetscFunctionBeginUser;
  *count = 0;
  *names = NULL;
  if (field->kind == MPM_GROUND_BODY || MpmOptionsHelp())
    PetscCall(MpmOptionsNames(block, "bodies", "by body: those that the values are of", MPM_OPTIONAL, count, names));
  if (MpmOptionsHelp()) PetscCall(MpmNamesDestroy(*count, names));
  if (field->kind == MPM_GROUND_REGION || MpmOptionsHelp()) {
    PetscCall(MpmOptionsNames(block, "regions",
                              "by region: those that the values are of, each with a block of its own; the first that "
                              "holds a place counts",
                              field->kind == MPM_GROUND_REGION ? MPM_REQUIRED : MPM_OPTIONAL, count, names));
    if (!MpmOptionsHelp()) PetscCall(ReadRegions(block, *count, *names, field));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of a file by the names of the block: each must be there once. */
static PetscErrorCode MatchNames(const MpmOptions *block, const char path[], const MpmGroundTable *table,
                                 PetscInt count, char *const names[], MpmGround *field)
{
  PetscFunctionBeginUser;
  for (PetscInt r = 0; r < table->rows; r++) {
    PetscInt k = 0;

    while (k < count && strcmp(names[k], table->names[r])) k++;
    MpmCheckInput(k < count, "-%sfile %s: %s is none of the %s", block->prefix, path, table->names[r],
                  field->kind == MPM_GROUND_BODY ? "bodies" : "regions");
  }
  for (PetscInt k = 0; k < count; k++) {
    PetscInt found = 0;

    for (PetscInt r = 0; r < table->rows; r++) {
      if (strcmp(names[k], table->names[r])) continue;
      field->value[k] = table->value[r];
      found++;
    }
    MpmCheckInput(found == 1, "-%sfile %s: %s must be there once", block->prefix, path, names[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The table of the file, into the field. */
static PetscErrorCode TakeFile(const MpmOptions *block, const char path[], MpmGroundTable *table, MpmGround *field)
{
  const PetscBool named = (PetscBool)(field->kind == MPM_GROUND_BODY || field->kind == MPM_GROUND_REGION);
  char            message[MPM_GROUND_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmGroundTableRead(path, field->parameter, field->dim, named, table, message));
  MpmCheckInput(!message[0], "-%sfile %s: %s", block->prefix, path, message);
  if (named && field->names) PetscFunctionReturn(MatchNames(block, path, table, field->count, field->names, field));
  if (field->kind == MPM_GROUND_CELL) PetscCall(TakeCells(block, path, table, field));
  if (field->kind == MPM_GROUND_PILOTS) PetscCall(TakePilots(block, path, table, field));
  if (field->kind == MPM_GROUND_POINT) PetscCall(SortById(table));
  field->count = table->rows;
  field->value = table->value;
  field->names = table->names;
  table->value = NULL;
  table->names = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A field by cell without a file: all cells of the grid, x fastest. */
static PetscErrorCode TakeAllCells(const MpmOptions *block, PetscInt count, const PetscReal values[], MpmGround *field)
{
  MpmGroundTable table = {.rows = CountCells(&field->grid)};

  PetscFunctionBeginUser;
  MpmCheckInput(count == 1 || count == table.rows,
                "-%svalues: there are %" PetscInt_FMT ", must be one, or %" PetscInt_FMT
                ", one for each cell of the grid",
                block->prefix, count, table.rows);
  PetscCall(TakeCells(block, "", &table, field));
  field->count = table.rows;
  PetscCall(PetscMalloc1(field->count, &field->value));
  for (PetscInt k = 0; k < field->count; k++) field->value[k] = values[count > 1 ? k : 0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of the block, in the place of those of the file. */
static PetscErrorCode ReadValues(const MpmOptions *block, const char path[], MpmGround *field)
{
  PetscInt   count;
  PetscReal *values;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsRealList(block, "values", "",
                       "in the place of the file's, in its order, or that of the names; by cell without a file: "
                       "one for all cells, or one each, x fastest",
                       MPM_OPTIONAL, &count, &values));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(values));
  MpmCheckInput(values || path, "-%sfile is missing: or values", block->prefix);
  if (values && !field->value && field->kind == MPM_GROUND_CELL) PetscCall(TakeAllCells(block, count, values, field));
  else
    MpmCheckInput(!values || count == field->count, "-%svalues: there are %" PetscInt_FMT ", must be %" PetscInt_FMT,
                  block->prefix, count, field->count);
  if (values && count == field->count) PetscCall(PetscArraycpy(field->value, values, count));
  PetscCall(PetscFree(values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Correlation length, one or one an axis. */
static PetscErrorCode ReadLength(const MpmOptions *block, MpmGround *field)
{
  PetscInt   count;
  PetscReal *length;

  PetscFunctionBeginUser;
  if (field->kind != MPM_GROUND_PILOTS && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsRealList(block, "length", "m", "pilots: correlation length, one or one an axis", MPM_REQUIRED,
                               &count, &length));
  PetscCall(MpmOptionsBool(block, "log", "pilots: logarithms are interpolated; by default where the number must be > 0",
                           &field->pilots.log, &field->pilots.log_given));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(length));
  MpmCheckInput(count == 1 || count == field->dim,
                "-%slength has %" PetscInt_FMT " numbers: must be one, or one an axis", block->prefix, count);
  for (PetscInt a = 0; a < field->dim; a++) {
    field->pilots.length[a] = length[PetscMin(a, count - 1)];
    MpmCheckInput(field->pilots.length[a] > 0. && field->pilots.length[a] < PETSC_INFINITY, "-%slength: must be > 0 m",
                  block->prefix);
  }
  PetscCall(PetscFree(length));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOne(const MpmOptions *options, const char name[], const MpmGroundGrid *grid, MpmGround *field)
{
  static const char *const kinds[] = {"body", "region", "cell", "point", "pilots", NULL};
  char                     prefix[256], *path;
  const MpmOptions         block = {options->comm, prefix, options->record};
  PetscInt                 kind  = 0;
  MpmGroundTable           table = {0};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_field_%s_", name));
  PetscCall(MpmOptionsHeading(&block, "Field: a number of a material from place to place"));
  PetscCall(ReadOf(&block, field));
  PetscCall(MpmOptionsWord(&block, "by", "places that have a value each, or points between which it is interpolated",
                           kinds, MPM_REQUIRED, &kind, NULL));
  field->kind = (MpmGroundKind)kind;
  field->dim  = grid->dim;
  field->grid = *grid;
  PetscCall(ReadNames(&block, &field->count, &field->names, field));
  if (field->names) PetscCall(PetscCalloc1(field->count, &field->value));
  PetscCall(MpmOptionsPath(&block, "file", "CSV or HDF5 file of the values", MPM_OPTIONAL, &path));
  MpmCheckInput(path || field->names || field->kind == MPM_GROUND_CELL || MpmOptionsHelp(), "-%sfile is missing",
                prefix);
  if (path && !MpmOptionsHelp()) PetscCall(TakeFile(&block, path, &table, field));
  PetscCall(ReadValues(&block, path, field));
  PetscCall(ReadLength(&block, field));
  PetscCall(MpmGroundTableDestroy(&table));
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two fields of one number. */
static PetscErrorCode CheckAlike(const MpmGround *field, const MpmGround *other)
{
  PetscFunctionBeginUser;
  MpmCheckInput(strcmp(field->material, other->material) || strcmp(field->parameter, other->parameter),
                "-mpm_field_%s_of %s.%s: is that of field %s, too", field->name, field->material, field->parameter,
                other->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundsRead(const MpmOptions *options, const MpmGroundGrid *grid, MpmGrounds **fields)
{
  MpmGrounds *made;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&made));
  *fields = made;
  PetscCall(MpmOptionsBlocks(options, "fields", "names of numbers of materials that differ from place to place",
                             MPM_OPTIONAL, &made->count, &made->names));
  PetscCall(PetscCalloc1(made->count, &made->at));
  for (PetscInt f = 0; f < made->count; f++) {
    made->at[f].name = made->names[f];
    PetscCall(ReadOne(options, made->names[f], grid, &made->at[f]));
    for (PetscInt e = 0; e < f && !MpmOptionsHelp(); e++) PetscCall(CheckAlike(&made->at[f], &made->at[e]));
  }
  if (!made->count || MpmOptionsHelp()) PetscCall(MpmGroundsDestroy(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the number that a field replaces ---- */

PetscErrorCode MpmGroundTake(const MpmParameter *parameter, MpmGround *field)
{
  const MpmRange range = {parameter->lower, parameter->upper, (PetscBool)(parameter->open != 0)};
  char           accepted[MPM_RANGE_TEXT], must[MPM_MUST_TEXT], text[MPM_NUMBER_TEXT];
  PetscReal     *z;

  PetscFunctionBeginUser;
  field->used = PETSC_TRUE;
  MpmRangeText(range, accepted);
  MpmMustText(accepted[0] ? accepted : "a finite number", parameter->unit, must);
  for (PetscInt k = 0; k < field->count; k++) {
    MpmRealText(field->value[k], text);
    MpmCheckInput(MpmRangeHolds(range, field->value[k]) && PetscAbsReal(field->value[k]) < PETSC_INFINITY,
                  "-mpm_field_%s_of %s.%s: the value %s %s", field->name, field->material, field->parameter, text,
                  must);
  }
  if (field->kind != MPM_GROUND_PILOTS || field->pilots.kriging) PetscFunctionReturn(PETSC_SUCCESS);
  if (!field->pilots.log_given) field->pilots.log = (PetscBool)(parameter->lower >= 0. && parameter->open);
  PetscCall(PetscMalloc1(field->count, &z));
  PetscCall(PetscMalloc1(field->count + 1, &field->pilots.coefficient));
  for (PetscInt k = 0; k < field->count; k++) {
    MpmCheckInput(!field->pilots.log || field->value[k] > 0., "-mpm_field_%s_log true: all values must be > 0",
                  field->name);
    z[k] = field->pilots.log ? PetscLogReal(field->value[k]) : field->value[k];
  }
  PetscCall(MpmKrigingCreate(field->dim, field->count, field->at, field->pilots.length, &field->pilots.kriging));
  PetscCall(MpmKrigingFit(field->pilots.kriging, z, field->pilots.coefficient));
  PetscCall(PetscFree(z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundsCheckMaterials(const MpmGrounds *fields, PetscInt count, char *const names[])
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; fields && f < fields->count; f++) {
    PetscInt m = 0;

    while (m < count && strcmp(names[m], fields->at[f].material)) m++;
    MpmCheckInput(m < count, "-mpm_field_%s_of %s.%s: there is no material of this name", fields->at[f].name,
                  fields->at[f].material, fields->at[f].parameter);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundsCheckUsed(const MpmGrounds *fields)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; fields && f < fields->count; f++)
    MpmCheckInput(fields->at[f].used, "-mpm_field_%s_of %s.%s: the material has no number of this name",
                  fields->at[f].name, fields->at[f].material, fields->at[f].parameter);
  PetscFunctionReturn(PETSC_SUCCESS);
}
