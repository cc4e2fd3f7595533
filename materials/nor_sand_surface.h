#pragma once
/*
  Nor-Sand's yield surface, its flow and its image condition; notation and sources in nor_sand.c.
*/
#include "talus/point/implicit.h"
#include "talus/point/series.h"

enum {
  DENSITY,
  KAPPA,
  SHEAR,
  CRITICAL_RATIO,
  CURVATURE,
  BETA,
  LAMBDA,
  V_C0,
  HARDENING,
  SPECIFIC_VOLUME,
  IMAGE_PRESSURE,
  PRECONSOLIDATION,
  OCR,
  POP,
  REFERENCE_PRESSURE
};

#define LIMIT_SLOPE 3.5  /* -alpha beta: what ties the most dilation to psi_i */
#define POLE_MARGIN 0.1  /* 1 + N s below which the limit of the image pressure is continued */
#define LARGEST_LOG 600. /* |ln p/p_ref| beyond which there is no answer */

/* ---- in y = ln(p/-p_ref) and L = ln(p/p_i) ---- */

/* Data of a step */
typedef struct {
  const MpmLawPoint *point;
  Real               log_image; /* ln(p_i/-p_ref) at the step's start */
  Real               line;      /* psi_i - v - lambda ln(p_i/p_ref) */
} Step;

/* df/dp */
MPM_FN Dual Dilatancy(const Real *parameter, Dual L)
{
  const Real rest = 1. - parameter[CURVATURE];

  return DualScale(-parameter[CRITICAL_RATIO] / rest,
                   DualMul(L, DualExpm1Ratio(DualScale(parameter[CURVATURE] / rest, L))));
}

/* eta of df/dp */
MPM_FN Dual StressRatio(const Real *parameter, Dual dilatancy)
{
  return DualShift(DualScale(1. - parameter[CURVATURE], dilatancy), parameter[CRITICAL_RATIO]);
}

/* L where eta = 0: where the yield surface meets the axis of pressure */
MPM_FN Dual TipRatio(const Real *parameter)
{
  return DualLog1pRatio(DualConstant(parameter[CURVATURE] / (1. - parameter[CURVATURE])));
}

/* ln(p_l/p) */
MPM_FN Dual LimitRatio(const Step *step, Dual v, Dual log_image)
{
  const Real *parameter = step->point->parameter, N = parameter[CURVATURE];
  const Dual  psi    = DualShift(DualAdd(v, DualScale(parameter[LAMBDA], log_image)), step->line);
  const Dual  s      = DualScale(LIMIT_SLOPE / (parameter[BETA] * parameter[CRITICAL_RATIO]), psi);
  const Dual  scaled = DualScale(N, s);

  if (1. + DualValue(scaled) > POLE_MARGIN) return DualScale(N - 1., DualMul(s, DualLog1pRatio(scaled)));
  {
    const Real power = (N - 1.) / N; /* N is not 0 here */
    const Dual below = DualShift(DualScale(1. / POLE_MARGIN, DualShift(scaled, 1.)), -1.);

    return DualShift(DualLog1p(DualScale(power, below)), power * log(POLE_MARGIN));
  }
}

/* Inputs: e_v and e_s of the trial state, v at the step's end */
enum { IN_VOLUME, IN_SHEAR, IN_V, INPUTS };

/* ln(p_i,n/p_i + h dg p_l/p_i) - ln(1 + h dg) = ln(p_i,n/p_i) + ln(1 + h dg/(1 + h dg) (p_l/p_i,n - 1)) */
MPM_FN Dual HardeningResidual(const Step *step, Dual v, Dual dg, Dual y, Dual L)
{
  const Dual grown = DualScale(step->point->parameter[HARDENING], dg), z = DualSub(y, L);
  const Dual before = DualShift(DualNeg(z), step->log_image);
  const Dual drawn  = DualSub(DualAdd(L, LimitRatio(step, v, z)), before); /* ln(p_l/p_i,n) */
  const Dual weight = DualDiv(grown, DualShift(grown, 1.));

  if (DualValue(drawn) > LARGEST_LOG) return DualAdd(before, DualAdd(drawn, DualLog(weight)));
  return DualAdd(before, DualLog1p(DualMul(weight, DualExpm1(drawn))));
}

/* y that the elastic volume strain has after plastic flow dg */
MPM_FN Dual LogPressure(const Real *parameter, Dual volume, Dual dg, Dual dilatancy)
{
  const Dual plastic = DualScale(parameter[BETA], DualMul(dg, dilatancy));

  return DualScale(1. / parameter[KAPPA], DualSub(plastic, volume));
}

/* e_s of a stress on the yield surface */
MPM_FN Dual ShearOnSurface(const Real *parameter, Dual y, Dual dilatancy)
{
  return DualScale(parameter[REFERENCE_PRESSURE] / (3. * parameter[SHEAR]),
                   DualMul(StressRatio(parameter, dilatancy), DualExp(y)));
}

/* L of a stress ratio eta, the inverse of StressRatio() */
MPM_FN Dual RatioOnSurface(const Real *parameter, Dual eta)
{
  const Dual part = DualScale(1. / parameter[CRITICAL_RATIO], eta);
  const Dual down = DualMul(part, DualLog1pRatio(DualScale(-parameter[CURVATURE], part)));

  return DualSub(TipRatio(parameter), DualScale(1. - parameter[CURVATURE], down));
}
