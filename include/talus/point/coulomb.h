#pragma once
/*
  Mohr-Coulomb's planes with a tension cut-off in principal stresses t1 >= t2 >= t3, and the return to them, for any
  measure of stress. Included by files in materials/.

    f = t1 - t3 + (t1 + t3) sin phi - 2 c cos phi <= 0,   t1 <= tension
    flow potential of f: the same with psi in place of phi; the cut-off's is t1 itself

  Return: t = t_trial - C sum_i dg_i r_i, dg_i >= 0, C being Hooke's law, where the active planes n_i . t = h_i of the
  list

    13, 13 and 12, 13 and 23, tension 1, 13 and tension 1, tension 1 and 2, and the corners: apex t = c cot phi; with a
    tension strength below that, (T, T, T), (T, S, S), (T, T, S), S = ((1 + sin phi) T - 2 c cos phi)/(1 - sin phi)

  are the first that leave no plane violated. The regions of trial stress that belong to them are those of the closest
  point where psi = phi; where psi < phi they still fill the space of trial stress without overlap. With psi = 0 no flow
  leads to the apex, a tension cut-off. Each region's return is linear, so it is exact.

  Source: de Souza Neto, Peric and Owen (2008), doi:10.1002/9780470694626, section 8.2; Koiter (1953), Quarterly of
  Applied Mathematics 11, 350-354, for edges.
*/
#include "elasticity.h"

/* ---- strength ---- */

typedef struct {
  Dual sin_phi;
  Dual shear;   /* 2 c cos phi */
  Dual tension; /* used where `cut` */
  int  cut;
} CoulombStrength;

/* From cohesion and friction angle, radians */
MPM_FN CoulombStrength CoulombStrengthCreate(Dual cohesion, Dual phi)
{
  CoulombStrength strength;

  strength.sin_phi = DualSin(phi);
  strength.shear   = DualScale(2., DualMul(cohesion, DualCos(phi)));
  strength.cut     = 0;
  strength.tension = DualConstant(0.);
  return strength;
}

/* By how much principal values, largest first, exceed the strength; negative inside */
MPM_FN double CoulombExcess(const CoulombStrength *strength, double t1, double t3)
{
  const double f = t1 - t3 + (t1 + t3) * DualValue(strength->sin_phi) - DualValue(strength->shear);

  return strength->cut ? fmax(f, t1 - DualValue(strength->tension)) : f;
}

/* Excess that rounding alone explains */
MPM_FN double CoulombNoise(Lame lame)
{
  return ELASTIC_STRAIN_NOISE * RealValue(lame.lambda + 2. * lame.mu);
}

/*
  True where a stress is surely inside, by its invariants p and root = sqrt(J2): t1 - t3 = 2 sqrt(J2) cos(theta), t1 +
  t3 = 2 p - (2/sqrt 3) sqrt(J2) sin(theta) with Lode's angle theta make f at most 2 (p sin phi + sqrt(J2) sqrt(1 +
  sin^2(phi)/3)) - 2 c cos phi.
*/
MPM_FN int CoulombIsSurelyInside(const CoulombStrength *strength, double p, double root)
{
  const double sine = DualValue(strength->sin_phi);

  return 2. * (p * sine + root * sqrt(1. + sine * sine / 3.)) <= DualValue(strength->shear) &&
         (!strength->cut || p + 2. / sqrt(3.) * root <= DualValue(strength->tension));
}

/* ---- return in principal stresses ---- */

/*
  The planes: of Mohr-Coulomb between principal values i > j, n = (1 + sin phi) e_i - (1 - sin phi) e_j, and of tension,
  n = e_i. The decrease of stress by flow is C r: along i, along j, and along the third.
*/
typedef enum { COULOMB_13, COULOMB_12, COULOMB_23, COULOMB_TENSION_1, COULOMB_TENSION_2, COULOMB_NONE } CoulombPlane;

typedef struct {
  Lame lame;
  Dual plus, minus;                /* 1 + sin phi, 1 - sin phi */
  Dual sin_psi, at_i, at_j, third; /* of C r */
} CoulombFlow;

MPM_FN CoulombFlow CoulombFlowCreate(Lame lame, const CoulombStrength *strength, Dual sin_psi)
{
  CoulombFlow flow;

  flow.lame    = lame;
  flow.plus    = DualShift(strength->sin_phi, 1.);
  flow.minus   = DualNeg(DualShift(strength->sin_phi, -1.));
  flow.sin_psi = sin_psi;
  flow.third   = DualScale(2. * flow.lame.lambda, flow.sin_psi);
  flow.at_i    = DualAdd(flow.third, DualScale(2. * flow.lame.mu, DualShift(flow.sin_psi, 1.)));
  flow.at_j    = DualAdd(flow.third, DualScale(2. * flow.lame.mu, DualShift(flow.sin_psi, -1.)));
  return flow;
}

MPM_FN int CoulombPlaneMajor(CoulombPlane plane)
{
  return plane == COULOMB_23 || plane == COULOMB_TENSION_2 ? 1 : 0;
}

MPM_FN int CoulombPlaneMinor(CoulombPlane plane)
{
  return plane == COULOMB_12 ? 1 : 2;
}

/* n . v */
MPM_FN Dual CoulombPlaneNormal(const CoulombFlow *flow, CoulombPlane plane, const Dual v[3])
{
  if (plane >= COULOMB_TENSION_1) return v[CoulombPlaneMajor(plane)];
  return DualSub(DualMul(flow->plus, v[CoulombPlaneMajor(plane)]), DualMul(flow->minus, v[CoulombPlaneMinor(plane)]));
}

/* C r */
MPM_FN void CoulombPlaneFlow(const CoulombFlow *flow, CoulombPlane plane, Dual v[3])
{
  const int  i = CoulombPlaneMajor(plane), j = CoulombPlaneMinor(plane);
  const Real lambda = flow->lame.lambda, mu = flow->lame.mu;

  for (int k = 0; k < 3; ++k) {
    if (plane >= COULOMB_TENSION_1) v[k] = DualConstant(k == i ? lambda + 2. * mu : lambda);
    else v[k] = k == i ? flow->at_i : k == j ? flow->at_j : flow->third;
  }
}

/* C^-1 t in principal values */
MPM_FN void CoulombPrincipalStrain(Lame lame, const Dual t[3], Dual v[3])
{
  const Real factor = lame.lambda / (3. * lame.lambda + 2. * lame.mu);
  const Dual mean   = DualScale(factor, DualAdd(DualAdd(t[0], t[1]), t[2]));

  for (int a = 0; a < 3; ++a) v[a] = DualScale(0.5 / lame.mu, DualSub(t[a], mean));
}

/* Takes t to one plane, or to two, along their flow. Returns the lesser multiplier, times 2 mu. */
MPM_FN double CoulombReturnToPlanes(const CoulombStrength *strength, const CoulombFlow *flow,
                                    const CoulombPlane plane[2], Dual t[3])
{
  const int count = plane[1] == COULOMB_NONE ? 1 : 2;
  Dual      lost[2][3], a[2][2], f[2], dg[2];
  double    least = HUGE_VAL;

  for (int i = 0; i < count; ++i) {
    CoulombPlaneFlow(flow, plane[i], lost[i]);
    f[i] = DualSub(CoulombPlaneNormal(flow, plane[i], t),
                   plane[i] >= COULOMB_TENSION_1 ? strength->tension : strength->shear);
  }
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) a[i][j] = CoulombPlaneNormal(flow, plane[i], lost[j]);
  if (count == 1) {
    dg[0] = DualDiv(f[0], a[0][0]);
  } else {
    const Dual det = DualSub(DualMul(a[0][0], a[1][1]), DualMul(a[0][1], a[1][0]));

    dg[0] = DualDiv(DualSub(DualMul(a[1][1], f[0]), DualMul(a[0][1], f[1])), det);
    dg[1] = DualDiv(DualSub(DualMul(a[0][0], f[1]), DualMul(a[1][0], f[0])), det);
  }
  for (int i = 0; i < count; ++i) {
    least = fmin(least, 2. * RealValue(flow->lame.mu) * DualValue(dg[i]));
    for (int k = 0; k < 3; ++k) t[k] = DualSub(t[k], DualMul(dg[i], lost[i][k]));
  }
  return least;
}

/* The corner to which no other region leads. Non-zero where there is none: without friction. */
MPM_FN int CoulombReturnToCorner(const CoulombStrength *strength, const CoulombFlow *flow, Dual t[3])
{
  const Dual   T  = strength->tension;
  const double up = 1. + DualValue(flow->sin_psi), down = 1. - DualValue(flow->sin_psi);
  Dual         S, out[3], v[3];

  if (!strength->cut) {
    if (!(DualValue(strength->sin_phi) > 0.)) return 1;
    t[0] = t[1] = t[2] = DualDiv(DualScale(0.5, strength->shear), strength->sin_phi);
    return 0;
  }
  for (int a = 0; a < 3; ++a) out[a] = DualSub(t[a], T);
  CoulombPrincipalStrain(flow->lame, out, v);
  t[0] = t[1] = t[2] = T;
  if (DualValue(v[0]) >= 0. && DualValue(v[1]) >= 0. && DualValue(v[2]) >= 0.) return 0;
  S = DualDiv(DualSub(DualMul(flow->plus, T), strength->shear), flow->minus);
  /* multipliers of tension 1, 13 and 12 at (T, S, S) */
  for (int a = 1; a < 3; ++a) out[a] = DualAdd(out[a], DualSub(T, S));
  CoulombPrincipalStrain(flow->lame, out, v);
  t[2] = S;
  if (DualValue(v[1]) <= 0. && DualValue(v[0]) + up / down * (DualValue(v[1]) + DualValue(v[2])) >= 0.) t[1] = S;
  return 0;
}

/* Takes principal stresses t, largest first, to the yield surface, of which they are outside. */
MPM_FN int CoulombReturn(const CoulombStrength *strength, const CoulombFlow *flow, Dual t[3])
{
  const CoulombPlane list[6][2] = {{COULOMB_13, COULOMB_NONE},      {COULOMB_13, COULOMB_12},
                                   {COULOMB_13, COULOMB_23},        {COULOMB_TENSION_1, COULOMB_NONE},
                                   {COULOMB_13, COULOMB_TENSION_1}, {COULOMB_TENSION_1, COULOMB_TENSION_2}};
  const double       size       = fabs(DualValue(t[0])) + fabs(DualValue(t[2])) + DualValue(strength->shear);

  for (int k = 0; k < (strength->cut ? 6 : 3); ++k) {
    Dual   s[3];
    double fault;

    for (int a = 0; a < 3; ++a) s[a] = t[a];
    fault = -CoulombReturnToPlanes(strength, flow, list[k], s);
    fault = fmax(fault, fmax(DualValue(s[1]) - DualValue(s[0]), DualValue(s[2]) - DualValue(s[1])));
    fault = fmax(fault, CoulombExcess(strength, DualValue(s[0]), DualValue(s[2])));
    if (!(fault <= 1e-12 * size)) continue; /* one of two neighbours takes what lies between them */
    for (int a = 0; a < 3; ++a) t[a] = s[a];
    return 0;
  }
  return CoulombReturnToCorner(strength, flow, t);
}

/* sqrt(2/3) |de_p| of a return: the growth of the equivalent plastic strain */
MPM_FN Dual CoulombPlasticStrain(Lame lame, const Dual trial[3], const Dual t[3])
{
  Dual lost[3], v[3], square;

  for (int a = 0; a < 3; ++a) lost[a] = DualSub(trial[a], t[a]);
  CoulombPrincipalStrain(lame, lost, v);
  square = DualScale(2. / 3., DualAdd(DualAdd(DualSquare(v[0]), DualSquare(v[1])), DualSquare(v[2])));
  return DualValue(square) > 0. ? DualSqrt(square) : DualConstant(0.);
}
