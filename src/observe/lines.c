/*
  Forces in cuts and stresses along lines: which columns and files they have.
*/
#include "base/columns.h"
#include "problem/section.h"
#include "query/model.h"
#include "observe/history.h"
#include "observe/lines.h"
#include "observe/profile.h"
#include "observe/results.h"

static PetscInt SectionCount(const MpmModel model)
{
  return model->disc.sections ? model->disc.sections->count : 0;
}

/* A section of several cuts has a file, one of a single cut stands in the history. */
static PetscBool IsRow(const MpmSection *section)
{
  return (PetscBool)(section->count > 1);
}

PetscErrorCode MpmLinesDestroy(MpmModel model)
{
  MpmLines    *lines    = &model->results->lines;
  MpmSections *sections = model->disc.sections;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < lines->file_count; k++) PetscCall(MpmHistoryDestroy(&lines->files[k]));
  PetscCall(PetscFree(lines->files));
  for (PetscInt k = 0; k < lines->profile_count; k++) PetscCall(MpmProfileDestroy(&lines->profiles[k]));
  PetscCall(PetscFree(lines->profiles));
  PetscCall(MpmNamesDestroy(lines->profile_count, &lines->profile_names));
  if (!sections) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < sections->count; k++) PetscCall(MpmSectionDestroy(&sections->at[k]));
  PetscCall(PetscFree(sections->at));
  PetscCall(MpmNamesDestroy(sections->count, &sections->names));
  PetscCall(PetscFree(model->disc.sections));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

PetscInt MpmLinesFieldCount(const MpmModel model)
{
  return SectionCount(model) + model->results->lines.profile_count;
}

void MpmLinesAddFields(const MpmModel model, const char *fields[], PetscInt *count)
{
  const MpmLines *lines = &model->results->lines;

  for (PetscInt k = 0; k < SectionCount(model); k++)
    if (model->disc.sections->at[k].chosen_field) fields[(*count)++] = model->disc.sections->at[k].chosen_field;
  for (PetscInt k = 0; k < lines->profile_count; k++)
    if (lines->profiles[k].chosen_field) fields[(*count)++] = lines->profiles[k].chosen_field;
}

PetscErrorCode MpmLinesSelect(MpmModel model)
{
  MpmLines *lines = &model->results->lines;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < SectionCount(model); k++)
    PetscCall(MpmSectionSelect(&model->disc.sections->at[k], model->scene.bodies, model->state.particles));
  for (PetscInt k = 0; k < lines->profile_count; k++)
    PetscCall(MpmProfileSelect(&lines->profiles[k], model->scene.bodies, model->state.particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns ---- */

#define MOST_COLUMNS 16

/* Names by the dimension: forces and moments of a cut, tractions and stresses of a place. */
static const struct {
  const char *forces[6], *tractions[MPM_MAX_DIM], *stresses[6];
} parts[] = {[2] = {{"n", "v", "m"}, {"n", "t"}, {"xx", "yy", "zz", "xy"}},
             [3] = {{"n", "v1", "v2", "t", "m1", "m2"}, {"n", "t1", "t2"}, {"xx", "yy", "zz", "xy", "yz", "xz"}}};

/* Components of force and moment. */
static PetscInt ForceCount(PetscInt dim)
{
  return dim * (dim + 1) / 2;
}

static void AddForces(PetscInt dim, const MpmCut *cut, PetscReal row[], PetscInt *count)
{
  for (PetscInt a = 0; a < dim; a++) row[(*count)++] = cut->force[a];
  for (PetscInt a = 0; a < ForceCount(dim) - dim; a++) row[(*count)++] = cut->moment[a];
}

static PetscErrorCode FillSection(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscInt count = 0;

  PetscFunctionBeginUser;
  AddForces(model->disc.dim, &model->disc.sections->at[column->index].cuts[0], values, &count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Means over the places in the material. */
static PetscErrorCode FillProfile(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  MpmProfile    *profile          = &model->results->lines.profiles[column->index];
  const PetscInt dim              = model->disc.dim;
  PetscReal      sum[MPM_MAX_DIM] = {0.}, traction[MPM_MAX_DIM];
  PetscInt       places           = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmProfileEvaluate(profile, model->disc.grid, model->state.particles));
  for (PetscInt k = 0; k < profile->count; k++) {
    MpmProfileTraction(profile, dim, k, traction);
    if (PetscIsInfOrNanReal(traction[0])) continue;
    for (PetscInt a = 0; a < dim; a++) sum[a] += traction[a];
    places++;
  }
  for (PetscInt a = 0; a < dim; a++) values[a] = places ? sum[a] / (PetscReal)places : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLinesAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmLines *lines = &model->results->lines;
  const PetscInt  dim   = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < SectionCount(model); k++) {
    const MpmSection *section = &model->disc.sections->at[k];
    const MpmColumn   row     = {"section", "N, moments N m", ForceCount(dim), parts[dim].forces, FillSection, NULL, k};

    if (!IsRow(section)) PetscCall(MpmColumnsAdd(columns, section->name, &row));
  }
  for (PetscInt k = 0; k < lines->profile_count; k++) {
    const MpmColumn row = {"profile", "Pa", dim, parts[dim].tractions, FillProfile, NULL, k};

    PetscCall(MpmColumnsAdd(columns, lines->profiles[k].name, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- files ---- */

/* Appends names of columns. */
static void AddNames(PetscInt number, const char *const columns[], const char *names[], PetscInt *count)
{
  for (PetscInt k = 0; k < number; k++) names[(*count)++] = columns[k];
}

/* Step, time, distance and place, which all files have. */
static void AddPlaceNames(PetscInt dim, const char *names[], PetscInt *count)
{
  AddNames(3, (const char *const[]){"step", "time", "s"}, names, count);
  AddNames(dim, MpmAxisParts, names, count);
}

static void AddPlace(const MpmModel model, PetscReal s, const PetscReal x[], PetscReal row[], PetscInt *count)
{
  row[(*count)++] = (PetscReal)model->state.step;
  row[(*count)++] = model->state.time;
  row[(*count)++] = s;
  for (PetscInt a = 0; a < model->disc.dim; a++) row[(*count)++] = x[a];
}

/* Opens the next file. */
static PetscErrorCode OpenFile(MpmModel model, const char *kind, const char *name, PetscInt count,
                               const char *const names[])
{
  MpmLines   *lines = &model->results->lines;
  MpmHistory *file  = &lines->files[lines->file_count];
  char        path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_%s_%s.csv", model->scene.name.prefix, kind, name));
  if (model->results->checkpoint.restart)
    PetscCall(MpmHistoryResume(model, path, 1 + lines->file_count, count, names, file));
  else PetscCall(MpmHistoryCreate(model->comm, path, count, names, file));
  lines->file_count++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLinesOpen(MpmModel model)
{
  MpmLines      *lines = &model->results->lines;
  const PetscInt dim   = model->disc.dim;
  const char    *names[MOST_COLUMNS];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(MpmLinesFieldCount(model), &lines->files));
  for (PetscInt k = 0; k < SectionCount(model); k++) {
    const MpmSection *section = &model->disc.sections->at[k];
    PetscInt          count   = 0;

    if (!IsRow(section)) continue;
    AddPlaceNames(dim, names, &count);
    AddNames(ForceCount(dim), parts[dim].forces, names, &count);
    names[count++] = "area";
    PetscCall(OpenFile(model, "section", section->name, count, names));
  }
  for (PetscInt k = 0; k < lines->profile_count; k++) {
    PetscInt count = 0;

    AddPlaceNames(dim, names, &count);
    AddNames(dim, parts[dim].tractions, names, &count);
    AddNames(lines->profiles[k].size, parts[dim].stresses, names, &count);
    PetscCall(OpenFile(model, "profile", lines->profiles[k].name, count, names));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteProfile(MpmModel model, MpmProfile *profile, MpmHistory file)
{
  const PetscInt dim = model->disc.dim;
  PetscReal      row[MOST_COLUMNS], x[MPM_MAX_DIM], length = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmProfileEvaluate(profile, model->disc.grid, model->state.particles));
  for (PetscInt a = 0; a < dim; a++) length += PetscSqr(profile->last[a] - profile->first[a]);
  length = PetscSqrtReal(length);
  for (PetscInt k = 0; k < profile->count; k++) {
    PetscInt count = 0;

    MpmProfilePlace(profile, dim, k, x);
    AddPlace(model, length * (PetscReal)k / (PetscReal)(profile->count - 1), x, row, &count);
    MpmProfileTraction(profile, dim, k, &row[count]);
    PetscCall(PetscArraycpy(&row[count + dim], &profile->stress[k * profile->size], profile->size));
    PetscCall(MpmHistoryAppend(file, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLinesWrite(MpmModel model)
{
  MpmLines      *lines = &model->results->lines;
  PetscInt       file  = 0;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  for (PetscInt k = 0; k < SectionCount(model); k++) {
    const MpmSection *section = &model->disc.sections->at[k];

    if (!IsRow(section)) continue;
    for (PetscInt c = 0; c < section->count && model->disc.sections->made; c++) {
      const MpmCut *cut = &section->cuts[c];
      PetscReal     row[MOST_COLUMNS];
      PetscInt      count = 0;

      AddPlace(model, cut->distance, cut->place, row, &count);
      AddForces(model->disc.dim, cut, row, &count);
      row[count] = cut->area;
      PetscCall(MpmHistoryAppend(lines->files[file], row));
    }
    file++;
  }
  for (PetscInt k = 0; k < lines->profile_count; k++)
    PetscCall(WriteProfile(model, &lines->profiles[k], lines->files[file++]));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLinesMark(MpmModel model, MpmTextFile *places)
{
  const MpmLines *lines = &model->results->lines;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < lines->file_count; k++) {
    MpmHistoryPlace place;

    PetscCall(MpmHistoryMark(lines->files[k], &place));
    PetscCall(MpmTextFileAppend(places, "%lld %lld\n", (long long)place.length, (long long)place.hash));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
