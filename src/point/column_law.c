/*
  The column of a depth-averaged flow (physics depth_averaged): material of constant volume over a base that stretches.

    h_{n+1} = h_n/det dF

  Its stress here is that of the layer's own deformation, which the laws of the bed leave at zero; the pressure of the
  depth acts with the bed (terrain/columns.h). Waves have the speed sqrt(g h). Taken for every law of the bed, whose
  parameter table it gets.
*/
#include "talus/point/basal.h"
#include "talus/point/law.h"

static const MpmParameter parameters[] = {MPM_BASAL_SHARED};

#define DEGREE (3.14159265358979323846 / 180.)

static const MpmStateVariable states[] = {{"depth", MPM_STATE_SCALAR, 1., "m"}};

/* rho g h, of the largest passive pressure where the material has internal friction */
MPM_FN double Stiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  (void)table, (void)F;
  const double sine = parameter[MPM_BASAL_INTERNAL] < 90. ? sin(parameter[MPM_BASAL_INTERNAL] * DEGREE) : 0.;

  return parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY] * (state ? state[0] : 1.) * (1. + sine) /
         (1. - sine);
}

MPM_FN int MpmMaterialEvaluate_column(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Scalar dJ = TensorDetByCofactors(dF);

  if (!(ScalarValue(dJ) > 0. && ScalarValue(dJ) <= DBL_MAX)) return 1;
  *tau = SymZero();
  if (point->state) point->state[0] = point->state_n[0] / ScalarReal(dJ);
  return 0;
}

MPM_LAW_DEFINE(column_law, parameters, states, MpmMaterialEvaluate_column, .summary = "column of a depth-averaged flow",
               .traits = MPM_LAW_INTERNAL | MPM_LAW_SYMMETRIC, .stiffness = Stiffness)
