#pragma once
/*
  Small tensors of Scalars, so that a kernel reads like its equations.

  Tensor  MPM_DIM x MPM_DIM, row-major. In plane strain (MPM_DIM 2) the in-plane block of a tensor whose zz component
          is 1 and whose other out-of-plane components are 0, as a deformation gradient is. With axial symmetry
          (MPM_DIM 2, MPM_AXISYMMETRIC) the zz component, that of the hoop direction, stands behind the block.
  Sym     symmetric 3 x 3 tensor: xx, yy, zz, xy in plane strain, xx, yy, zz, xy, yz, xz in 3D (MPM_SYM components,
          off-diagonal ones stored once). Traces, deviators and norms are always those of the 3 x 3 tensor.

  Arguments are passed by address, results come back by value; only what can fail returns a status and writes its
  result through a pointer. No function here allocates, branches on anything but values, or depends on PETSc.
*/
#include "dual.h"

#if MPM_DIM != 2 && MPM_DIM != 3
#error "MPM_DIM must be 2 or 3"
#endif

#define MPM_SYM (MPM_DIM == 2 ? 4 : 6)

/* Components of a Tensor, and those of them on its diagonal, by place */
#if defined(MPM_AXISYMMETRIC)
#if MPM_DIM != 2
#error "axial symmetry has MPM_DIM 2"
#endif
#define MPM_HOOP    4
#define MPM_TENSOR  5
#define MPM_NORMALS 3
#else
#define MPM_TENSOR  (MPM_DIM * MPM_DIM)
#define MPM_NORMALS MPM_DIM
#endif
#define MPM_NORMAL_AT(a) ((a) < MPM_DIM ? (a) * (MPM_DIM + 1) : MPM_DIM * MPM_DIM)
#define MPM_IS_NORMAL(i) ((i) % (MPM_DIM + 1) == 0 || (i) == MPM_DIM * MPM_DIM)

typedef struct {
  Scalar a[MPM_TENSOR];
} Tensor;

typedef struct {
  Scalar a[MPM_SYM];
} Sym;

/* Where component (i, j) of a Sym is stored, i, j < MPM_DIM. */
MPM_FN int SymIndex(int i, int j)
{
  if (i == j) return i;
  return i + j == 1 ? 3 : (i + j == 3 ? 4 : 5);
}

/* ---- general tensors ---- */

MPM_FN Tensor TensorIdentity(void)
{
  Tensor c;

  for (int i = 0; i < MPM_TENSOR; ++i) c.a[i] = ScalarConstant(MPM_IS_NORMAL(i) ? 1. : 0.);
  return c;
}

MPM_FN Tensor TensorFromArray(const Real *values)
{
  Tensor c;

  for (int i = 0; i < MPM_TENSOR; ++i) c.a[i] = ScalarConstant(values[i]);
  return c;
}

/* I + gradient, row-major: the increment dF of the deformation gradient from the gradient of the displacement
   increment */
MPM_FN Tensor TensorFromGradient(const Scalar *gradient)
{
  Tensor c;

  for (int i = 0; i < MPM_TENSOR; ++i) c.a[i] = ScalarShift(gradient[i], MPM_IS_NORMAL(i) ? 1. : 0.);
  return c;
}

/* Its values */
MPM_FN void TensorValues(double *values, const Tensor *A)
{
  for (int i = 0; i < MPM_TENSOR; ++i) values[i] = ScalarValue(A->a[i]);
}

MPM_FN void TensorStore(Real *values, const Tensor *A)
{
  for (int i = 0; i < MPM_TENSOR; ++i) values[i] = ScalarReal(A->a[i]);
}

MPM_FN Tensor TensorTranspose(const Tensor *A)
{
  Tensor c;

  for (int i = 0; i < MPM_DIM; ++i)
    for (int j = 0; j < MPM_DIM; ++j) c.a[i * MPM_DIM + j] = A->a[j * MPM_DIM + i];
#if defined(MPM_HOOP)
  c.a[MPM_HOOP] = A->a[MPM_HOOP];
#endif
  return c;
}

MPM_FN Tensor TensorAdd(const Tensor *A, const Tensor *B)
{
  Tensor c;

  for (int i = 0; i < MPM_TENSOR; ++i) c.a[i] = ScalarAdd(A->a[i], B->a[i]);
  return c;
}

MPM_FN Tensor TensorScale(Scalar alpha, const Tensor *A)
{
  Tensor c;

  for (int i = 0; i < MPM_TENSOR; ++i) c.a[i] = ScalarMul(alpha, A->a[i]);
  return c;
}

/* A B */
MPM_FN Tensor TensorMul(const Tensor *A, const Tensor *B)
{
  Tensor c;

  for (int i = 0; i < MPM_DIM; ++i) {
    for (int j = 0; j < MPM_DIM; ++j) {
      Scalar sum = ScalarMul(A->a[i * MPM_DIM], B->a[j]);

      for (int k = 1; k < MPM_DIM; ++k) ScalarAddProduct(&sum, &A->a[i * MPM_DIM + k], &B->a[k * MPM_DIM + j]);
      c.a[i * MPM_DIM + j] = sum;
    }
  }
#if defined(MPM_HOOP)
  c.a[MPM_HOOP] = ScalarMul(A->a[MPM_HOOP], B->a[MPM_HOOP]);
#endif
  return c;
}

/* A B with a matrix B of Reals, row-major: F = dF F_n */
MPM_FN Tensor TensorMulArray(const Tensor *A, const Real *B)
{
  Tensor c;

  for (int i = 0; i < MPM_DIM; ++i) {
    for (int j = 0; j < MPM_DIM; ++j) {
      Scalar sum = ScalarScale(B[j], A->a[i * MPM_DIM]);

      for (int k = 1; k < MPM_DIM; ++k) ScalarAddScaled(&sum, B[k * MPM_DIM + j], &A->a[i * MPM_DIM + k]);
      c.a[i * MPM_DIM + j] = sum;
    }
  }
#if defined(MPM_HOOP)
  c.a[MPM_HOOP] = ScalarScale(B[MPM_HOOP], A->a[MPM_HOOP]);
#endif
  return c;
}

/* The cofactors: A^{-T} = cof A / det A */
MPM_FN Tensor TensorCofactor(const Tensor *A)
{
  Tensor c;

#if defined(MPM_HOOP)
  const Scalar hoop = A->a[MPM_HOOP];

  c.a[0]        = ScalarMul(hoop, A->a[3]);
  c.a[1]        = ScalarNeg(ScalarMul(hoop, A->a[2]));
  c.a[2]        = ScalarNeg(ScalarMul(hoop, A->a[1]));
  c.a[3]        = ScalarMul(hoop, A->a[0]);
  c.a[MPM_HOOP] = ScalarSub(ScalarMul(A->a[0], A->a[3]), ScalarMul(A->a[1], A->a[2]));
#elif MPM_DIM == 2
  c.a[0] = A->a[3];
  c.a[1] = ScalarNeg(A->a[2]);
  c.a[2] = ScalarNeg(A->a[1]);
  c.a[3] = A->a[0];
#else
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int i1 = 3 * ((i + 1) % 3), i2 = 3 * ((i + 2) % 3), j1 = (j + 1) % 3, j2 = (j + 2) % 3;

      c.a[3 * i + j] = ScalarSub(ScalarMul(A->a[i1 + j1], A->a[i2 + j2]), ScalarMul(A->a[i1 + j2], A->a[i2 + j1]));
    }
  }
#endif
  return c;
}

/* det A, given the cofactors of A */
MPM_FN Scalar TensorCofactorDet(const Tensor *A, const Tensor *cofactor)
{
  Scalar det = ScalarMul(A->a[0], cofactor->a[0]);

  for (int j = 1; j < MPM_DIM; ++j) ScalarAddProduct(&det, &A->a[j], &cofactor->a[j]);
  return det;
}

MPM_FN Scalar TensorDet(const Tensor *A)
{
  const Tensor cofactor = TensorCofactor(A);

  return TensorCofactorDet(A, &cofactor);
}

/* The determinant to rounding, with the derivative by A from plain cofactors: cheaper the more directions there are */
MPM_FN Scalar TensorDetByCofactors(const Tensor *A)
{
#if defined(MPM_SENSITIVITY)
  return TensorDet(A);
#else
  double values[MPM_TENSOR], cofactor[MPM_TENSOR];
  Scalar det;

  TensorValues(values, A);
  det = ScalarConstant(MpmCofactors(MPM_TENSOR, values, cofactor));
  for (int i = 0; i < MPM_TENSOR; ++i) ScalarAddDirections(&det, cofactor[i], &A->a[i]);
  return det;
#endif
}

/* The value alone of det A: what a test for det F > 0 needs */
MPM_FN double TensorDetValue(const Tensor *A)
{
  double values[MPM_TENSOR];

  TensorValues(values, A);
  return MpmDeterminant(MPM_TENSOR, values);
}

/* det A as history: without its derivatives by the increment */
MPM_FN Real TensorDetReal(const Tensor *A)
{
#if defined(MPM_SENSITIVITY)
  return TensorDet(A);
#else
  return TensorDetValue(A);
#endif
}

/* The determinant of a matrix of Reals, row-major */
MPM_FN double ArrayDetValue(const Real *A)
{
#if defined(MPM_SENSITIVITY)
  double values[MPM_TENSOR];

  for (int i = 0; i < MPM_TENSOR; ++i) values[i] = RealValue(A[i]);
  return MpmDeterminant(MPM_TENSOR, values);
#else
  return MpmDeterminant(MPM_TENSOR, A);
#endif
}

/* A^{-1}; det A must not be 0 */
MPM_FN Tensor TensorInverse(const Tensor *A)
{
  const Tensor cofactor = TensorCofactor(A), adjugate = TensorTranspose(&cofactor);

  return TensorScale(ScalarDiv(ScalarConstant(1.), TensorCofactorDet(A, &cofactor)), &adjugate);
}

/* ---- symmetric tensors ---- */

MPM_FN Sym SymZero(void)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarConstant(0.);
  return c;
}

MPM_FN Sym SymIdentity(void)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarConstant(i < 3 ? 1. : 0.);
  return c;
}

MPM_FN Sym SymLoad(const Real *values)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarConstant(values[i]);
  return c;
}

/* Into the history at the step's end. */
MPM_FN void SymStore(Real *state, const Sym *A)
{
  for (int i = 0; i < MPM_SYM; ++i) state[i] = ScalarReal(A->a[i]);
}

MPM_FN void SymValues(double *values, const Sym *A)
{
  for (int i = 0; i < MPM_SYM; ++i) values[i] = ScalarValue(A->a[i]);
}

MPM_FN Sym SymAdd(const Sym *A, const Sym *B)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarAdd(A->a[i], B->a[i]);
  return c;
}

MPM_FN Sym SymSub(const Sym *A, const Sym *B)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarSub(A->a[i], B->a[i]);
  return c;
}

MPM_FN Sym SymScale(Scalar alpha, const Sym *A)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarMul(alpha, A->a[i]);
  return c;
}

/* alpha A with a factor that does not depend on the increment */
MPM_FN Sym SymScaleBy(Real alpha, const Sym *A)
{
  Sym c;

  for (int i = 0; i < MPM_SYM; ++i) c.a[i] = ScalarScale(alpha, A->a[i]);
  return c;
}

/* A + alpha B */
MPM_FN Sym SymAxpy(Scalar alpha, const Sym *B, const Sym *A)
{
  Sym c = *A;

  for (int i = 0; i < MPM_SYM; ++i) ScalarAddProduct(&c.a[i], &alpha, &B->a[i]);
  return c;
}

/* A + alpha I */
MPM_FN Sym SymShift(const Sym *A, Scalar alpha)
{
  Sym c = *A;

  for (int i = 0; i < 3; ++i) c.a[i] = ScalarAdd(A->a[i], alpha);
  return c;
}

MPM_FN Scalar SymTrace(const Sym *A)
{
  return ScalarAdd(ScalarAdd(A->a[0], A->a[1]), A->a[2]);
}

/* A - (tr A / 3) I */
MPM_FN Sym SymDev(const Sym *A)
{
  return SymShift(A, ScalarScale(-1. / 3., SymTrace(A)));
}

/* A : B, each off-diagonal pair counted twice */
MPM_FN Scalar SymDot(const Sym *A, const Sym *B)
{
  Scalar normal = ScalarMul(A->a[0], B->a[0]), shear = ScalarMul(A->a[3], B->a[3]);

  for (int i = 1; i < 3; ++i) ScalarAddProduct(&normal, &A->a[i], &B->a[i]);
  for (int i = 4; i < MPM_SYM; ++i) ScalarAddProduct(&shear, &A->a[i], &B->a[i]);
  ScalarAddScaled(&normal, 2., &shear);
  return normal;
}

/* The value alone of sqrt(A : A): what a yield check needs */
MPM_FN double SymNormValue(const Sym *A)
{
  double sum = 0.;

  for (int i = 0; i < MPM_SYM; ++i) sum += (i < 3 ? 1. : 2.) * ScalarValue(A->a[i]) * ScalarValue(A->a[i]);
  return sqrt(sum);
}

/* The norm of the deviator of A */
MPM_FN double SymDevNormValue(const Sym *A)
{
  const double mean = (ScalarValue(A->a[0]) + ScalarValue(A->a[1]) + ScalarValue(A->a[2])) / 3.;
  double       sum  = 0.;

  for (int i = 0; i < MPM_SYM; ++i) {
    const double value = ScalarValue(A->a[i]) - (i < 3 ? mean : 0.);

    sum += (i < 3 ? 1. : 2.) * value * value;
  }
  return sqrt(sum);
}

/* sqrt(A : A). The norm has no derivative at A = 0, where the derivative 0 is returned: the centre of the
   subdifferential. */
MPM_FN Scalar SymNorm(const Sym *A)
{
  const Scalar square = SymDot(A, A);

  return ScalarValue(square) > 0. ? ScalarSqrt(square) : ScalarConstant(0.);
}

/* (A + A^T)/2; the zz component in plane strain is that of A, 1 */
MPM_FN Sym SymFromTensor(const Tensor *A)
{
  Sym c;

#if defined(MPM_HOOP)
  c.a[2] = A->a[MPM_HOOP];
#else
  c.a[2] = ScalarConstant(1.);
#endif
  for (int i = 0; i < MPM_DIM; ++i) {
    for (int j = i; j < MPM_DIM; ++j)
      c.a[SymIndex(i, j)] = ScalarScale(0.5, ScalarAdd(A->a[i * MPM_DIM + j], A->a[j * MPM_DIM + i]));
  }
  return c;
}

/* A B^T as a Sym, for a pair of tensors of which this product is known to be symmetric; zz is 1 in plane strain */
MPM_FN Sym SymFromProductTransposed(const Tensor *A, const Tensor *B)
{
  Sym c;

#if defined(MPM_HOOP)
  c.a[2] = ScalarMul(A->a[MPM_HOOP], B->a[MPM_HOOP]);
#else
  c.a[2] = ScalarConstant(1.);
#endif
  for (int i = 0; i < MPM_DIM; ++i) {
    for (int j = i; j < MPM_DIM; ++j) {
      Scalar sum = ScalarMul(A->a[i * MPM_DIM], B->a[j * MPM_DIM]);

      for (int k = 1; k < MPM_DIM; ++k) ScalarAddProduct(&sum, &A->a[i * MPM_DIM + k], &B->a[j * MPM_DIM + k]);
      c.a[SymIndex(i, j)] = sum;
    }
  }
  return c;
}

/* b = F F^T */
MPM_FN Sym SymLeftCauchyGreen(const Tensor *F)
{
  return SymFromProductTransposed(F, F);
}

/* F b F^T with a b of MPM_SYM Reals: the elastic trial state dF b_n dF^T */
MPM_FN Sym SymPush(const Tensor *F, const Real *b)
{
  Real   matrix[MPM_TENSOR];
  Tensor Fb;
  Sym    c;

#if defined(MPM_HOOP)
  matrix[MPM_HOOP] = b[2];
#endif

  for (int i = 0; i < MPM_DIM; ++i)
    for (int j = 0; j < MPM_DIM; ++j) matrix[i * MPM_DIM + j] = b[SymIndex(i, j)];
  Fb = TensorMulArray(F, matrix);
  c  = SymFromProductTransposed(&Fb, F);
#if MPM_DIM == 2 && !defined(MPM_HOOP)
  c.a[2] = ScalarConstant(b[2]);
#endif
  return c;
}

/* A B with a symmetric A */
MPM_FN Tensor TensorSymMul(const Sym *A, const Tensor *B)
{
  Tensor c;

  for (int i = 0; i < MPM_DIM; ++i) {
    for (int j = 0; j < MPM_DIM; ++j) {
      Scalar sum = ScalarMul(A->a[SymIndex(i, 0)], B->a[j]);

      for (int k = 1; k < MPM_DIM; ++k) ScalarAddProduct(&sum, &A->a[SymIndex(i, k)], &B->a[k * MPM_DIM + j]);
      c.a[i * MPM_DIM + j] = sum;
    }
  }
#if defined(MPM_HOOP)
  c.a[MPM_HOOP] = ScalarMul(A->a[2], B->a[MPM_HOOP]);
#endif
  return c;
}

/* A_ab B_ba, all sums over the stored components */
MPM_FN Scalar TensorTraceMulArray(const Tensor *A, const Real *B)
{
  Scalar sum = ScalarConstant(0.);

  for (int i = 0; i < MPM_DIM; ++i)
    for (int j = 0; j < MPM_DIM; ++j) ScalarAddScaled(&sum, B[j * MPM_DIM + i], &A->a[i * MPM_DIM + j]);
#if defined(MPM_HOOP)
  ScalarAddScaled(&sum, B[MPM_HOOP], &A->a[MPM_HOOP]);
#endif
  return sum;
}

/*
  SymTimesInverseTranspose - factor tau F^{-T}, in-plane block, which turns a Kirchhoff stress into the first
  Piola-Kirchhoff stress relative to the configuration that F starts from. det F must not be 0.
*/
MPM_FN Tensor SymTimesInverseTranspose(const Sym *tau, const Tensor *F, double factor)
{
  const Tensor cofactor   = TensorCofactor(F);
  const Scalar J          = TensorCofactorDet(F, &cofactor);
  const double reciprocal = 1. / ScalarValue(J);
  const Scalar inverse    = ScalarChain(J, factor * reciprocal, -factor * reciprocal * reciprocal);
  Tensor       P          = TensorSymMul(tau, &cofactor);

  for (int i = 0; i < MPM_TENSOR; ++i) P.a[i] = ScalarMul(inverse, P.a[i]);
  return P;
}

#include "isotropic.h"
