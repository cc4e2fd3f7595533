/*
  Gauges at each state: columns of the history, tables of paths, entries of the summary.

  Depth at a sample is bilinear between the nodes, its velocity the mean by depth. The discharge through a line is the
  integral of depth times the velocity across it; the angle of reach is that of the line from the bed where the flow
  began to the bed of the furthest place.
*/
#include "io/io.h"
#include "maps/bed.h"
#include "space/space.h"
#include "runout/runout_impl.h"

/* Numbers of a node among the values. */
enum { DEPTH, FLOW, SPEED = FLOW + 2, PRESSURE };

/* Depth, depth times velocity, and mean speed and pressure by depth at a sample. */
static void TakeSample(const MpmGauges *gauges, const MpmSample *sample, PetscReal value[MPM_GAUGE_VALUES])
{
  for (PetscInt k = 0; k < MPM_GAUGE_VALUES; k++) value[k] = 0.;
  for (PetscInt c = 0; c < 4; c++) {
    const PetscReal *node = &gauges->value[sample->slot[c] * MPM_GAUGE_VALUES], w = sample->weight[c];

    for (PetscInt k = 0; k < SPEED; k++) value[k] += w * node[k];
    for (PetscInt k = SPEED; k < MPM_GAUGE_VALUES; k++) value[k] += w * node[DEPTH] * node[k];
  }
  for (PetscInt k = SPEED; k < MPM_GAUGE_VALUES; k++) value[k] = value[DEPTH] > 0. ? value[k] / value[DEPTH] : 0.;
}

/* The state at the nodes about the samples, on all ranks. */
static PetscErrorCode FindValues(MpmModel model, MpmGauges *gauges)
{
  const PetscInt count = gauges->slots * MPM_GAUGE_VALUES;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(gauges->value, count));
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    const PetscInt slot = gauges->slot[MpmRunoutLatticeNode(model, i)];
    PetscReal     *value;
    MpmNodeFlow    flow;

    if (slot < 0) continue;
    MpmRunoutNode(model, i, &flow);
    value           = &gauges->value[slot * MPM_GAUGE_VALUES];
    value[DEPTH]    = flow.depth;
    value[FLOW]     = flow.depth * flow.velocity[0];
    value[FLOW + 1] = flow.depth * flow.velocity[1];
    value[SPEED]    = flow.speed;
    value[PRESSURE] = flow.pressure;
  }
  if (model->size > 1)
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, gauges->value, (PetscMPIInt)count, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One gauge in a state that lasts for dt. */
static void Observe(const MpmModel model, PetscReal dt, MpmGauge *gauge)
{
  const MpmGauges *gauges = &model->runout->gauges;

  for (PetscInt k = 0; k < MPM_GAUGE_NUMBERS; k++) gauge->now[k] = 0.;
  for (PetscInt k = 0; k < gauge->count; k++) {
    const MpmSample *sample = &gauge->sample[k];
    PetscReal        value[MPM_GAUGE_VALUES];

    TakeSample(gauges, sample, value);
    if (gauge->kind == MPM_GAUGE_LINE)
      gauge->now[0] += value[FLOW] * sample->normal[0] + value[FLOW + 1] * sample->normal[1];
    else if (gauge->kind == MPM_GAUGE_PATH) {
      if (!(value[DEPTH] > model->runout->peaks.least)) continue;
      gauge->kept[0] = gauge->kept[0] < 0. ? sample->s : PetscMin(gauge->kept[0], sample->s);
      gauge->kept[1] = PetscMax(gauge->kept[1], sample->s);
    } else {
      gauge->now[0] = value[DEPTH];
      gauge->now[1] = value[SPEED];
      gauge->now[2] = value[PRESSURE];
    }
    for (PetscInt c = 0; gauge->kind == MPM_GAUGE_OUTLINE && c < MPM_GAUGE_NUMBERS; c++)
      if (!c || value[DEPTH] > model->runout->peaks.least) gauge->kept[c] = PetscMax(gauge->kept[c], gauge->now[c]);
  }
  if (gauge->kind == MPM_GAUGE_LINE) {
    gauge->kept[0] += 0.5 * gauge->kept[1] * (gauge->kept[2] + gauge->now[0]); /* the step before, by both its ends */
    gauge->kept[1] = dt;
    gauge->kept[2] = gauge->now[0];
  }
}

PetscErrorCode MpmGaugesObserve(MpmModel model, PetscReal dt)
{
  MpmGauges *gauges = &model->runout->gauges;

  PetscFunctionBeginUser;
  PetscCall(FindValues(model, gauges));
  for (PetscInt g = 0; g < gauges->count; g++) Observe(model, dt, &gauges->at[g]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- paths ---- */

/* Bed at the sample of a path that stands at s. */
static PetscReal BedAlong(const MpmModel model, const MpmGauge *gauge, PetscReal s)
{
  PetscInt k = 0;

  while (k + 1 < gauge->count && gauge->sample[k].s < s) k++;
  return MpmBedHeight(model->scene.deformation.bed, gauge->sample[k].x);
}

/* Way, drop, m, and angle, degrees, of a path's flow; 0 before there is one. */
static void Reach(const MpmModel model, const MpmGauge *gauge, PetscReal *way, PetscReal *drop, PetscReal *angle)
{
  *way = *drop = *angle = 0.;
  if (gauge->kept[0] < 0.) return;
  *way   = gauge->kept[1] - gauge->kept[0];
  *drop  = BedAlong(model, gauge, gauge->kept[0]) - BedAlong(model, gauge, gauge->kept[1]);
  *angle = 180. / PETSC_PI * PetscAtanReal(*way > 0. ? *drop / *way : 0.);
}

PetscErrorCode MpmRunoutSummary(const MpmModel model, char **text)
{
  PetscInt any = 0;

  PetscFunctionBeginUser;
  *text = NULL;
  if (!model->runout) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt g = 0; g < model->runout->gauges.count; g++) {
    const MpmGauge *gauge = &model->runout->gauges.at[g];
    PetscReal       way, drop, angle;

    if (gauge->kind != MPM_GAUGE_PATH) continue;
    Reach(model, gauge, &way, &drop, &angle);
    PetscCall(MpmTextAppend(text, "%s\"%s\": {\"way\": %.9g, \"drop\": %.9g, \"angle\": %.9g}", any++ ? ", " : "",
                            gauge->name, (double)way, (double)drop, (double)angle));
  }
  if (model->runout->rest >= 0.)
    PetscCall(MpmTextAppend(text, "%s\"rest\": %.9g", any ? ", " : "", (double)model->runout->rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of a path's table; `largest` is on rank 0. */
static PetscErrorCode WriteRows(MpmModel model, const MpmGauge *gauge, const PetscReal largest[], MpmHistory table)
{
  const PetscInt nodes = model->runout->peaks.count;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < gauge->count; k++) {
    const MpmSample *sample = &gauge->sample[k];
    PetscReal        row[4 + MPM_PEAK_COUNT + 1], last[MPM_GAUGE_VALUES];

    row[0] = sample->s;
    for (PetscInt a = 0; a < 2; a++) row[1 + a] = sample->x[a] + model->scene.deformation.bed->map.origin[a];
    row[3] = MpmBedHeight(model->scene.deformation.bed, sample->x);
    for (PetscInt c = 0; c < MPM_PEAK_COUNT; c++)
      row[4 + c] = model->rank ? 0. : MpmLatticeAt(model->disc.grid, &largest[c * nodes], sample->x);
    TakeSample(&model->runout->gauges, sample, last);
    row[4 + MPM_PEAK_COUNT] = last[DEPTH];
    PetscCall(MpmHistoryAppend(table, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGaugesWrite(MpmModel model)
{
  static const char *const names[] = {"s", "x", "y", "bed", "depth", "speed", "pressure", "deposit"};
  const MpmGauges         *gauges  = &model->runout->gauges;
  PetscReal               *largest = NULL, *arrival = NULL;
  PetscBool                gathered = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < gauges->count; g++) {
    char       path[PETSC_MAX_PATH_LEN];
    MpmHistory table;

    if (gauges->at[g].kind != MPM_GAUGE_PATH) continue;
    if (!gathered) PetscCall(MpmPeaksGather(model, &largest, &arrival));
    gathered = PETSC_TRUE;
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s_gauge_%s.csv", model->scene.name.prefix, gauges->at[g].name));
    PetscCall(MpmHistoryCreate(model->comm, path, PETSC_STATIC_ARRAY_LENGTH(names), names, &table));
    PetscCall(WriteRows(model, &gauges->at[g], largest, table));
    PetscCall(MpmHistoryDestroy(&table));
  }
  PetscCall(PetscFree(largest));
  PetscCall(PetscFree(arrival));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns ---- */

static PetscErrorCode Fill(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmGauge *gauge = &model->runout->gauges.at[column->index];
  PetscReal       drop;

  PetscFunctionBeginUser;
  if (gauge->kind == MPM_GAUGE_PATH) Reach(model, gauge, &values[0], &drop, &values[1]);
  else if (gauge->kind == MPM_GAUGE_LINE) {
    values[0] = gauge->now[0];
    values[1] = gauge->kept[0] + gauge->kept[1] * gauge->kept[2];
  } else PetscCall(PetscArraycpy(values, gauge->kind == MPM_GAUGE_PLACE ? gauge->now : gauge->kept, MPM_GAUGE_NUMBERS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const flow[] = {"depth", "speed", "pressure"}, *const line[] = {"discharge", "volume"},
                           *const path[]                 = {"way", "angle"};
  static const char *const *const parts[MPM_GAUGE_KINDS] = {flow, line, flow, path};
  static const PetscInt           count[MPM_GAUGE_KINDS] = {3, 2, 3, 2};
  static const char *const        unit[MPM_GAUGE_KINDS]  = {"m, m/s, Pa", "m3/s, m3", "m, m/s, Pa", "m, degrees"};

  PetscFunctionBeginUser;
  if (!model->runout) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt g = 0; g < model->runout->gauges.count; g++) {
    const MpmGaugeKind kind = model->runout->gauges.at[g].kind;
    const MpmColumn    row  = {"gauge", unit[kind], count[kind], parts[kind], Fill, NULL, g};

    PetscCall(MpmColumnsAdd(columns, model->runout->gauges.at[g].name, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
