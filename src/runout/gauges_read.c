/*
  Gauges: a place, a line, an outline or a path, and the samples that they take of the flow, half a cell apart.
*/
#include "maps/bed.h"
#include "options/options.h"
#include "runout/runout_impl.h"

#define APART 0.5 /* cells between samples */

static const char *const kinds[MPM_GAUGE_KINDS] = {"place", "line", "outline", "path"};
static const PetscInt    least[MPM_GAUGE_KINDS] = {1, 2, 3, 2};

/* Room for more samples. */
static PetscErrorCode Grow(MpmGauge *gauge, PetscInt more)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(gauge->count + more) * sizeof(*gauge->sample), &gauge->sample));
  PetscCall(PetscArrayzero(&gauge->sample[gauge->count], more));
  gauge->count += more;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Spacing(const MpmGrid *grid)
{
  return APART * PetscMin(grid->h[0], grid->h[1]);
}

/* Pieces of a line from s on, each with its middle. */
static PetscErrorCode AddPiece(const MpmGrid *grid, const PetscReal from[], const PetscReal to[], PetscReal *s,
                               MpmGauge *gauge)
{
  const PetscReal along[2] = {to[0] - from[0], to[1] - from[1]};
  const PetscReal length   = PetscSqrtReal(along[0] * along[0] + along[1] * along[1]);
  const PetscInt  pieces = PetscMax((PetscInt)PetscCeilReal(length / Spacing(grid)), 1), begin = gauge->count;

  PetscFunctionBeginUser;
  PetscCall(Grow(gauge, pieces));
  for (PetscInt k = 0; k < pieces; k++) {
    const PetscReal part   = ((PetscReal)k + 0.5) / (PetscReal)pieces;
    MpmSample      *sample = &gauge->sample[begin + k];

    for (PetscInt a = 0; a < 2; a++) sample->x[a] = from[a] + part * along[a];
    sample->normal[0] = along[1] / (PetscReal)pieces;
    sample->normal[1] = -along[0] / (PetscReal)pieces;
    sample->s         = *s + part * length;
  }
  *s += length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By the rule of even and odd crossings. */
static PetscBool Inside(PetscInt count, const PetscReal vertex[], const PetscReal x[])
{
  PetscBool in = PETSC_FALSE;

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal *a = &vertex[2 * k], *b = &vertex[2 * ((k + 1) % count)];

    if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1]))
      in = (PetscBool)!in;
  }
  return in;
}

/* The corners of an outline, and places inside. */
static PetscErrorCode AddOutline(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge)
{
  const PetscReal apart    = Spacing(grid);
  PetscReal       lower[2] = {vertex[0], vertex[1]}, upper[2] = {vertex[0], vertex[1]}, x[2];

  PetscFunctionBeginUser;
  PetscCall(Grow(gauge, count));
  for (PetscInt k = 0; k < 2 * count; k++) {
    gauge->sample[k / 2].x[k % 2] = vertex[k];
    lower[k % 2]                  = PetscMin(lower[k % 2], vertex[k]);
    upper[k % 2]                  = PetscMax(upper[k % 2], vertex[k]);
  }
  for (x[1] = lower[1] + 0.5 * apart; x[1] < upper[1]; x[1] += apart) {
    for (x[0] = lower[0] + 0.5 * apart; x[0] < upper[0]; x[0] += apart) {
      if (!Inside(count, vertex, x)) continue;
      PetscCall(Grow(gauge, 1));
      for (PetscInt a = 0; a < 2; a++) gauge->sample[gauge->count - 1].x[a] = x[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Samples of a gauge with these vertices, m. */
static PetscErrorCode AddSamples(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge)
{
  PetscReal s = 0.;

  PetscFunctionBeginUser;
  if (gauge->kind == MPM_GAUGE_PLACE) {
    PetscCall(Grow(gauge, 1));
    for (PetscInt a = 0; a < 2; a++) gauge->sample[0].x[a] = vertex[a];
  } else if (gauge->kind == MPM_GAUGE_OUTLINE) PetscCall(AddOutline(grid, count, vertex, gauge));
  else
    for (PetscInt k = 0; k + 1 < count; k++) PetscCall(AddPiece(grid, &vertex[2 * k], &vertex[2 * k + 2], &s, gauge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One block: exactly one of the kinds. */
static PetscErrorCode ReadGauge(const MpmModel model, const MpmOptions *options, const char name[], MpmGauge *gauge)
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
  PetscInt       count[MPM_GAUGE_KINDS], found = 0;
  PetscReal     *vertex[MPM_GAUGE_KINDS];
  MpmOptions     block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_gauge_%s_", name));
  PetscCall(MpmOptionsHeading(&block, "Gauge (-mpm_physics depth_averaged)"));
  for (PetscInt k = 0; k < MPM_GAUGE_KINDS; k++) {
    PetscCall(MpmOptionsRealList(&block, kinds[k], "m", help[k], MPM_OPTIONAL, &count[k], &vertex[k]));
    if (!count[k]) continue;
    gauge->kind = (MpmGaugeKind)k;
    found++;
  }
  if (!MpmOptionsHelp()) {
    const PetscInt k = (PetscInt)gauge->kind;

    MpmCheckInput(found == 1, "-%splace, line, outline or path: must have one of them", prefix);
    MpmCheckInput(count[k] % 2 == 0 && count[k] >= 2 * least[k] && (k || count[k] == 2),
                  "-%s%s: has %" PetscInt_FMT " numbers, must have %s%" PetscInt_FMT, prefix, kinds[k], count[k],
                  k ? "an even number, at least " : "", 2 * least[k]);
    for (PetscInt c = 0; c < count[k]; c++) {
      MpmCheckInput(vertex[k][c] >= grid->lower[c % 2] && vertex[k][c] <= grid->upper[c % 2],
                    "-%s%s: %g is outside of the grid on axis %c", prefix, kinds[k], (double)vertex[k][c], "xy"[c % 2]);
    }
    PetscCall(AddSamples(grid, count[k] / 2, vertex[k], gauge));
  }
  for (PetscInt k = 0; k < MPM_GAUGE_KINDS; k++) PetscCall(PetscFree(vertex[k]));
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

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "gauges", "names of places, lines, outlines and paths that observe the flow",
                             MPM_OPTIONAL, &gauges->count, &gauges->names));
  PetscCall(PetscCalloc1(gauges->count, &gauges->at));
  for (PetscInt g = 0; g < gauges->count; g++) {
    MpmGauge *gauge = &gauges->at[g];

    gauge->name = gauges->names[g];
    PetscCall(ReadGauge(model, options, gauge->name, gauge));
    if (gauge->kind == MPM_GAUGE_PATH) gauge->kept[0] = gauge->kept[1] = -1.;
  }
  if (gauges->count && !MpmOptionsHelp()) PetscCall(FindSlots(model->disc.grid, gauges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGaugesDestroy(MpmGauges *gauges)
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < gauges->count && gauges->at; g++) PetscCall(PetscFree(gauges->at[g].sample));
  PetscCall(PetscFree(gauges->at));
  PetscCall(PetscFree(gauges->slot));
  PetscCall(PetscFree(gauges->value));
  PetscCall(MpmNamesDestroy(gauges->count, &gauges->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
