/*
  Initial history of a body's points:

    initial_specific_volume: "0:1.55,10:1.62"      height:value, linear between; or one number

  Heights are coordinates up gravity's axis. The pairs must reach from the lowest point to the highest; two at one
  height make a jump, where the later one counts. Where the law has a parameter of the variable's name, the values
  replace it: they must be in its range and agree with the other parameters.
*/
#include "options/options.h"
#include "point/material.h"
#include "point/parameter.h"
#include "particles/body_initial.h"

/* The values of one state variable by height; without heights one for all, with count 0 none. */
typedef struct {
  char      *option;
  PetscInt   count;
  PetscReal *height, *value;
  PetscReal  missed; /* the height of a point outside */
  PetscBool  misses;
} Profile;

struct _p_MpmBodyInitial {
  const MpmMaterial *material;
  Profile           *profile; /* by state variable */
};

/* Fault of the text, or NULL. */
static const char *ParsePairs(PetscInt count, char **pair, Profile *profile)
{
  if (count == 1 && !strchr(pair[0], ':')) {
    profile->count = 1;
    return MpmParseReal(pair[0], &profile->value[0]) ? NULL : "must be a number, or height:value pairs";
  }
  for (PetscInt k = 0; k < count; k++) {
    char *colon = strchr(pair[k], ':');

    if (!colon) return "must be a number, or height:value pairs, separated by commas";
    *colon = '\0';
    if (!MpmParseReal(pair[k], &profile->height[k]) || !MpmParseReal(colon + 1, &profile->value[k]))
      return "must be height:value pairs of numbers";
    if (k && profile->height[k] < profile->height[k - 1]) return "heights must not decrease";
  }
  profile->count = count;
  return count > 1 ? NULL : "two heights are wanted at least, or one number without";
}

static PetscErrorCode ReadProfile(const MpmOptions *block, const MpmStateVariable *variable, Profile *profile)
{
  char        name[128], *text, *quoted, **pair;
  const char *wrong;
  PetscInt    count;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, sizeof(name), "initial_%s", variable->name));
  PetscCall(MpmStateReadInitial(block, variable, &text));
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  PetscCall(MpmTextSplit(text, &count, &pair));
  PetscCall(PetscMalloc2((count + 1), &profile->height, (count + 1), &profile->value));
  wrong = count ? ParsePairs(count, pair, profile) : "must be a number, or height:value pairs";
  PetscCall(MpmNamesDestroy(count, &pair));
  PetscCall(MpmTextQuote(text, &quoted));
  MpmCheckInput(!wrong, "-%s%s %s: %s", block->prefix, name, quoted, wrong);
  PetscCall(PetscFree(quoted));
  PetscCall(PetscFree(text));
  PetscCall(MpmTextAppend(&profile->option, "-%s%s", block->prefix, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The values in the place of the law's parameter of the same name */
static PetscErrorCode CheckValues(const MpmMaterial *material, const char *name, const Profile *profile)
{
  char why[MPM_FAULT_TEXT], value[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < profile->count; k++) {
    if (!MpmMaterialIsFaultyWith(material, name, profile->value[k], why)) continue;
    MpmRealText(profile->value[k], value);
    MpmCheckInput(PETSC_FALSE, "%s: the value %s does not suit material %s: %s", profile->option, value, material->name,
                  why);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyInitialCreate(const MpmOptions *block, const MpmMaterial *material, MpmBodyInitial *initial)
{
  const MpmLawInfo *info = &material->info;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(initial));
  (*initial)->material = material;
  PetscCall(PetscCalloc1((PetscInt)info->state_count + 1, &(*initial)->profile));
  if (material->basal) PetscFunctionReturn(PETSC_SUCCESS); /* columns have the body's depth */
  for (size_t v = 0; v < info->state_count; v++)
    if (info->states[v].kind == MPM_STATE_SCALAR) {
      PetscCall(ReadProfile(block, &info->states[v], &(*initial)->profile[v]));
      PetscCall(CheckValues(material, info->states[v].name, &(*initial)->profile[v]));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyInitialDestroy(MpmBodyInitial *initial)
{
  PetscFunctionBeginUser;
  if (!*initial) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t v = 0; v < (*initial)->material->info.state_count; v++) {
    PetscCall(PetscFree((*initial)->profile[v].option));
    PetscCall(PetscFree2((*initial)->profile[v].height, (*initial)->profile[v].value));
  }
  PetscCall(PetscFree((*initial)->profile));
  PetscCall(PetscFree(*initial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Evaluate(Profile *profile, PetscReal height)
{
  const PetscReal *h = profile->height, *y = profile->value;
  const PetscInt   last  = profile->count - 1;
  PetscInt         after = 0;

  if (profile->count == 1) return y[0];
  if (!(height >= h[0] && height <= h[last])) {
    profile->misses = PETSC_TRUE;
    profile->missed = height;
  }
  while (after <= last && h[after] <= height) after++;
  if (after == 0) return y[0];
  if (after > last) return y[last];
  return y[after - 1] + (y[after] - y[after - 1]) * (height - h[after - 1]) / (h[after] - h[after - 1]);
}

void MpmBodyInitialFill(MpmBodyInitial initial, PetscInt dim, PetscReal height, PetscReal state[])
{
  for (size_t v = 0; v < initial->material->info.state_count; v++) {
    if (initial->profile[v].count) *state = Evaluate(&initial->profile[v], height);
    state += MpmStateComponents(&initial->material->info.states[v], dim);
  }
}

PetscErrorCode MpmBodyInitialCheck(MpmBodyInitial initial, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  for (size_t v = 0; v < initial->material->info.state_count; v++) {
    const Profile *profile = &initial->profile[v];
    PetscReal      missed  = profile->misses ? profile->missed : PETSC_NINFINITY;
    char           ends[2][MPM_NUMBER_TEXT], at[MPM_NUMBER_TEXT];

    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &missed, 1, MPIU_REAL, MPIU_MAX, comm));
    if (missed <= PETSC_NINFINITY) continue;
    MpmRealText(profile->height[0], ends[0]);
    MpmRealText(profile->height[profile->count - 1], ends[1]);
    MpmRealText(missed, at);
    MpmCheckInput(PETSC_FALSE, "%s: heights reach from %s to %s m, and there is a point at %s m", profile->option,
                  ends[0], ends[1], at);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
