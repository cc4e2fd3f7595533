/*
  Plain double access to the laws of one instance, so that one test program can hold several. The build compiles this
  file once per instance, as it does the materials.
*/
#include "talus/point/law.h"

int MPM_INSTANCE(LawTangent)(const MpmLawInfo *info, const MpmLawInput *input, double *state, double *tau,
                             double *dtau);

/*
  tau (MPM_SYM) and, unless NULL, dtau (MPM_SYM x MPM_DIM^2, row-major): derivatives with respect to the components of
  dF, as many at a time as the instance has directions. The instance without directions leaves dtau alone. Returns the
  law's status.
*/
int MPM_INSTANCE(LawTangent)(const MpmLawInfo *info, const MpmLawInput *input, double *state, double *tau, double *dtau)
{
  const MPM_INSTANCE(MpmLaw) law = (MPM_INSTANCE(MpmLaw))info->law;
  const int         n            = MPM_TENSOR;
  const int         width        = MPM_DIRECTIONS > 0 ? MPM_DIRECTIONS : n;
  const MpmLawPoint point        = {input->parameter, input->state_n, state, input->F_n, input->dt, input->table};

  for (int first = 0; first < (dtau ? n : 1); first += width) {
    Tensor increment = TensorFromArray(input->dF);
    Sym    stress;
    int    status;

    for (int k = 0; k < width && first + k < n && MPM_DIRECTIONS > 0; ++k)
      increment.a[first + k] = ScalarSeed(input->dF[first + k], k);
    status = law(&point, &increment, &stress);
    if (status) return status;
    SymStore(tau, &stress);
    for (int k = 0; k < width && first + k < n && MPM_DIRECTIONS > 0 && dtau; ++k)
      for (int i = 0; i < MPM_SYM; ++i) dtau[i * n + first + k] = ScalarDirection(stress.a[i], k);
  }
  return 0;
}
