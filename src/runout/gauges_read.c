/*
  Options of gauges: a place, a line, an outline or a path, or the features of a file.
*/
#include <ctype.h>
#include <string.h>
#include "maps/map.h"
#include "maps/outline.h"
#include "options/options.h"
#include "runout/runout_impl.h"

static const char *const kinds[MPM_GAUGE_KINDS] = {"place", "line", "outline", "path"};
static const PetscInt    least[MPM_GAUGE_KINDS] = {1, 2, 3, 2};

/* A gauge more, without samples. */
static PetscErrorCode Append(MpmGaugeKind kind, const char name[], MpmGauges *gauges, MpmGauge **gauge)
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < gauges->count; g++)
    MpmCheckInput(strcmp(gauges->at[g].name, name), "-mpm_gauges: two have the name %s", name);
  PetscCall(PetscRealloc((size_t)(gauges->count + 1) * sizeof(*gauges->at), &gauges->at));
  *gauge = &gauges->at[gauges->count++];
  PetscCall(PetscMemzero(*gauge, sizeof(**gauge)));
  PetscCall(PetscStrallocpy(name, &(*gauge)->name));
  (*gauge)->kind = kind;
  if (kind == MPM_GAUGE_PATH) (*gauge)->kept[0] = (*gauge)->kept[1] = -1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The name of a feature's gauge: that of the block, and the label. */
static PetscErrorCode NameOf(const char block[], const char label[], char **name)
{
  PetscFunctionBeginUser;
  *name = NULL;
  PetscCall(label ? MpmTextAppend(name, "%s_%s", block, label) : MpmTextAppend(name, "%s", block));
  for (char *c = *name; *c; c++)
    if (!isalnum((unsigned char)*c)) *c = '_';
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True of a hole in a polygon, which turns right. */
static PetscBool IsHole(const MpmOutline *outline, PetscInt path)
{
  const PetscInt   begin = outline->start[path], count = outline->start[path + 1] - begin;
  const PetscReal *at   = &outline->at[2 * begin];
  PetscReal        area = 0.;

  for (PetscInt v = 0; v < count; v++) {
    const PetscReal *a = &at[2 * v], *b = &at[2 * ((v + 1) % count)];

    area += a[0] * b[1] - a[1] * b[0];
  }
  return (PetscBool)(area < 0.);
}

/* Features of a file: one gauge, or one for each label. */
static PetscErrorCode ReadFile(const MpmModel model, const MpmOptions *block, const char name[], const char path[],
                               const char label[])
{
  static const MpmGaugeKind of[]                     = {[MPM_OUTLINE_POINT]   = MPM_GAUGE_PLACE,
                                                        [MPM_OUTLINE_LINE]    = MPM_GAUGE_LINE,
                                                        [MPM_OUTLINE_POLYGON] = MPM_GAUGE_OUTLINE};
  const MpmPlane           *plane                    = MpmRecordPlane(block->record);
  MpmGauges                *gauges                   = &model->runout->gauges;
  MpmOutlineAsk             ask                      = {0};
  MpmOutline                outline                  = {0};
  MpmGauge                 *gauge                    = NULL;
  char                      message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  if (plane) ask = (MpmOutlineAsk){plane->project, plane->system, {plane->origin[0], plane->origin[1]}};
  PetscCall(MpmOutlineRead(path, &ask, &outline, message));
  MpmCheckInput(!message[0] && outline.features, "-%sfile %s: %s", block->prefix, path,
                message[0] ? message : "is empty");
  for (PetscInt f = 0; f < outline.features; f++) {
    const MpmFeature *feature = &outline.feature[f];
    const char       *text    = label ? MpmOutlineText(&outline, f, label) : NULL;
    char             *whole;

    MpmCheckInput(!label || text, "-%slabel %s: feature %" PetscInt_FMT " of %s has no such attribute", block->prefix,
                  label, f + 1, path);
    MpmCheckInput(label || !f || feature->type == outline.feature[0].type,
                  "-%sfile %s: has features of several kinds, which need a label", block->prefix, path);
    PetscCall(NameOf(name, text, &whole));
    if (!gauge || label) PetscCall(Append(of[feature->type], whole, gauges, &gauge));
    PetscCall(PetscFree(whole));
    for (PetscInt k = feature->first; k < feature->end; k++)
      if (feature->type != MPM_OUTLINE_POLYGON || !IsHole(&outline, k))
        PetscCall(MpmGaugeAddSamples(model->disc.grid, outline.start[k + 1] - outline.start[k],
                                     &outline.at[2 * outline.start[k]], gauge));
    MpmCheckInput(gauge->count, "-%sfile %s: feature %" PetscInt_FMT " is outside of the grid", block->prefix, path,
                  f + 1);
  }
  PetscCall(MpmOutlineDestroy(&outline));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A file of a block; `given`: there is one. */
static PetscErrorCode ReadFileOptions(const MpmModel model, const MpmOptions *block, const char name[],
                                      PetscBool *given)
{
  char *path, *label;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsPath(block, "file",
                           "file of places, lines or polygons: GeoJSON, or a shapefile, GeoPackage and others by GDAL",
                           MPM_OPTIONAL, &path));
  PetscCall(
    MpmOptionsText(block, "label",
                   "attribute of the file's features: each is a gauge of its own, NAME_<label>; without it they "
                   "are one",
                   NULL, MPM_OPTIONAL, &label));
  *given = (PetscBool)(path != NULL);
  MpmCheckInput(path || !label || MpmOptionsHelp(), "-%slabel: needs a file", block->prefix);
  if (path && !MpmOptionsHelp()) PetscCall(ReadFile(model, block, name, path, label));
  PetscCall(PetscFree(path));
  PetscCall(PetscFree(label));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One block: exactly one of the kinds, or a file. */
static PetscErrorCode ReadGauge(const MpmModel model, const MpmOptions *options, const char name[])
{
  static const char *const help[MPM_GAUGE_KINDS] = {
    "x,y of a place: the history has depth, speed and pressure there",
    "x,y,x,y,... of a line: the history has the discharge, m3/s, from its left to its right side as one goes along "
    "it, and the volume that has passed, m3",
    "x,y,x,y,... of an area: the history has the largest depth, speed and pressure so far in it",
    "x,y,x,y,... of a line down the slope: the history has the way, m, and the angle, degrees, from where the flow "
    "began to the furthest place that it has reached; PREFIX_gauge_NAME.csv has bed and largest values along it"};
  const MpmGrid *grid = model->disc.grid;
  char           prefix[256];
  PetscInt       count[MPM_GAUGE_KINDS], found = 0, k = 0;
  PetscReal     *vertex[MPM_GAUGE_KINDS];
  PetscBool      file = PETSC_FALSE;
  MpmGauge      *gauge;
  MpmOptions     block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_gauge_%s_", name));
  PetscCall(MpmOptionsHeading(&block, "Gauge (-mpm_physics depth_averaged)"));
  for (PetscInt c = 0; c < MPM_GAUGE_KINDS; c++) {
    PetscCall(MpmOptionsRealList(&block, kinds[c], "m", help[c], MPM_OPTIONAL, &count[c], &vertex[c]));
    if (!count[c]) continue;
    k = c;
    found++;
  }
  PetscCall(ReadFileOptions(model, &block, name, &file));
  MpmCheckInput(found + (PetscInt)file == 1 || MpmOptionsHelp(),
                "-%splace, line, outline, path or file: must have one of them", prefix);
  if (!MpmOptionsHelp() && !file) {
    MpmCheckInput(count[k] % 2 == 0 && count[k] >= 2 * least[k] && (k || count[k] == 2),
                  "-%s%s: has %" PetscInt_FMT " numbers, must have %s%" PetscInt_FMT, prefix, kinds[k], count[k],
                  k ? "an even number, at least " : "", 2 * least[k]);
    for (PetscInt c = 0; c < count[k]; c++) {
      MpmCheckInput(vertex[k][c] >= grid->lower[c % 2] && vertex[k][c] <= grid->upper[c % 2],
                    "-%s%s: %g is outside of the grid on axis %c", prefix, kinds[k], (double)vertex[k][c], "xy"[c % 2]);
    }
    PetscCall(Append((MpmGaugeKind)k, name, &model->runout->gauges, &gauge));
    PetscCall(MpmGaugeAddSamples(grid, count[k] / 2, vertex[k], gauge));
  }
  for (PetscInt c = 0; c < MPM_GAUGE_KINDS; c++) PetscCall(PetscFree(vertex[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes about the samples, and weights of their values. */
static PetscErrorCode FindSlots(const MpmGrid *grid, MpmGauges *gauges)
{
  const PetscInt nodes = grid->nodes[0] * grid->nodes[1];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(nodes, &gauges->slot));
  for (PetscInt i = 0; i < nodes; i++) gauges->slot[i] = -1;
  for (PetscInt g = 0; g < gauges->count; g++) {
    for (PetscInt k = 0; k < gauges->at[g].count; k++) {
      MpmSample *sample = &gauges->at[g].sample[k];
      PetscInt   first;

      (void)MpmLatticeCorners(grid, sample->x, &first, sample->weight);
      for (PetscInt c = 0; c < 4; c++) {
        PetscInt *slot = &gauges->slot[first + c % 2 + grid->nodes[0] * (c / 2)];

        if (*slot < 0) *slot = gauges->slots++;
        sample->slot[c] = *slot;
      }
    }
  }
  PetscCall(PetscMalloc1(gauges->slots * MPM_GAUGE_VALUES, &gauges->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGaugesRead(MpmModel model, const MpmOptions *options)
{
  MpmGauges *gauges = &model->runout->gauges;
  PetscInt   count;
  char     **names;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "gauges", "names of places, lines, outlines and paths that observe the flow",
                             MPM_OPTIONAL, &count, &names));
  for (PetscInt g = 0; g < count; g++) PetscCall(ReadGauge(model, options, names[g]));
  PetscCall(MpmNamesDestroy(count, &names));
  if (gauges->count && !MpmOptionsHelp()) PetscCall(FindSlots(model->disc.grid, gauges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGaugesDestroy(MpmGauges *gauges)
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < gauges->count; g++) {
    PetscCall(PetscFree(gauges->at[g].name));
    PetscCall(PetscFree(gauges->at[g].sample));
  }
  PetscCall(PetscFree(gauges->at));
  PetscCall(PetscFree(gauges->slot));
  PetscCall(PetscFree(gauges->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
