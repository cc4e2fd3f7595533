/*
  Values of the members, and the options that have them.
*/
#include <string.h>
#include "base/random.h"
#include "options/database.h"
#include "ensemble/ensemble.h"

#define TERRAIN "-mpm_terrain_noise_seed"
#define STREAM  UINT64_C(0x7465727261696e) /* of the terrain's seeds */

/* Options of the ensemble: a member is a scene without them. */
static const char *const own[] = {"mpm_ensemble_", "mpm_draw_", NULL}, *const task = "mpm_task";
/* Options that change nothing in a member. */
static const char *const aside[] = {"mpm_ensemble_groups",
                                    "mpm_ensemble_restart",
                                    "mpm_ensemble_results",
                                    "mpm_ensemble_quantiles",
                                    "mpm_ensemble_thresholds",
                                    "mpm_quiet",
                                    "mpm_output_prefix",
                                    "options_left",
                                    "malloc_dump",
                                    "log_view",
                                    NULL};

PetscReal MpmDrawValue(const MpmEnsemble *ensemble, PetscInt draw, PetscInt member)
{
  return MpmDistributionQuantile(&ensemble->draws[draw].distribution,
                                 ensemble->shares[draw * ensemble->members + member]);
}

PetscInt MpmTerrainSeed(const MpmEnsemble *ensemble, PetscInt member)
{
  return 1 + (PetscInt)(MpmRandomBits((uint64_t)ensemble->seed, STREAM, (uint64_t)member) % 2147483646);
}

/* The scene's options but those aside, as one number that a double holds. */
static PetscErrorCode FindScene(PetscInt64 *scene)
{
  MpmDatabaseOption *options;
  MpmTextFile        all = MPM_TEXT_FILE_EMPTY;
  PetscInt           count;
  char              *text;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseGet(&count, &options, &text));
  PetscCall(MpmTextFileAppend(&all, "%s\n", MPM_VERSION));
  for (PetscInt k = 0; k < count; k++) {
    PetscInt a = 0;

    while (aside[a] && strcmp(aside[a], options[k].name)) a++;
    if (!aside[a])
      PetscCall(MpmTextFileAppend(&all, "%s %s\n", options[k].name, options[k].value ? options[k].value : ""));
  }
  *scene = (PetscInt64)(MpmHashBytes(all.data, all.length, 0) >> 11);
  PetscCall(MpmTextFileDestroy(&all));
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDrawsMake(MpmEnsemble *ensemble)
{
  uint64_t *streams;
  PetscBool positive;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ensemble->draw_count, &streams));
  PetscCall(PetscMalloc1((size_t)ensemble->draw_count * (size_t)ensemble->members, &ensemble->shares));
  for (PetscInt k = 0; k < ensemble->draw_count; k++)
    streams[k] = MpmHashBytes(ensemble->draws[k].name, strlen(ensemble->draws[k].name), 0);
  PetscCall(MpmLatinHypercube((uint64_t)ensemble->seed, ensemble->members, ensemble->draw_count, streams,
                              ensemble->correlation, ensemble->shares, &positive));
  MpmCheckInput(positive, "-mpm_ensemble_correlation: there are no numbers with all of these correlations: the matrix "
                          "is not positive definite");
  PetscCall(PetscFree(streams));
  PetscCall(FindScene(&ensemble->scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes away the ensemble's options. */
static PetscErrorCode ClearOwn(void)
{
  MpmDatabaseOption *options;
  PetscInt           count;
  char              *text;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseGet(&count, &options, &text));
  for (PetscInt k = 0; k < count; k++) {
    PetscBool is    = (PetscBool)!strcmp(options[k].name, task);
    char     *named = NULL;

    for (PetscInt o = 0; own[o]; o++) is = (PetscBool)(is || !strncmp(options[k].name, own[o], strlen(own[o])));
    if (!is) continue;
    PetscCall(MpmTextAppend(&named, "-%s", options[k].name));
    PetscCall(PetscOptionsClearValue(NULL, named));
    PetscCall(PetscFree(named));
  }
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDrawsSetOptions(const MpmEnsemble *ensemble, PetscInt member, const char prefix[])
{
  PetscFunctionBeginUser;
  PetscCall(ClearOwn());
  for (PetscInt k = 0; k < ensemble->draw_count; k++)
    for (PetscInt i = 0; i < ensemble->draws[k].of.count; i++)
      PetscCall(MpmSceneParameterSet(&ensemble->draws[k].of.at[i], (double)MpmDrawValue(ensemble, k, member)));
  if (ensemble->terrain) {
    char seed[MPM_NUMBER_TEXT];

    PetscCall(PetscSNPrintf(seed, sizeof(seed), "%" PetscInt_FMT, MpmTerrainSeed(ensemble, member)));
    PetscCall(PetscOptionsSetValue(NULL, TERRAIN, seed));
  }
  PetscCall(PetscOptionsSetValue(NULL, "-mpm_output_prefix", prefix));
  if (ensemble->sparse) PetscCall(PetscOptionsSetValue(NULL, "-mpm_output_every", "0"));
  if (ensemble->maps) PetscCall(PetscOptionsSetValue(NULL, "-mpm_maps_every", "0"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
