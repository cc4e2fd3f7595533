/*
  The diagonal of the right stretch U = sqrt(F^T F), by which a point's domain is scaled along the axes. Source:
  Charlton, Coombs and Augarde (2017), eq. 38-39, doi:10.1016/j.compstruc.2017.05.004.
*/
#include "talus/point/law.h"

#if MPM_DIRECTIONS == 0 && !defined(MPM_AXISYMMETRIC)
int MPM_INSTANCE(MpmStretchDiagonal)(const double *F, double *diagonal);
int MPM_INSTANCE(MpmStretchDiagonal)(const double *F, double *diagonal)
{
  return TensorStretchDiagonal(F, diagonal);
}
int MPM_INSTANCE(MpmStretchQuick)(const double *F, double *diagonal);
int MPM_INSTANCE(MpmStretchQuick)(const double *F, double *diagonal)
{
  return TensorStretchDiagonalQuick(F, diagonal);
}
#endif
