#pragma once
/*
  Evaluation of a material's law by a physics, for any number of directions of the physics' own kernel. Included by
  law.h.

  Laws are compiled for as many directions as dF has components. Where a kernel carries others, as many as it has inputs
  say, the law returns its derivatives by dF, and the chain rule gives

    tau = tau(dF) ,   d tau = sum_k (d tau / d dF_k) d dF_k
*/
#define LAW_DIRECTIONS MPM_TENSOR

/* Time of a law, whose history goes from the step's start: with two sub-steps not that in which something flows. */
MPM_FN double LawTime(const MpmKernelPoint *point)
{
  return point->stage ? point->stage->span : point->dt;
}

/* Keeps a state of the physics' own at the step's end, where it is wanted. */
MPM_FN void KernelKeepOwn(const MpmKernelPoint *point, int k, double value)
{
  if (point->end.F) point->end.own[k] = value;
}

/*
  One of the law's moduli: the shear modulus at the step's start, a third of the stiffness where the law has none; shear
  modulus and stiffness at rest.
*/
MPM_FN double KernelModulus(const MpmKernelPoint *point, int k)
{
  const MpmLawInfo *info    = point->material.info;
  const int         thirds  = k < 2 && !info->shear_modulus;
  const double     *state_n = k ? NULL : point->state_n, *F_n = k ? NULL : point->F_n;

  if (k == 2 || thirds)
    return (thirds ? 1. / 3. : 1.) * info->stiffness(point->material.parameter, point->material.table, state_n, F_n);
  return info->shear_modulus(point->material.parameter, point->material.table, state_n, F_n);
}

#if MPM_DIRECTIONS < 2 || MPM_DIRECTIONS == LAW_DIRECTIONS

/* The Kirchhoff stress at dF. Non-zero where the law has no answer. */
MPM_FN int LawStress(const MpmKernelPoint *point, const Tensor *dF, Sym *tau)
{
  const MpmLawPoint law_point = {
    point->material.parameter, point->state_n, point->end.state, point->F_n, LawTime(point), point->material.table};
  const MPM_INSTANCE(MpmLaw) law = (MPM_INSTANCE(MpmLaw))point->material.law[MPM_KERNEL_FORM];

  return law(&law_point, dF, tau);
}

#else

/* A Scalar of LAW_DIRECTIONS directions as it lies in memory, see dual_number.h. */
#if defined(__AVX__) && defined(__GNUC__) && !defined(__CUDACC__)
#define LAW_LANE 4
#else
#define LAW_LANE 1
#endif
typedef struct {
  double d[(LAW_DIRECTIONS + LAW_LANE - 1) / LAW_LANE * LAW_LANE];
  double v[LAW_LANE];
} LawScalar;
typedef struct {
  LawScalar a[LAW_DIRECTIONS];
} LawTensor;
typedef struct {
  LawScalar a[MPM_SYM];
} LawSym;
typedef int (*LawTangent)(const MpmLawPoint *point, const LawTensor *dF, LawSym *tau);

MPM_FN int LawStress(const MpmKernelPoint *point, const Tensor *dF, Sym *tau)
{
  const MpmLawPoint law_point = {
    point->material.parameter, point->state_n, point->end.state, point->F_n, LawTime(point), point->material.table};
  const LawTangent law    = (LawTangent)point->material.law[MPM_FORM_TANGENT];
  LawTensor        seeded = {{{{0.}, {0.}}}};
  LawSym           answer;

  for (int k = 0; k < LAW_DIRECTIONS; k++) {
    for (int lane = 0; lane < LAW_LANE; lane++) seeded.a[k].v[lane] = ScalarValue(dF->a[k]);
    seeded.a[k].d[k] = 1.;
  }
  if (law(&law_point, &seeded, &answer)) return 1;
  for (int i = 0; i < MPM_SYM; i++) {
    tau->a[i] = ScalarConstant(answer.a[i].v[0]);
    for (int k = 0; k < LAW_DIRECTIONS; k++) ScalarAddDirections(&tau->a[i], answer.a[i].d[k], &dF->a[k]);
  }
  return 0;
}

#endif
