/*
  Linear elasticity at small strain. Also the template for a new law: materials/README.md says how to use it.

    eps = sym(F - I),   sigma = lambda tr(eps) I + 2 mu eps

  sigma  stress, tension positive, Pa; no distinction between Kirchhoff and Cauchy stress at small strain
  F      deformation gradient, dx/dX; plane strain has eps_zz = 0 and keeps sigma_zz

  Not objective: a rotation by an angle a gives strains of about a^2/2. Use `hencky` where rotations matter.

  Source: Timoshenko and Goodier (1970), Theory of Elasticity, 3rd edition, McGraw-Hill, chapter 1.
*/
#include "talus/point/elasticity.h" /* brings law.h, and with it tensor.h, dual.h and real.h */

/* The options -mpm_material_<name>_<parameter>, in the order in which the kernel finds the numbers in
   point->parameter. Every law has `density`. ELASTIC_PARAMETERS is density, E, nu; further rows look like
   {MPM_NUMBER, "yield_stress", "Pa", 0., 1, 0., HUGE_VAL, 1, "meaning", NULL, 100e3, NULL}: kind, name, unit, default,
   required, range, open range, help, choices, a typical value, another parameter whose value is the default. */
static const MpmParameter parameters[] = {ELASTIC_PARAMETERS};

/* The state of a point, in the order in which the kernel finds it in point->state_n. A law with history
   has rows such as {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"} instead. */
static const MpmStateVariable states[] = MPM_NO_STATE;

/*
  The law, written once. Scalar is a double or a dual number that carries derivatives, so all that depends on dF goes
  through Scalar...(), Tensor...() and Sym...() functions, and the tangent follows of itself. Parameters and history are
  Reals, doubles but for the form that differentiates by them. Branches test ScalarValue() and RealValue(). A law with
  history reads point->state_n and writes point->state, if that is not NULL.
*/
MPM_FN int MpmMaterialEvaluate_linear_elastic(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Tensor F       = TensorMulArray(dF, point->F_n);
  const Sym    stretch = SymFromTensor(&F);
  const Sym    eps     = SymShift(&stretch, ScalarConstant(-1.));

  if (!ElasticIsRegular(point, dF)) return 1; /* no answer: the step backs off */
  *tau = ElasticStress(LameFromParameters(point->parameter), &eps);
  return 0;
}

/* Shear modulus and stiffness with their derivatives, for runs with water that are differentiated. */
MPM_LAW_MODULI(linear_elastic, parameters, states, ElasticModuli)

/* Name (that of this file, and the option's value), tables, kernel; then members of MpmLawInfo: one line for -help,
   traits, constrained and shear modulus at a state, and, in other laws, .check of parameters against each other and
   more. */
MPM_LAW_DEFINE(linear_elastic, parameters, states, MpmMaterialEvaluate_linear_elastic,
               .summary = "linear elasticity at small strain",
               .traits = MPM_LAW_SYMMETRIC | MPM_LAW_SMALL_STRAIN | MPM_LAW_FIXED_MODULI, .stiffness = ElasticStiffness,
               .shear_modulus = ElasticShearModulus, MPM_MODULI(linear_elastic))
