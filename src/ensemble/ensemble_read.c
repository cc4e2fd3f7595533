/*
  Options of an ensemble.
*/
#include <string.h>
#include "options/record.h"
#include "ensemble/ensemble.h"

#define NAME_TEXT 128 /* of prefixes of options */

/* ---- draws ---- */

/* Mean, deviation or mode by the distribution; mean and mode are the scene's value where they are not given. */
static PetscErrorCode ReadShape(const MpmOptions *block, const char *word, PetscBool bounded, MpmDistribution *at)
{
  const PetscBool normal = (PetscBool)(at->type == MPM_NORMAL || at->type == MPM_LOGNORMAL);
  PetscBool       deviates;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(block, "mean", "", "normal, lognormal: of the number itself; default: the scene's value",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &at->mean, NULL));
  PetscCall(MpmOptionsReal(block, "deviation", "", "normal, lognormal: standard deviation of the number itself",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &at->deviation, &deviates));
  PetscCall(MpmOptionsReal(block, "mode", "", "triangular: the most likely value; default: the scene's value",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &at->mode, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(normal || bounded, "-%sbounds is missing: a %s distribution has a least and a largest value",
                block->prefix, word);
  MpmCheckInput(!normal || deviates, "-%sdeviation is missing: of a %s distribution", block->prefix, word);
  MpmCheckInput(at->type != MPM_LOGNORMAL || at->mean > 0., "-%smean %g: must be > 0 with a lognormal distribution",
                block->prefix, (double)at->mean);
  MpmCheckInput(at->type != MPM_TRIANGULAR || (at->mode >= at->lower && at->mode <= at->upper),
                "-%smode %g: must lie within the bounds, %g to %g", block->prefix, (double)at->mode, (double)at->lower,
                (double)at->upper);
  MpmCheckInput(at->type != MPM_LOGNORMAL || at->upper > 0.,
                "-%sbounds: the largest must be > 0 with a lognormal "
                "distribution",
                block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadDistribution(const MpmOptions *block, PetscReal value, MpmDistribution *at)
{
  static const char *const words[]   = {"uniform", "normal", "lognormal", "triangular", NULL};
  PetscReal                bounds[2] = {PETSC_NINFINITY, PETSC_INFINITY};
  PetscInt                 type      = MPM_UNIFORM;
  PetscBool                bounded;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "distribution", "of the number over the members", words, MPM_REQUIRED, &type, NULL));
  PetscCall(MpmOptionsReals(block, "bounds", "", "least and largest value: normal and lognormal are cut there",
                            MPM_RANGE_ANY, MPM_OPTIONAL, 2, bounds, &bounded));
  MpmCheckInput(bounds[0] < bounds[1] || MpmOptionsHelp(), "-%sbounds %g,%g: must ascend", block->prefix,
                (double)bounds[0], (double)bounds[1]);
  *at = (MpmDistribution){
    .type = (MpmDistributionType)type, .lower = bounds[0], .upper = bounds[1], .mean = value, .mode = value};
  PetscCall(ReadShape(block, words[type], bounded, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The numbers of a draw. */
static PetscErrorCode FindNumbers(const MpmModel model, const char text[], MpmDraw *draw)
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(MpmTextSplit(text, &count, &names));
  PetscCall(PetscCalloc1(count, &draw->of.at));
  for (PetscInt k = 0; k < count; k++) {
    MpmSceneParameter *parameter = &draw->of.at[draw->of.count++];

    PetscCall(PetscStrallocpy(names[k], &parameter->name));
    parameter->option = draw->option;
    PetscCall(MpmParameterFindOptions(model->record, model->scene.loads, parameter));
  }
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadDraw(const MpmModel model, const char name[], MpmDraw *draw)
{
  char             prefix[NAME_TEXT];
  const MpmOptions block = {model->comm, prefix, model->record};
  char            *of;

  PetscFunctionBeginUser;
  MpmCheckInput(strlen(name) < NAME_TEXT - 16, "-mpm_ensemble_draws %.60s...: is too long", name);
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_draw_%s_", name));
  PetscCall(MpmTextAppend(&draw->option, "-%sof", prefix));
  PetscCall(MpmOptionsText(&block, "of", "number of the scene, BLOCK.KEY; several, at commas, are equal", NULL,
                           MPM_REQUIRED, &of));
  if (!MpmOptionsHelp()) PetscCall(FindNumbers(model, of, draw));
  PetscCall(PetscFree(of));
  PetscCall(ReadDistribution(&block, draw->of.count ? draw->of.at[0].value : 0., &draw->distribution));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt FindName(PetscInt count, char *const names[], const char name[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!strcmp(names[k], name)) return k;
  return -1;
}

/* Parts of a text at colons: "mu:depth:0.5"; false where there are others than `count` of them. */
static PetscBool SplitAtColons(char text[], PetscInt count, char *parts[])
{
  for (PetscInt k = 0; k < count; k++) {
    char *colon = strchr(text, ':');

    parts[k] = text;
    if ((k + 1 < count) != (colon != NULL)) return PETSC_FALSE;
    if (!colon) break;
    *colon = '\0';
    text   = colon + 1;
  }
  return PETSC_TRUE;
}

static PetscErrorCode ReadCorrelation(const MpmOptions *block, MpmEnsemble *ensemble)
{
  PetscInt count, draws = ensemble->draw_count;
  char   **parts, *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "correlation", "of two draws by their ranks: A:B:0.5,...; others have 0", NULL,
                           MPM_OPTIONAL, &text));
  if (!text || !text[0] || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  MpmCheckInput(ensemble->members > draws, "-mpm_ensemble_members %d: must be more than the draws with correlation",
                (int)ensemble->members);
  PetscCall(PetscMalloc1((size_t)draws * (size_t)draws, &ensemble->correlation));
  for (PetscInt k = 0; k < draws * draws; k++) ensemble->correlation[k] = NAN;
  PetscCall(MpmTextSplit(text, &count, &parts));
  for (PetscInt k = 0; k < count; k++) {
    PetscReal value;
    PetscInt  a = -1, b = -1;
    char     *part[3];

    if (SplitAtColons(parts[k], 3, part) && MpmParseReal(part[2], &value)) {
      a = FindName(draws, ensemble->names, part[0]);
      b = FindName(draws, ensemble->names, part[1]);
    }
    MpmCheckInput(a >= 0 && b >= 0 && a != b && PetscAbsReal(value) < 1.,
                  "-mpm_ensemble_correlation %s: must be A:B:R,..., A and B draws, R a number in (-1, 1)", text);
    MpmCheckInput(PetscIsNanReal(ensemble->correlation[a * draws + b]),
                  "-mpm_ensemble_correlation %s: %s and %s are there twice", text, ensemble->names[a],
                  ensemble->names[b]);
    ensemble->correlation[a * draws + b] = ensemble->correlation[b * draws + a] = value;
  }
  for (PetscInt k = 0; k < draws * draws; k++)
    if (PetscIsNanReal(ensemble->correlation[k])) ensemble->correlation[k] = k % (draws + 1) ? 0. : 1.;
  PetscCall(MpmNamesDestroy(count, &parts));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- statistics ---- */

static PetscErrorCode ReadThresholds(const MpmOptions *block, MpmEnsembleAsk *ask)
{
  PetscInt count;
  char   **parts, *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(
    block, "thresholds", "values of depth, m, speed, m/s, and pressure, Pa: maps have the share of members above each",
    "depth:0.1", MPM_OPTIONAL, &text));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  PetscCall(MpmTextSplit(text, &count, &parts));
  PetscCall(PetscCalloc1(count, &ask->thresholds));
  for (PetscInt k = 0; k < count; k++) {
    MpmThreshold *at = &ask->thresholds[ask->threshold_count++];
    char         *part[2];
    PetscBool     good = SplitAtColons(parts[k], 2, part);

    good         = (PetscBool)(good && MpmParseReal(part[1], &at->value));
    at->quantity = good ? 0 : -1;
    while (good && MpmMapQuantities[at->quantity] && strcmp(MpmMapQuantities[at->quantity], part[0])) at->quantity++;
    MpmCheckInput(good && MpmMapQuantities[at->quantity],
                  "-mpm_ensemble_thresholds %s: must be depth:0.5,pressure:1e4,..., of depth, speed or pressure", text);
  }
  PetscCall(MpmNamesDestroy(count, &parts));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadAsk(const MpmOptions *block, MpmEnsembleAsk *ask)
{
  static const PetscReal shares[] = {0.05, 0.5, 0.95};
  char                  *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "results",
                           "columns of the history, whose last values count, and numbers of the summary; default: all "
                           "columns, and the factor of safety",
                           NULL, MPM_OPTIONAL, &text));
  if (text && !MpmOptionsHelp()) PetscCall(MpmTextSplit(text, &ask->result_count, &ask->results));
  PetscCall(PetscFree(text));
  PetscCall(MpmOptionsRealList(block, "quantiles", "", "shares of members below, in (0, 1); default: 0.05,0.5,0.95",
                               MPM_OPTIONAL, &ask->quantile_count, &ask->quantiles));
  for (PetscInt k = 0; k < ask->quantile_count && !MpmOptionsHelp(); k++)
    MpmCheckInput(ask->quantiles[k] > 0. && ask->quantiles[k] < 1., "-mpm_ensemble_quantiles %g: must lie in (0, 1)",
                  (double)ask->quantiles[k]);
  if (!ask->quantile_count) {
    ask->quantile_count = PETSC_STATIC_ARRAY_LENGTH(shares);
    PetscCall(PetscFree(ask->quantiles));
    PetscCall(PetscMalloc1(ask->quantile_count, &ask->quantiles));
    PetscCall(PetscArraycpy(ask->quantiles, shares, ask->quantile_count));
  }
  PetscCall(ReadThresholds(block, ask));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all of it ---- */

/* Refuses two draws of one number: the last would replace the first. */
static PetscErrorCode CheckApart(const MpmEnsemble *ensemble, PetscInt draw)
{
  const MpmSceneParameters *of = &ensemble->draws[draw].of;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < draw; k++)
    for (PetscInt i = 0; i < ensemble->draws[k].of.count; i++)
      for (PetscInt j = 0; j < of->count; j++)
        MpmCheckInput(!MpmSceneParametersMeet(&ensemble->draws[k].of.at[i], &of->at[j]),
                      "%s %s: draw %s has this number already", ensemble->draws[draw].option, of->at[j].name,
                      ensemble->draws[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadDraws(MpmModel model, const MpmOptions *block, MpmEnsemble *ensemble)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(block, "draws", "names of the numbers that are drawn, with a block -mpm_draw_NAME_ each",
                             MPM_OPTIONAL, &ensemble->draw_count, &ensemble->names));
  PetscCall(PetscCalloc1(ensemble->draw_count + 1, &ensemble->draws));
  for (PetscInt k = 0; k < ensemble->draw_count; k++) {
    ensemble->draws[k].name = ensemble->names[k];
    PetscCall(ReadDraw(model, ensemble->names[k], &ensemble->draws[k]));
    PetscCall(CheckApart(ensemble, k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the scene's terrain has noise, and not that of a given seed. */
static PetscErrorCode HasTerrain(const MpmModel model, PetscBool *has)
{
  MpmRecordEntry *noise, *seed;

  PetscFunctionBeginUser;
  PetscCall(MpmRecordFind(model->record, "mpm_terrain_noise", &noise));
  PetscCall(MpmRecordFind(model->record, "mpm_terrain_noise_seed", &seed));
  *has = (PetscBool)(noise && noise->given && (!seed || !seed->given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode IsTask(const MpmModel model, PetscBool *is)
{
  MpmRecordEntry *task;

  PetscFunctionBeginUser;
  PetscCall(MpmRecordFind(model->record, "mpm_task", &task));
  *is = (PetscBool)(MpmOptionsHelp() || (task && task->value && !strcmp(task->value, "ensemble")));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleRead(MpmModel model)
{
  const MpmOptions block = {model->comm, "mpm_ensemble_", model->record}, top = {model->comm, "mpm_", model->record};
  MpmEnsemble     *ensemble;
  PetscBool        is = PETSC_FALSE, restart, given;

  PetscFunctionBeginUser;
  PetscCall(IsTask(model, &is));
  if (!is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&ensemble));
  model->ensemble   = ensemble;
  ensemble->members = 100;
  ensemble->seed    = 1;
  ensemble->groups  = model->size;
  PetscCall(MpmOptionsHeading(&block, "Ensemble of runs (-mpm_task ensemble)"));
  PetscCall(MpmOptionsInt(&block, "members", "runs of the scene", 1, 10000000, MPM_OPTIONAL, &ensemble->members, NULL));
  PetscCall(MpmOptionsInt(&block, "seed", "of the draws: equal on any ranks", 0, PETSC_INT_MAX, MPM_OPTIONAL,
                          &ensemble->seed, NULL));
  PetscCall(MpmOptionsInt(&block, "groups",
                          "of ranks that run members side by side; at most one a rank, which is the default", 1,
                          PETSC_INT_MAX, MPM_OPTIONAL, &ensemble->groups, NULL));
  ensemble->groups = PetscMin(ensemble->groups, model->size);
  PetscCall(ReadDraws(model, &block, ensemble));
  PetscCall(ReadCorrelation(&block, ensemble));
  PetscCall(ReadAsk(&block, &ensemble->ask));
  PetscCall(MpmOptionsBool(&block, "restart",
                           "take members of the same scene that have been run already, and run the "
                           "rest",
                           &ensemble->restart, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(MpmEnsembleDestroy(model));
  PetscCall(HasTerrain(model, &ensemble->terrain));
  PetscCall(MpmOptionsHas(&top, "maps_every", &given));
  ensemble->maps = (PetscBool)(model->scene.deformation.bed && !given);
  PetscCall(MpmOptionsHas(&top, "output_every", &given));
  ensemble->sparse = (PetscBool)(!model->laboratory && !given);
  MpmCheckInput(ensemble->draw_count || ensemble->terrain, "-mpm_ensemble_draws is missing: -mpm_task ensemble needs "
                                                           "numbers that are drawn, or -mpm_terrain_noise");
  PetscCall(MpmOptionsHas(&top, "restart", &restart));
  MpmCheckInput(!restart, "-mpm_restart: -mpm_task ensemble goes on with -mpm_ensemble_restart");
  PetscCall(MpmDrawsMake(ensemble));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleDestroy(MpmModel model)
{
  MpmEnsemble *ensemble = model->ensemble;

  PetscFunctionBeginUser;
  if (!ensemble) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; ensemble->draws && k < ensemble->draw_count; k++) {
    PetscCall(MpmSceneParametersDestroy(&ensemble->draws[k].of));
    PetscCall(PetscFree(ensemble->draws[k].option));
  }
  PetscCall(PetscFree(ensemble->draws));
  PetscCall(MpmNamesDestroy(ensemble->draw_count, &ensemble->names));
  PetscCall(MpmNamesDestroy(ensemble->ask.result_count, &ensemble->ask.results));
  PetscCall(PetscFree(ensemble->correlation));
  PetscCall(PetscFree(ensemble->shares));
  PetscCall(PetscFree(ensemble->ask.quantiles));
  PetscCall(PetscFree(ensemble->ask.thresholds));
  PetscCall(PetscFree(model->ensemble));
  PetscFunctionReturn(PETSC_SUCCESS);
}
