/*
  The auxiliary law in place of all materials in the balance of k0 (k0_balance.c): for any strain, its stress keeps the
  ratio k0 of the horizontal stresses to the vertical one.

    e = sym(F_{n+1} - F_n),   sigma = sigma_n + M (m (m.e) + e_shear + r e),   m = 1 up the vertical axis, k0 across it

  sigma_n  stress at the step's start, given as history like k0, Pa; M a modulus, Pa; e_shear: components of e off the
           diagonal; r a small number that keeps the tangent regular, with a negligible share of the stress

  Equilibrium under this law is the smallest change of stress, in the sum of V (change^2), that brings balance and keeps
  the ratio; displacements are its multipliers. Linear, of small strain in the physics' sense; no law for scenes.
*/
#include "talus/point/law.h"

enum { DENSITY, MODULUS, AXIS, REGULAR };

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 1, 0., HUGE_VAL, 0, "mass density", NULL, 0., NULL},
  {MPM_NUMBER, "modulus", "Pa", 0., 1, 0., HUGE_VAL, 1, "modulus", NULL, 0., NULL},
  {MPM_NUMBER, "axis", "-", 0., 1, 0., 2., 0, "the vertical one", NULL, 0., NULL},
  {MPM_NUMBER, "regular", "-", 0., 1, 0., 1., 0, "part of an isotropic stiffness", NULL, 0., NULL},
};

enum { STATE_STRESS = 0, STATE_RATIO = MPM_SYM };

static const MpmStateVariable states[] = {{"stress", MPM_STATE_SYM, 0., "Pa"}, {"ratio", MPM_STATE_SCALAR, 1., "-"}};

MPM_FN double Stiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  (void)table, (void)state, (void)F;
  return parameter[MODULUS];
}

MPM_FN double ShearModulus(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  (void)table, (void)state, (void)F;
  return 0.5 * parameter[MODULUS];
}

MPM_FN int MpmMaterialEvaluate_k0(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real *parameter = point->parameter;
  const int   axis      = (int)RealValue(parameter[AXIS]);
  const Sym   sigma_n   = SymLoad(&point->state_n[STATE_STRESS]);
  const Real  ratio     = point->state_n[STATE_RATIO];
  Tensor      H         = *dF;
  Scalar      along     = ScalarConstant(0.);
  Sym         e;

  for (int a = 0; a < MPM_NORMALS; a++) H.a[MPM_NORMAL_AT(a)] = ScalarShift(H.a[MPM_NORMAL_AT(a)], -1.);
  H = TensorMulArray(&H, point->F_n);
  e = SymFromTensor(&H);
#if MPM_NORMALS == 2
  e.a[2] = ScalarConstant(0.);
#endif
  for (int a = 0; a < MPM_NORMALS; a++) ScalarAddScaled(&along, a == axis ? 1. : ratio, &e.a[a]);
  *tau = SymScaleBy(parameter[REGULAR] * parameter[MODULUS], &e);
  for (int a = 0; a < 3; a++) ScalarAddScaled(&tau->a[a], parameter[MODULUS] * (a == axis ? 1. : ratio), &along);
  for (int c = 3; c < (MPM_DIM == 2 ? 4 : 6); c++) ScalarAddScaled(&tau->a[c], parameter[MODULUS], &e.a[c]);
  *tau = SymAdd(tau, &sigma_n);
  if (point->state) {
    SymStore(&point->state[STATE_STRESS], tau);
    point->state[STATE_RATIO] = ratio;
  }
  return 0;
}

MPM_LAW_DEFINE(k0_law, parameters, states, MpmMaterialEvaluate_k0, .summary = "stress increments with a fixed ratio",
               .traits = MPM_LAW_SYMMETRIC | MPM_LAW_SMALL_STRAIN | MPM_LAW_INTERNAL, .stiffness = Stiffness,
               .shear_modulus = ShearModulus)
