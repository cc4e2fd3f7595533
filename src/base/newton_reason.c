/*
  SNES' reasons in words.
*/
#include "talus/compat.h"
#include "base/newton_reason.h"

const char *MpmNewtonReason(SNESConvergedReason reason)
{
  switch (reason) {
  case SNES_DIVERGED_FUNCTION_DOMAIN:
    return "a point had no stress (domain error)";
  case MPM_SNES_DIVERGED_NAN:
    return "the residual was not finite";
  case SNES_DIVERGED_LINEAR_SOLVE:
    return "the linear solver failed";
  case SNES_DIVERGED_MAX_IT:
    return "Newton reached its iteration limit";
  case SNES_DIVERGED_LINE_SEARCH:
    return "the line search failed";
  case SNES_DIVERGED_LOCAL_MIN:
    return "Newton's step does not lower the residual";
  case SNES_DIVERGED_DTOL:
    return "the residual grew without bound";
  default:
    return "Newton did not converge";
  }
}
