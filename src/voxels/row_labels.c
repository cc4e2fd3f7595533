/*
  Materials of the points of a file, by its column or dataset `material`.

    material       in the body's block: of all its points; the column then only chooses rows
    file_material  with it, only the points whose number in the column is this one
    labels         without it, names by numbers of the column: "0:none,1:binder,2-900:grain"; none: no point

  Without `material` and `labels` a cell is a name, or the place of a material in -mpm_materials, from 0 on, as runs
  write it.
*/
#include <string.h>
#include "options/options.h"
#include "voxels/labels.h"
#include "voxels/row_labels.h"

#define NO_NUMBER (-2000000000.) /* of a cell with the body's own name */

typedef struct {
  const MpmOptions   *block;
  const char         *path;
  const MpmRowChoice *materials;
  MpmLabels           labels;
  PetscInt            wanted; /* file_material, or -1 */
} Column;

/* Material of a number, -1: no point. `fault`, where the number has none, says why. */
static PetscInt OfNumber(const Column *column, PetscReal number, const char **fault)
{
  PetscInt place;

  if (!(PetscAbsReal(number) <= 1e9) || number != PetscFloorReal(number)) {
    *fault = "must be a whole number, or in a table a name";
    return -1;
  }
  place = column->labels.count ? MpmLabelsFind(&column->labels, (PetscInt)number) : (PetscInt)number;
  if (column->labels.count && place >= 0) return column->labels.range[place].value;
  if (!column->labels.count && place >= 0 && place < column->materials->count) return place;
  *fault = column->labels.count ? "is in no entry of labels; an entry with none leaves such points out"
                                : "is no place in -mpm_materials, from 0 on: labels name numbers";
  return -1;
}

static PetscInt OfName(const Column *column, const char name[])
{
  for (PetscInt m = 0; m < column->materials->count; m++)
    if (!strcmp(column->materials->names[m], name)) return m;
  return -1;
}

/* A word that is a number as a whole. */
static PetscBool IsNumber(const char word[], PetscReal *number)
{
  char *end;

  *number = (PetscReal)strtod(word, &end);
  return (PetscBool)(end > word && !*end);
}

/* Materials of the words of a table. */
static PetscErrorCode OfWords(const Column *column, PetscInt count, char *const word[], PetscInt of_word[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    const char *fault = NULL;
    PetscReal   number;

    of_word[k] = column->labels.count ? -1 : OfName(column, word[k]);
    if (of_word[k] >= 0) continue;
    if (IsNumber(word[k], &number)) of_word[k] = OfNumber(column, number, &fault);
    else fault = column->labels.count ? "must be a whole number, as labels has them" : "is none of -mpm_materials";
    MpmCheckInput(!fault, "-%sfile %s: material %.60s %s", column->block->prefix, column->path, word[k], fault);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Each row's material by the column; the least number at fault on any rank ends the run. */
static PetscErrorCode TakeColumn(const Column *column, PetscInt count, const PetscReal value[], PetscInt words,
                                 char *const word[], PetscInt row[])
{
  PetscReal   worst = PETSC_MAX_REAL;
  const char *fault = NULL;
  char        text[MPM_NUMBER_TEXT];
  PetscInt   *of_word;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(words + 1, &of_word));
  PetscCall(OfWords(column, words, word, of_word));
  for (PetscInt p = 0; p < count; p++) {
    const char *wrong = NULL;

    row[p] = words ? of_word[(PetscInt)value[p]] : OfNumber(column, value[p], &wrong);
    if (wrong) worst = PetscMin(worst, value[p]);
    if (row[p] >= 0) column->materials->has[row[p]] = PETSC_TRUE;
  }
  PetscCall(PetscFree(of_word));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPI_MIN, column->block->comm));
  if (worst < PETSC_MAX_REAL) (void)OfNumber(column, worst, &fault);
  MpmRealText(worst, text);
  MpmCheckInput(!fault, "-%sfile %s: material %s %s", column->block->prefix, column->path, text, fault);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, column->materials->has, (PetscMPIInt)column->materials->count, MPM_MPI_BOOL,
                             MPI_LOR, column->block->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of the body's own material: all, or those of one number. Several numbers need a choice. */
static PetscErrorCode ChooseRows(const Column *column, PetscInt count, const PetscReal value[], PetscInt words,
                                 char *const word[], PetscInt row[])
{
  const char *own     = column->materials->names[column->materials->own];
  PetscReal   ends[2] = {PETSC_NINFINITY, PETSC_NINFINITY}, *number;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(words + 1, &number));
  for (PetscInt k = 0; k < words; k++) {
    const PetscBool named = (PetscBool)!strcmp(word[k], own);

    MpmCheckInput(IsNumber(word[k], &number[k]) || named,
                  "-%smaterial %s: %s has the material %.60s; without the option each point has its own",
                  column->block->prefix, own, column->path, word[k]);
    if (named) number[k] = NO_NUMBER;
  }
  for (PetscInt p = 0; p < count; p++) {
    const PetscReal here = words ? number[(PetscInt)value[p]] : value[p];

    ends[0] = PetscMax(ends[0], -here);
    ends[1] = PetscMax(ends[1], here);
    row[p]  = column->wanted < 0 || here == (PetscReal)column->wanted ? column->materials->own : -1;
  }
  PetscCall(PetscFree(number));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_REAL, MPI_MAX, column->block->comm));
  MpmCheckInput(
    column->wanted >= 0 || -ends[0] >= ends[1],
    "-%sfile_material is missing: %s has points of the materials %lld to %lld; without -%smaterial each has "
    "its own",
    column->block->prefix, column->path, (long long)-ends[0], (long long)ends[1], column->block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOptions(Column *column)
{
  const MpmOptions *block = column->block;
  const PetscBool   own   = (PetscBool)(column->materials->own >= 0);

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsInt(block, "file_material", "take only the points of this `material` of the file", 0,
                          PETSC_MAX_INT, MPM_OPTIONAL, &column->wanted, NULL));
  PetscCall(MpmLabelsRead(block,
                          "region file, without material: materials by the file's numbers `material`, "
                          "\"0:none,1:binder,2-900:grain\"; none: no points. Without labels too: names, or places in "
                          "-mpm_materials from 0 on",
                          PETSC_FALSE, &column->labels));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(own || column->wanted < 0, "-%sfile_material: needs -%smaterial; without it each point has its own",
                block->prefix, block->prefix);
  MpmCheckInput(!own || !column->labels.count, "-%slabels: not with -%smaterial, which all points have", block->prefix,
                block->prefix);
  PetscCall(MpmLabelsNumber(block, column->materials->count, column->materials->names, &column->labels));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRowLabelsRead(const MpmOptions *block, const char path[], MpmPointFile file,
                                const MpmRowChoice *materials, PetscInt **row)
{
  Column     column = {.block = block, .path = path, .materials = materials, .wanted = -1};
  PetscReal *value  = NULL;
  PetscInt   words  = 0;
  char     **word   = NULL;

  PetscFunctionBeginUser;
  *row = NULL;
  PetscCall(ReadOptions(&column));
  if (!MpmOptionsHelp()) PetscCall(MpmPointFileGetMaterial(file, &words, &word, &value));
  MpmCheckInput(value || materials->own >= 0 || MpmOptionsHelp(),
                "-%smaterial is missing: must be one of -mpm_materials, or %s must have a column `material`",
                block->prefix, path);
  MpmCheckInput(value || column.wanted < 0 || MpmOptionsHelp(), "-%sfile_material: there is no `material` in %s",
                block->prefix, path);
  if (value) {
    PetscCall(PetscMalloc1(MpmPointFileCount(file) + 1, row));
    PetscCall(
      (materials->own < 0 ? TakeColumn : ChooseRows)(&column, MpmPointFileCount(file), value, words, word, *row));
  }
  PetscCall(PetscFree(value));
  PetscCall(MpmLabelsDestroy(&column.labels));
  PetscFunctionReturn(PETSC_SUCCESS);
}
