#pragma once
/*
  How a law or a physics is differentiated by all that it is given: plain numbers to Reals and back.
  Included by instance.h in the instances with MPM_SENSITIVITY.
*/

/* Room for the Reals of one point; `state` NULL: not wanted. */
typedef struct {
  Real  *parameter, *state_n, *state, *F_n;
  size_t parameter_count, state_size;
} LawRoom;

MPM_FN size_t LawStateSize(const MpmStateVariable *states, size_t count)
{
  size_t size = 0;

  for (size_t s = 0; s < count && states[s].name; ++s) size += states[s].kind == MPM_STATE_SYM ? MPM_SYM : 1;
  return size;
}

/* The columns of `directions` from `first` on that Reals have room for; no directions, or no stride, stand for one. */
MPM_FN RealColumns LawColumns(int first, int directions, int stride)
{
  const int         left    = (directions ? directions : 1) - first;
  const RealColumns columns = {first, left < REAL_DIRECTIONS ? left : REAL_DIRECTIONS, stride ? stride : 1};

  return columns;
}

/* Values with their derivatives in the directions, all 0 where these are NULL */
MPM_FN void LawJoin(size_t count, const double *value, const double *direction, RealColumns columns, Real *joined)
{
  for (size_t k = 0; k < count; ++k)
    joined[k] = direction ? RealLoad(value[k], RealRow(direction, (int)k, columns), columns.count) : value[k];
}

/* The inverse of LawJoin() */
MPM_FN void LawSplit(size_t count, const Real *joined, RealColumns columns, double *value, double *direction)
{
  for (size_t k = 0; k < count; ++k) {
    value[k] = RealValue(joined[k]);
    RealStore(joined[k], RealRow(direction, (int)k, columns), columns.count);
  }
}

/* The point and dF as a kernel sees them, in the given room */
MPM_FN MpmLawPoint LawPointCreate(const MpmLawInput *input, const MpmLawInput *direction, RealColumns columns,
                                  const LawRoom *room, Tensor *dF)
{
  MpmLawPoint point;

  LawJoin(room->parameter_count, input->parameter, direction->parameter, columns, room->parameter);
  LawJoin(room->state_size, input->state_n, direction->state_n, columns, room->state_n);
  LawJoin(MPM_TENSOR, input->F_n, direction->F_n, columns, room->F_n);
  LawJoin(MPM_TENSOR, input->dF, direction->dF, columns, dF->a);
  point.parameter       = room->parameter;
  point.state_n         = room->state_n;
  point.state           = room->state;
  point.F_n             = room->F_n;
  point.dt              = columns.first ? input->dt : RealLoad(input->dt, &direction->dt, 1);
  point.table           = input->table;
  point.table_direction = direction->table;
  point.columns         = columns;
  return point;
}

/* ---- a physics ---- */

/*
  A point as a physics' kernel sees it in these instances: an MpmKernelPoint whose state at the step's start is of
  Reals. The law's history goes from `values` to its place without them.
*/
typedef struct {
  const MpmKernelPoint     *values;
  const MpmKernelDirection *direction;
  RealColumns               columns; /* of the direction's arrays */
  double                   *state;   /* derivatives of the history at the step's end, or NULL */
  double                   *own;     /* and of the physics' own states */
  MpmKernelMaterial         material;
  const Real               *F_n, *stress_n;
  const double             *cell;
  const MpmKernelStage     *stage;
  double                    volume0, dt;
  struct {
    Real *F, *stress;
  } end;
} KernelPoint;

/* Derivatives from the first of the columns on */
MPM_FN const double *LawShift(const double *direction, RealColumns columns)
{
  return direction ? direction + columns.first : NULL;
}

/* The Kirchhoff stress at dF. Non-zero where the law has no answer. */
MPM_FN int LawStress(const KernelPoint *point, const Tensor *dF, Sym *tau)
{
  const MpmKernelPoint     *values    = point->values;
  const MpmKernelDirection *direction = point->direction;
  const RealColumns         columns = point->columns, own = {0, columns.count, columns.stride};
  double                    by[MPM_TENSOR], dby[MPM_TENSOR * MPM_PACK], stress[MPM_SYM], dstress[MPM_SYM * MPM_PACK];
  const MpmLawInput         input      = {.parameter = values->material.parameter,
                                          .table     = values->material.table,
                                          .state_n   = values->state_n,
                                          .F_n       = values->F_n,
                                          .dF        = by,
                                          .dt        = values->stage ? values->stage->span : values->dt};
  const MpmLawInput         along      = {.parameter = LawShift(direction->parameter, columns),
                                          .state_n   = LawShift(direction->state_n, columns),
                                          .F_n       = LawShift(direction->F_n, columns),
                                          .dF        = dby,
                                          .count     = columns.count,
                                          .stride    = columns.stride};
  const MpmLawOutput        value      = {stress, values->end.state};
  const MpmLawOutput        derivative = {dstress, point->state ? point->state + columns.first : NULL};
  const MpmSensitivity      law        = (MpmSensitivity)values->material.law[MPM_FORM_SENSITIVITY];

  LawSplit(MPM_TENSOR, dF->a, own, by, dby);
  if (law(&input, &along, &value, &derivative)) return 1;
  LawJoin(MPM_SYM, stress, dstress, own, tau->a);
  return 0;
}

/* Room for the Reals of a physics' point */
typedef struct {
  Real F_n[MPM_TENSOR], F[MPM_TENSOR], stress[MPM_SYM];
} KernelRoom;

/* The point with Reals, from direction `first` on; `derivative` is NULL where its end is not wanted. */
MPM_FN KernelPoint KernelPointCreate(const MpmKernelPoint *values, const MpmKernelDirection *direction, int first,
                                     const MpmKernelEnd *derivative, KernelRoom *room)
{
  KernelPoint point;

  point.values     = values;
  point.direction  = direction;
  point.columns    = LawColumns(first, direction->count, direction->count);
  point.state      = derivative ? derivative->state : NULL;
  point.own        = derivative ? derivative->own : NULL;
  point.material   = values->material;
  point.F_n        = room->F_n;
  point.stress_n   = NULL;
  point.cell       = values->cell;
  point.stage      = values->stage;
  point.volume0    = values->volume0;
  point.dt         = values->dt;
  point.end.F      = derivative && values->end.F ? room->F : NULL;
  point.end.stress = room->stress;
  LawJoin(MPM_TENSOR, values->F_n, direction->F_n, point.columns, room->F_n);
  return point;
}

/* Number k of an array with its derivatives, 0 where there is no direction */
MPM_FN Real KernelReal(const KernelPoint *point, const double *value, const double *direction, int k)
{
  if (!direction) return value[k];
  return RealLoad(value[k], RealRow(direction, k, point->columns), point->columns.count);
}

/* Number k of an array of a kernel's point, or of its first stage */
#define KernelAt(point_, array_, k_) KernelReal(point_, (point_)->values->array_, (point_)->direction->array_, k_)
#define KernelStageAt(point_, array_, k_) \
  KernelReal(point_, (point_)->stage->array_, (point_)->direction->stage.array_, k_)

/* Keeps a state of the physics' own at the step's end, where it is wanted. */
MPM_FN void KernelKeepOwn(const KernelPoint *point, int k, Real value)
{
  if (!point->own) return;
  point->values->end.own[k] = RealValue(value);
  RealStore(value, RealRow(point->own, k, point->columns), point->columns.count);
}

/* One of the law's moduli, MpmModuliSensitivity, at the step's start */
MPM_FN Real KernelModulus(const KernelPoint *point, int k)
{
  const MpmKernelPoint *values  = point->values;
  const RealColumns     columns = point->columns, own = {0, columns.count, columns.stride};
  const MpmLawInput     input = {.parameter = values->material.parameter,
                                 .table     = values->material.table,
                                 .state_n   = values->state_n,
                                 .F_n       = values->F_n};
  const MpmLawInput     along = {.parameter = LawShift(point->direction->parameter, columns),
                                 .state_n   = LawShift(point->direction->state_n, columns),
                                 .F_n       = LawShift(point->direction->F_n, columns),
                                 .count     = columns.count,
                                 .stride    = columns.stride};
  double                value[3], derivative[3 * MPM_PACK];

  values->material.info->moduli_sensitivity(&input, &along, value, derivative);
  return RealLoad(value[k], RealRow(derivative, k, own), own.count);
}

/* F and stress of the step's end, where they are wanted. */
MPM_FN void KernelSplitEnd(const KernelPoint *point, const MpmKernelEnd *derivative)
{
  if (!point->end.F) return;
  LawSplit(MPM_TENSOR, point->end.F, point->columns, point->values->end.F, derivative->F);
  LawSplit(MPM_SYM, point->end.stress, point->columns, point->values->end.stress, derivative->stress);
}
