/*
  Labels and the names of materials that they stand for: "0:none,1:binder,2-900:grain".
*/
#include <ctype.h>
#include <string.h>
#include "options/options.h"
#include "voxels/labels.h"

#define NOTHING "none"

/* One entry of the list, "2-900:grain". */
static PetscErrorCode ReadRange(const MpmOptions *options, char *text, MpmLabelRange *range)
{
  char *colon = strchr(text, ':'), *end = text;
  long  first = 0, last = 0;

  PetscFunctionBegin;
  while (isspace((unsigned char)*text)) text++;
  if (colon) {
    first = last = strtol(text, &end, 10);
    if (end > text && *end == '-' && isdigit((unsigned char)end[1])) last = strtol(end + 1, &end, 10);
  }
  MpmCheckInput(
    colon && end == colon && end > text && colon[1] && first <= last && first >= -1000000000L && last <= 1000000000L,
    "-%slabels %s: must be entries like 0:none, 1:binder or 2-900:grain, separated by commas", options->prefix, text);
  range->first = (PetscInt)first;
  range->last  = (PetscInt)last;
  range->value = -1;
  PetscCall(PetscStrallocpy(colon + 1, &range->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLabelsRead(const MpmOptions *options, const char *help, PetscBool required, MpmLabels *labels)
{
  char *text, *rest;

  PetscFunctionBegin;
  PetscCall(MpmOptionsText(options, "labels", help, NULL, required ? MPM_REQUIRED : MPM_OPTIONAL, &text));
  rest = text;
  for (char *entry; text && !MpmOptionsHelp() && (entry = strsep(&rest, ","));) {
    PetscCall(PetscRealloc((size_t)(labels->count + 1) * sizeof(*labels->range), &labels->range));
    labels->range[labels->count] = (MpmLabelRange){0, 0, 0, NULL, PETSC_FALSE};
    PetscCall(ReadRange(options, entry, &labels->range[labels->count]));
    labels->count++;
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLabelsDestroy(MpmLabels *labels)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < labels->count; k++) PetscCall(PetscFree(labels->range[k].name));
  PetscCall(PetscFree(labels->range));
  labels->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmLabelsFind(const MpmLabels *labels, PetscInt label)
{
  for (PetscInt k = 0; k < labels->count; k++)
    if (label >= labels->range[k].first && label <= labels->range[k].last) return k;
  return -1;
}

/* Two entries with other materials must have no label in common. */
static PetscErrorCode CheckApart(const MpmOptions *options, const MpmLabels *labels)
{
  PetscFunctionBegin;
  for (PetscInt r = 0; r < labels->count; r++)
    for (PetscInt k = 0; k < r; k++) {
      const MpmLabelRange *a = &labels->range[k], *b = &labels->range[r];
      const PetscInt       first = PetscMax(a->first, b->first);

      MpmCheckInput(a->value == b->value || first > PetscMin(a->last, b->last),
                    "-%slabels: the label %" PetscInt_FMT " is of %s and of %s: must be of one", options->prefix, first,
                    a->name, b->name);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLabelsNumber(const MpmOptions *options, PetscInt count, const char *const names[], MpmLabels *labels)
{
  PetscFunctionBegin;
  for (PetscInt r = 0; r < labels->count; r++) {
    MpmLabelRange *range = &labels->range[r];

    for (PetscInt m = 0; m < count && range->value < 0; m++)
      if (!strcmp(range->name, names[m])) range->value = m;
    MpmCheckInput(range->value >= 0 || !strcmp(range->name, NOTHING),
                  "-%slabels: %s is none of -mpm_materials, nor the word none", options->prefix, range->name);
  }
  PetscCall(CheckApart(options, labels));
  PetscFunctionReturn(PETSC_SUCCESS);
}
