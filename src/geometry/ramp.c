/*
  MpmRamp - a piecewise linear factor of time from "time:factor" pairs, constant before the first and after the last.

  Two pairs at one time make a jump; at that very time the later pair counts. So "0:0,1:0,1:1" is 0 until just before 1,
  and 1 at 1.
*/
#include "geometry/geometry.h"
#include "options/options.h"

#include <stdlib.h>
#include <string.h>

struct _p_MpmRamp {
  PetscInt   count;
  PetscReal *time, *factor;
};

/* Parses one pair in place; returns what is wrong with it, or NULL. */
static const char *ParsePair(MpmRamp ramp, char pair[])
{
  const PetscInt i     = ramp->count;
  char          *colon = strchr(pair, ':');

  if (!colon) return "must be time:factor pairs, separated by commas";
  *colon = '\0';
  if (!MpmParseReal(pair, &ramp->time[i]) || !MpmParseReal(colon + 1, &ramp->factor[i]))
    return "must be time:factor pairs of numbers";
  if (i && ramp->time[i] < ramp->time[i - 1]) return "times must not decrease";
  ramp->count++;
  return NULL;
}

static PetscErrorCode ParsePairs(MpmRamp ramp, const char text[], const char **wrong)
{
  PetscInt pairs = 1;
  char    *copy, *next;

  PetscFunctionBegin;
  *wrong = NULL;
  for (const char *c = text; *c; c++) pairs += (*c == ',');
  PetscCall(PetscMalloc2((size_t)pairs, &ramp->time, (size_t)pairs, &ramp->factor));
  PetscCall(PetscStrallocpy(text, &copy));
  for (char *pair = copy; pair && !*wrong; pair = next) {
    next = strchr(pair, ',');
    if (next) *next++ = '\0';
    *wrong = ParsePair(ramp, pair);
  }
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRampCreate(const MpmOptions *options, const char *name, const char *fallback, MpmRamp *ramp)
{
  MpmRamp     r;
  const char *wrong;
  char       *text, *quoted;

  PetscFunctionBegin;
  *ramp = NULL;
  PetscCall(MpmOptionsText(options, name, "factor over time, time:factor pairs (s:-)", fallback, MPM_OPTIONAL, &text));
  PetscCall(PetscNew(&r));
  PetscCall(ParsePairs(r, text ? text : "", &wrong));
  if (wrong) {
    PetscCall(MpmRampDestroy(&r));
    PetscCall(MpmTextQuote(text ? text : "", &quoted));
    MpmCheckInput(PETSC_FALSE, "-%s%s %s: %s", options->prefix ? options->prefix : "", name, quoted, wrong);
  }
  PetscCall(PetscFree(text));
  *ramp = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRampDestroy(MpmRamp *ramp)
{
  PetscFunctionBegin;
  if (!*ramp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree2((*ramp)->time, (*ramp)->factor));
  PetscCall(PetscFree(*ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmRampEvaluate(MpmRamp ramp, PetscReal time)
{
  PetscInt after = 0;

  while (after < ramp->count && ramp->time[after] <= time) after++;
  if (after == 0) return ramp->factor[0];
  if (after == ramp->count) return ramp->factor[after - 1];
  /* time[after - 1] <= time < time[after], so the difference is not zero */
  const PetscReal along = (time - ramp->time[after - 1]) / (ramp->time[after] - ramp->time[after - 1]);
  return (1. - along) * ramp->factor[after - 1] + along * ramp->factor[after];
}

void MpmRampBounds(MpmRamp ramp, PetscReal *least, PetscReal *most)
{
  *least = *most = ramp->factor[0];
  for (PetscInt k = 1; k < ramp->count; k++) {
    *least = PetscMin(*least, ramp->factor[k]);
    *most  = PetscMax(*most, ramp->factor[k]);
  }
}
