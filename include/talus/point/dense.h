#pragma once
/*
  Small dense matrices of plain numbers, row-major; tensor.h has those of Scalars. A number `size` of components tells
  their form: 4, 2 x 2, in plane strain the in-plane block of a deformation gradient; 5, with axial symmetry, the block
  and the hoop component; 9, 3 x 3.
*/

/* Functions of the pointwise kernels, wherever these are compiled for. */
#if defined(__CUDACC__)
#define MPM_FN static __host__ __device__ inline
#else
#define MPM_FN static inline
#endif

/* Components of a symmetric tensor at a point: in plane strain xx, yy, zz, xy. */
MPM_FN int MpmSymSize(long dim)
{
  return dim == 2 ? 4 : 6;
}

/*
  Extent of space for a unit of the plane at radius r, by the size of F: the circumference, m, with axial symmetry; 1 in
  plane strain, for a metre of thickness, and in 3D
*/
MPM_FN double MpmTurn(long size, double r)
{
  return size == 5 ? 2. * 3.14159265358979323846 * r : 1.;
}

/* det A */
MPM_FN double MpmDeterminant(long size, const double A[])
{
  if (size < 9) return (A[0] * A[3] - A[1] * A[2]) * (size == 5 ? A[4] : 1.);
  return A[0] * (A[4] * A[8] - A[5] * A[7]) + A[1] * (A[5] * A[6] - A[3] * A[8]) + A[2] * (A[3] * A[7] - A[4] * A[6]);
}

/* The cofactors of A, the derivatives of det A by its entries: A^{-T} = cof A / det A. Returns det A. */
MPM_FN double MpmCofactors(long size, const double A[], double cofactor[])
{
  if (size < 9) {
    const double hoop = size == 5 ? A[4] : 1.;

    cofactor[0] = hoop * A[3];
    cofactor[1] = -hoop * A[2];
    cofactor[2] = -hoop * A[1];
    cofactor[3] = hoop * A[0];
    if (size == 5) cofactor[4] = A[0] * A[3] - A[1] * A[2];
    return MpmDeterminant(size, A);
  }
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      const int i1 = 3 * ((i + 1) % 3), i2 = 3 * ((i + 2) % 3), j1 = (j + 1) % 3, j2 = (j + 2) % 3;

      cofactor[3 * i + j] = A[i1 + j1] * A[i2 + j2] - A[i1 + j2] * A[i2 + j1];
    }
  }
  return MpmDeterminant(size, A);
}
