/*
  Parameters by height or by a field.

    E: "0:5e6,10:20e6"      height:value, straight between, constant beyond; two pairs at one height make a jump
    E: stiffness.csv        columns height, E; or x, y (, z), E: rows that fill a lattice are interpolated linearly in
                            each axis, scattered ones act where they are nearest

  Heights are coordinates up gravity's axis. A file's last column may be called `value`.
*/
#include <math.h>
#include <stdlib.h>
#include "options/database.h"
#include "options/options.h"
#include "files/csv_table.h"
#include "ground/ground.h"
#include "point/parameter.h"
#include "point/variation.h"

/* ---- reading ---- */

/* Fault of a value, or NULL. */
static const char *WrongValue(const MpmParameter *parameter, PetscReal value, char text[MPM_MUST_TEXT])
{
  const MpmRange range = {parameter->lower, parameter->upper, (PetscBool)(parameter->open != 0)};
  char           accepted[MPM_RANGE_TEXT];

  if (MpmRangeHolds(range, value) && PetscAbsReal(value) < PETSC_INFINITY) return NULL;
  MpmRangeText(range, accepted);
  MpmMustText(accepted[0] ? accepted : "a finite number", parameter->unit, text);
  return text;
}

/* height:value pairs; returns their fault, or NULL. */
static const char *ParsePairs(PetscInt count, char **pair, MpmVariation *variation)
{
  for (PetscInt k = 0; k < count; k++) {
    char *colon = strchr(pair[k], ':');

    if (!colon) return "must be a number, or height:value pairs, separated by commas";
    *colon = '\0';
    if (!MpmParseReal(pair[k], &variation->at[k]) || !MpmParseReal(colon + 1, &variation->value[k]))
      return "must be height:value pairs of numbers";
    if (k && variation->at[k] < variation->at[k - 1]) return "heights must not decrease";
  }
  return count > 1 ? NULL : "two heights are wanted at least, or one number without";
}

/* Order of rows by their places, the last axis first; equal ones stay apart by nothing. */
static int CompareRows(const void *a, const void *b)
{
  const PetscReal *x = (const PetscReal *)a, *y = (const PetscReal *)b;

  for (PetscInt k = MPM_MAX_DIM - 1; k >= 0; k--)
    if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
  return 0;
}

static int CompareFirst(const void *a, const void *b)
{
  const PetscReal *x = (const PetscReal *)a, *y = (const PetscReal *)b;

  return x[0] < y[0] ? -1 : x[0] > y[0];
}

/* The distinct coordinates of sorted rows along an axis; returns how many. */
static PetscErrorCode FindLine(PetscInt count, const PetscReal rows[], PetscInt axis, MpmVariation *variation)
{
  PetscReal *line;
  PetscInt   n = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &line));
  for (PetscInt k = 0; k < count; k++) line[k] = rows[k * (MPM_MAX_DIM + 1) + axis];
  PetscCall(PetscSortReal(count, line));
  for (PetscInt k = 0; k < count; k++)
    if (!n || line[k] > line[n - 1]) line[n++] = line[k];
  variation->line[axis]  = line;
  variation->nodes[axis] = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of x, y, z, value, sorted: a lattice where each of its nodes has one, otherwise scattered places. Two rows at
   one place are a fault. */
static PetscErrorCode TakeField(PetscInt count, PetscReal rows[], MpmVariation *variation,
                                char message[MPM_CSV_MESSAGE])
{
  const size_t row     = MPM_MAX_DIM + 1;
  PetscInt64   product = 1;
  PetscBool    lattice;

  PetscFunctionBeginUser;
  qsort(rows, (size_t)count, row * sizeof(*rows), CompareRows);
  for (PetscInt k = 1; k < count; k++) {
    const PetscReal *at = &rows[(size_t)k * row];
    char             x[MPM_NUMBER_TEXT], y[MPM_NUMBER_TEXT];

    if (CompareRows(at, at - row)) continue;
    MpmRealText(at[0], x);
    MpmRealText(at[1], y);
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "two rows are at one place: x %s, y %s", x, y));
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscCall(FindLine(count, rows, a, variation));
    product *= variation->nodes[a];
  }
  lattice = (PetscBool)(product == count);
  for (PetscInt k = 0; lattice && k < count; k++) {
    PetscInt rest = k;

    for (PetscInt a = 0; a < MPM_MAX_DIM; rest /= variation->nodes[a++])
      lattice =
        (PetscBool)(lattice && rows[(size_t)k * row + (size_t)a] == variation->line[a][rest % variation->nodes[a]]);
  }
  if (!lattice) {
    qsort(rows, (size_t)count, row * sizeof(*rows), CompareFirst);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) variation->nodes[a] = 0;
  }
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) variation->at[k * MPM_MAX_DIM + a] = rows[(size_t)k * row + (size_t)a];
    variation->value[k] = rows[(size_t)k * row + MPM_MAX_DIM];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of a file; a fault goes into `message`. */
static PetscErrorCode TakeFile(const char path[], const MpmParameter *parameter, PetscInt dim, MpmVariation *variation,
                               char message[MPM_CSV_MESSAGE])
{
  static const char *const axes[] = {"x", "y", "z"};
  MpmCsvTable              table  = {0};
  PetscInt                 height, value, column[MPM_MAX_DIM] = {-1, -1, -1};
  PetscReal               *rows;
  PetscBool                field = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path, &table, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  height = MpmCsvTableFind(&table, "height");
  value  = MpmCsvTableFind(&table, parameter->name);
  if (value < 0) value = MpmCsvTableFind(&table, "value");
  for (PetscInt a = 0; a < dim; a++) {
    column[a] = MpmCsvTableFind(&table, axes[a]);
    field     = (PetscBool)(field && column[a] >= 0);
  }
  if (value < 0 || (height < 0) == !field || table.rows < 2) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                            "must have the columns height and %s, or x, y%s and %s, and two rows at least",
                            parameter->name, dim == 3 ? ", z" : "", parameter->name));
    PetscCall(MpmCsvTableNames(&table, message));
  }
  for (PetscInt a = 0; a < dim && field && !message[0]; a++) PetscCall(MpmCsvTableFinite(&table, column[a], message));
  if (!field && !message[0]) PetscCall(MpmCsvTableFinite(&table, height, message));
  if (message[0]) PetscFunctionReturn(MpmCsvTableDestroy(&table));
  variation->count = (PetscInt)table.rows;
  variation->dim   = field ? dim : 0;
  PetscCall(PetscMalloc1(table.rows * MPM_MAX_DIM, &variation->at));
  PetscCall(PetscMalloc1(table.rows, &variation->value));
  PetscCall(PetscCalloc1(table.rows * (MPM_MAX_DIM + 1), &rows));
  for (PetscInt64 k = 0; k < table.rows; k++) {
    const PetscReal *row = &table.value[k * table.columns];

    for (PetscInt a = 0; field && a < dim; a++) rows[k * (MPM_MAX_DIM + 1) + a] = row[column[a]];
    if (!field) variation->at[k] = row[height];
    rows[k * (MPM_MAX_DIM + 1) + MPM_MAX_DIM] = variation->value[k] = row[value];
    if (!field && k && variation->at[k] < variation->at[k - 1])
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "heights must not decrease"));
  }
  if (field) PetscCall(TakeField(variation->count, rows, variation, message));
  PetscCall(PetscFree(rows));
  PetscCall(MpmCsvTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the text is a file's name: a number has neither a folder nor such an ending. */
static PetscBool IsFile(const char text[])
{
  const char *dot = strrchr(text, '.');

  return (PetscBool)(strchr(text, '/') ||
                     (dot && (!strcmp(dot, ".csv") || !strcmp(dot, ".txt") || !strcmp(dot, ".dat"))));
}

/* A field of the scene; a number that the material has, too, is read and has no meaning. */
static PetscErrorCode TakeGround(const MpmOptions *block, MpmGround *ground, const MpmParameter *parameter,
                                 MpmVariation *variation)
{
  MpmLawTable unused;
  double      number;
  PetscBool   has;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, parameter->name, &has));
  if (has && parameter->kind != MPM_AXES) PetscCall(MpmParameterRead(block, parameter, &number, &unused));
  PetscCall(MpmGroundTake(parameter, ground));
  variation->ground = ground;
  variation->count  = ground->count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVariationRead(const MpmOptions *block, MpmGround *ground, const MpmParameter *parameter, PetscInt dim,
                                MpmVariation *variation)
{
  const MpmOptions silent = {block->comm, block->prefix, NULL};
  char *text, *quoted, **pair, *help = NULL, must[MPM_MUST_TEXT], message[MPM_CSV_MESSAGE] = "", at[MPM_NUMBER_TEXT];
  const char *wrong = NULL;
  PetscInt    count;
  PetscBool   by_height, has;

  PetscFunctionBeginUser;
  if (ground && !MpmOptionsHelp()) PetscFunctionReturn(TakeGround(block, ground, parameter, variation));
  PetscCall(MpmOptionsHas(&silent, parameter->name, &has));
  if (!has || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsText(&silent, parameter->name, parameter->help, NULL, MPM_OPTIONAL, &text));
  by_height = (PetscBool)(strchr(text, ':') != NULL);
  if (!by_height && !IsFile(text)) PetscFunctionReturn(PetscFree(text));
  PetscCall(PetscFree(text));
  PetscCall(MpmTextAppend(&help, "%s (%s)", parameter->help, parameter->unit));
  PetscCall(MpmOptionsText(block, parameter->name, help, NULL, MPM_OPTIONAL, &text));
  PetscCall(MpmTextQuote(text, &quoted));
  if (by_height) {
    PetscCall(MpmTextSplit(text, &count, &pair));
    variation->count = count;
    PetscCall(PetscMalloc1(count + 1, &variation->at));
    PetscCall(PetscMalloc1(count + 1, &variation->value));
    wrong = ParsePairs(count, pair, variation);
    PetscCall(MpmNamesDestroy(count, &pair));
  } else {
    PetscCall(TakeFile(text, parameter, dim, variation, message));
    wrong = message[0] ? message : NULL;
  }
  MpmCheckInput(!wrong, "-%s%s %s: %s", block->prefix, parameter->name, quoted, wrong);
  for (PetscInt k = 0; k < variation->count; k++) {
    MpmRealText(variation->value[k], at);
    wrong = WrongValue(parameter, variation->value[k], must);
    MpmCheckInput(!wrong, "-%s%s %s: the value %s %s", block->prefix, parameter->name, quoted, at, wrong);
  }
  PetscCall(PetscFree(quoted));
  PetscCall(PetscFree(text));
  PetscCall(PetscFree(help));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVariationCopy(const MpmVariation *from, MpmVariation *to)
{
  const PetscInt wide = from->dim ? MPM_MAX_DIM : 1;

  PetscFunctionBeginUser;
  *to = *from;
  if (from->ground) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((size_t)(from->count * wide), &to->at));
  PetscCall(PetscMalloc1(from->count, &to->value));
  PetscCall(PetscArraycpy(to->at, from->at, (size_t)(from->count * wide)));
  PetscCall(PetscArraycpy(to->value, from->value, from->count));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (!from->line[a]) continue;
    PetscCall(PetscMalloc1(from->count, &to->line[a]));
    PetscCall(PetscArraycpy(to->line[a], from->line[a], PetscMax(from->nodes[a], 1)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVariationDestroy(MpmVariation *variation)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(variation->at));
  PetscCall(PetscFree(variation->value));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(variation->line[a]));
  variation->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- values ---- */

void MpmVariationBounds(const MpmVariation *variation, PetscReal *least, PetscReal *most)
{
  if (variation->ground) {
    MpmGroundBounds(variation->ground, least, most);
    return;
  }
  *least = *most = variation->value[0];
  for (PetscInt k = 1; k < variation->count; k++) {
    *least = PetscMin(*least, variation->value[k]);
    *most  = PetscMax(*most, variation->value[k]);
  }
}

/* The segment of an ascending line that holds x, of two equal ends the later one, and the part of the way along it. */
static PetscInt Segment(PetscInt n, const PetscReal line[], PetscReal x, PetscReal *part)
{
  PetscInt low = 0, high = n - 1;

  *part = 0.;
  if (n == 1 || !(x > line[0])) return 0;
  if (x >= line[n - 1]) {
    *part = 1.;
    return n - 2;
  }
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;

    if (line[middle] <= x) low = middle;
    else high = middle;
  }
  *part = (x - line[low]) / (line[high] - line[low]);
  return low;
}

static PetscReal ByHeight(const MpmVariation *variation, PetscReal height)
{
  PetscReal      part;
  const PetscInt k = Segment(variation->count, variation->at, height, &part);

  if (part <= 0. || part >= 1.) return variation->value[part >= 1. ? k + 1 : k];
  return variation->value[k] + part * (variation->value[k + 1] - variation->value[k]);
}

static PetscReal OnLattice(const MpmVariation *variation, const PetscReal x[])
{
  PetscInt  first[MPM_MAX_DIM];
  PetscReal part[MPM_MAX_DIM], sum = 0.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    first[a] = Segment(variation->nodes[a], variation->line[a], a < variation->dim ? x[a] : 0., &part[a]);
  for (PetscInt corner = 0; corner < 1 << MPM_MAX_DIM; corner++) {
    PetscReal weight = 1.;
    PetscInt  k      = 0;

    for (PetscInt a = MPM_MAX_DIM - 1; a >= 0; a--) {
      const PetscInt far = (corner >> a) & 1;

      weight *= far ? part[a] : 1. - part[a];
      k = k * variation->nodes[a] + PetscMin(first[a] + far, variation->nodes[a] - 1);
    }
    if (weight != 0.) sum += weight * variation->value[k];
  }
  return sum;
}

/* From the place beside x in the order of the first coordinates outwards, until that distance alone exceeds the
   nearest. */
static PetscReal Nearest(const MpmVariation *variation, const PetscReal x[])
{
  PetscInt  low = 0, high = variation->count, best = 0;
  PetscReal square = PETSC_INFINITY;

  while (low < high) {
    const PetscInt middle = (low + high) / 2;

    if (variation->at[middle * MPM_MAX_DIM] < x[0]) low = middle + 1;
    else high = middle;
  }
  for (PetscInt way = 0; way < 2; way++) {
    for (PetscInt k = way ? low : low - 1; k >= 0 && k < variation->count; k += way ? 1 : -1) {
      PetscReal distance = 0.;

      if (PetscSqr(variation->at[k * MPM_MAX_DIM] - x[0]) > square) break;
      for (PetscInt a = 0; a < variation->dim; a++) distance += PetscSqr(variation->at[k * MPM_MAX_DIM + a] - x[a]);
      if (distance >= square) continue;
      square = distance;
      best   = k;
    }
  }
  return variation->value[best];
}

PetscReal MpmVariationEvaluate(const MpmVariation *variation, const MpmPlace *place)
{
  if (variation->ground) return MpmGroundEvaluate(variation->ground, place->x, place->id);
  if (!variation->dim) return ByHeight(variation, place->height);
  return variation->nodes[0] ? OnLattice(variation, place->x) : Nearest(variation, place->x);
}
