#pragma once
/*
  How a law or a physics is differentiated by all that it is given, in one direction: plain numbers to Reals and back.
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

/* Values with their derivatives in the direction, all 0 where that is NULL */
MPM_FN void LawJoin(size_t count, const double *value, const double *direction, Real *joined)
{
  for (size_t k = 0; k < count; ++k) joined[k] = RealAlong(value[k], direction ? direction[k] : 0.);
}

/* The inverse of LawJoin() */
MPM_FN void LawSplit(size_t count, const Real *joined, double *value, double *direction)
{
  for (size_t k = 0; k < count; ++k) {
    value[k]     = RealValue(joined[k]);
    direction[k] = RealDirection(joined[k]);
  }
}

/* The point and dF as a kernel sees them, in the given room */
MPM_FN MpmLawPoint LawPointCreate(const MpmLawInput *input, const MpmLawInput *direction, const LawRoom *room,
                                  Tensor *dF)
{
  MpmLawPoint point;

  LawJoin(room->parameter_count, input->parameter, direction->parameter, room->parameter);
  LawJoin(room->state_size, input->state_n, direction->state_n, room->state_n);
  LawJoin(MPM_TENSOR, input->F_n, direction->F_n, room->F_n);
  LawJoin(MPM_TENSOR, input->dF, direction->dF, dF->a);
  point.parameter       = room->parameter;
  point.state_n         = room->state_n;
  point.state           = room->state;
  point.F_n             = room->F_n;
  point.dt              = RealAlong(input->dt, direction->dt);
  point.table           = input->table;
  point.table_direction = direction->table;
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
  double                   *state; /* derivatives of the history at the step's end, or NULL */
  MpmKernelMaterial         material;
  const Real               *F_n, *stress_n;
  double                    volume0;
  struct {
    Real *F, *stress;
  } end;
} KernelPoint;

/* The Kirchhoff stress at dF. Non-zero where the law has no answer. */
MPM_FN int LawStress(const KernelPoint *point, const Tensor *dF, Sym *tau)
{
  const MpmKernelPoint     *values    = point->values;
  const MpmKernelDirection *direction = point->direction;
  double                    by[2][MPM_TENSOR], stress[2][MPM_SYM];
  const MpmLawInput         input = {.parameter = values->material.parameter,
                                     .table     = values->material.table,
                                     .state_n   = values->state_n,
                                     .F_n       = values->F_n,
                                     .dF        = by[0],
                                     .dt        = values->stage ? values->stage->span : values->dt};
  const MpmLawInput         along = {
            .parameter = direction->parameter, .state_n = direction->state_n, .F_n = direction->F_n, .dF = by[1]};
  const MpmLawOutput   value = {stress[0], values->end.state}, derivative = {stress[1], point->state};
  const MpmSensitivity law = (MpmSensitivity)values->material.law[MPM_FORM_SENSITIVITY];

  LawSplit(MPM_TENSOR, dF->a, by[0], by[1]);
  if (law(&input, &along, &value, &derivative)) return 1;
  LawJoin(MPM_SYM, stress[0], stress[1], tau->a);
  return 0;
}

/* The point with Reals, in the given room; `derivative`, F and `stress` are NULL where its end is not wanted. */
MPM_FN KernelPoint KernelPointCreate(const MpmKernelPoint *values, const MpmKernelDirection *direction,
                                     const MpmKernelEnd *derivative, Real *F_n, Real *F, Real *stress)
{
  const KernelPoint point = {.values    = values,
                             .direction = direction,
                             .state     = derivative ? derivative->state : NULL,
                             .material  = values->material,
                             .F_n       = F_n,
                             .volume0   = values->volume0,
                             .end       = {F && values->end.F ? F : NULL, stress}};

  LawJoin(MPM_TENSOR, values->F_n, direction->F_n, F_n);
  return point;
}

/* F and stress of the step's end, where they are wanted. */
MPM_FN void KernelSplitEnd(const KernelPoint *point, const MpmKernelEnd *derivative)
{
  if (!point->end.F) return;
  LawSplit(MPM_TENSOR, point->end.F, point->values->end.F, derivative->F);
  LawSplit(MPM_SYM, point->end.stress, point->values->end.stress, derivative->stress);
}
