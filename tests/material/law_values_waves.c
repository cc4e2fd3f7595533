/*
  Wave speeds: what explicit steps take for the largest, by the stiffness at a state and the compression there, against the
  acoustic tensor of the tangent, for every registered law.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>

enum { SAMPLES = 60, DIRECTIONS = 100 };

TCase *WaveCase(void);

/*
  The symmetric part of Q_ik = J n_j n_l a_ijkl, where J a_ijkl = d tau_ij/d F_kl - tau_il delta_jk are the moduli of the rate
  of P; a law of small strain has the first alone.
*/
static void Acoustic(const double *tau, const double *dtau, int small, const double n[DIM], double Q[DIM2])
{
  double full[DIM2];

  for (int i = 0; i < DIM; ++i) {
    for (int k = 0; k < DIM; ++k) {
      full[i * DIM + k] = 0.;
      for (int j = 0; j < DIM; ++j)
        for (int l = 0; l < DIM; ++l) full[i * DIM + k] += n[j] * n[l] * dtau[SymAt(i, j) * DIM2 + k * DIM + l];
      for (int l = 0; l < DIM && !small; ++l) full[i * DIM + k] -= n[l] * n[k] * tau[SymAt(i, l)];
    }
  }
  for (int i = 0; i < DIM; ++i)
    for (int k = 0; k < DIM; ++k) Q[i * DIM + k] = 0.5 * (full[i * DIM + k] + full[k * DIM + i]);
}

/* The largest principal value, at least 0, by power iterations from several starts: from below */
static double Largest(const double Q[DIM2])
{
  double x[DIM], largest = 0.;

  for (int a = 0; a < DIM; ++a) {
    for (int i = 0; i < DIM; ++i) x[i] = i == a ? 1. : 0.1;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double y[DIM] = {0.}, norm = 0., value = 0., size = 0.;

      for (int i = 0; i < DIM; ++i) {
        for (int k = 0; k < DIM; ++k) y[i] += Q[i * DIM + k] * x[k];
        value += x[i] * y[i];
        norm += x[i] * x[i];
        size += y[i] * y[i];
      }
      largest = fmax(largest, value / norm);
      for (int i = 0; i < DIM && size > 0.; ++i) x[i] = y[i] / sqrt(size);
    }
  }
  return largest;
}

/* The largest principal compression by the Kirchhoff stress, in the plane in plane strain; 0 where there is none */
static double Compression(const double *tau)
{
  const double shift = SYM * MaxNorm(SYM, tau);
  double       Q[DIM2];

  for (int i = 0; i < DIM; ++i)
    for (int j = 0; j < DIM; ++j) Q[i * DIM + j] = (i == j ? shift : 0.) - tau[SymAt(i, j)];
  return fmax(0., Largest(Q) - shift);
}

/* The largest over many directions of J times the acoustic tensor */
static double Search(const double *tau, const double *dtau, int small)
{
  double wave = 0.;

  for (int direction = 0; direction < DIRECTIONS; ++direction) {
    double R[DIM2], n[DIM], Q[DIM2];

    if (direction) RandomRotation(R);
    else Identity(R);
    for (int i = 0; i < DIM; ++i) n[i] = R[i * DIM];
    Acoustic(tau, dtau, small, n, Q);
    wave = fmax(wave, Largest(Q));
  }
  return wave;
}

/*
  The stiffness at a state and the largest compression there bound the wave speed in all directions; at rest without stress
  the bound is met within a factor of two.
*/
START_TEST(test_wave_speed)
{
  const Law *law   = LawGet(_i);
  const int  small = (law->info[PLAIN].traits & MPM_LAW_SMALL_STRAIN) != 0;

  RandomSeed(15);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    double dF[DIM2], tau[SYM], dtau[SYM * DIM2], wave, compression, bound;
    Point  point;

    PointCreate(law, sample % 2, &point);
    if (!small) PointRandomPath(&point, sample % 4, pow(10., RandomUniform(-3.5, -0.8)));
    Identity(dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    wave        = Search(tau, dtau, small);
    compression = Compression(tau);
    bound       = PointStiffnessAt(&point) + compression;
    ck_assert_msg(wave <= (1. + 1e-3) * bound, "%s, sample %d: density c^2 is %.4e, bound %.4e", law->info[PLAIN].name,
                  sample, wave, bound);
    ck_assert_msg(sample % 4 || compression > 0. || bound <= 2. * wave,
                  "%s, sample %d: density c^2 is %.4e, bound %.4e", law->info[PLAIN].name, sample, wave, bound);
  }
}
END_TEST

TCase *WaveCase(void)
{
  TCase *tcase = tcase_create("wave speeds");

  tcase_add_loop_test(tcase, test_wave_speed, 0, LawCount());
  return tcase;
}
