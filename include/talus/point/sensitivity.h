#pragma once
/*
  How a law is differentiated by all that it is given, in one direction: plain numbers to Reals and back. Included by
  instance.h in the instances with MPM_SENSITIVITY.
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
