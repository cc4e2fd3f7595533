/*
  Hencky: large-strain isotropic elasticity, linear in the logarithmic strain

    b = F F^T,   e = (1/2) ln b,   tau = lambda tr(e) I + 2 mu e

  tau  Kirchhoff stress J sigma, tension positive, Pa
  F    deformation gradient, dx/dX

  Derives from the potential (lambda/2) tr(e)^2 + mu e:e. Plane strain keeps tau_zz = lambda tr(e). Fits metals and
  soils, whose elastic strains are moderate; the stress in simple shear reaches a maximum at a shear of about 3.

  Source: Hencky (1928), Zeitschrift fuer technische Physik 9, 215-220; Anand (1979), doi:10.1115/1.3424532.
*/
#include "talus/point/elasticity.h"

static const MpmParameter parameters[] = {ELASTIC_PARAMETERS};

static const MpmStateVariable states[] = MPM_NO_STATE;

MPM_FN int MpmMaterialEvaluate_hencky(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Tensor F    = TensorMulArray(dF, point->F_n);
  const Sym    b    = SymLeftCauchyGreen(&F);
  Lame         half = LameFromParameters(point->parameter); /* the strain comes twice as large */
  Sym          twice;

  if (!ElasticIsRegular(point, dF) || SymLog(&b, &twice)) return 1;
  half.lambda *= 0.5;
  half.mu *= 0.5;
  *tau = ElasticStress(half, &twice);
  return 0;
}

MPM_LAW_MODULI(hencky, parameters, states, ElasticModuli)

MPM_LAW_DEFINE(hencky, parameters, states, MpmMaterialEvaluate_hencky,
               .summary = "large-strain elasticity, linear in the logarithmic strain",
               .traits = MPM_LAW_SYMMETRIC | MPM_LAW_FIXED_MODULI, .stiffness = ElasticStiffness,
               .shear_modulus = ElasticShearModulus, MPM_MODULI(hencky))
