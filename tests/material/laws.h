#pragma once
/*
  What the conformance suite and the value tests share. Compiled once per dimension, MPM_DIM; sees the kernels only
  through the plain double wrappers of law_instance.c, because the instances' Scalars are different types under one
  name.
*/
#include "talus/point/tables.h"

#define DIM  MPM_DIM
#define DIM2 (MPM_DIM * MPM_DIM)
#define SYM  (MPM_DIM == 2 ? 4 : 6)

/* Many draws are for the builds without sanitizers, which take four times as long. */
#if defined(__SANITIZE_ADDRESS__)
enum { FEWER = 10 };
#else
enum { FEWER = 1 };
#endif

enum { MAX_PARAMETERS = 32, MAX_STATE = 64, MAX_DATA = 8 };

/* tau (SYM) and, unless NULL, dtau (SYM x DIM2, row-major) by the components of dF; `state` may be NULL. */
typedef int (*LawTangent)(const MpmLawInfo *info, const MpmLawInput *input, double *state, double *tau, double *dtau);

enum { PLAIN, ONE_DIRECTION, ALL_DIRECTIONS, TANGENTS, SENSITIVITY = TANGENTS, INSTANCES };

/* A registered law in its instances: plain doubles, one direction, all directions, by all that it is given */
typedef struct {
  MpmLawInfo info[INSTANCES];
  LawTangent tangent[TANGENTS];
} Law;

/* A material point of a law; `data` is what tables and data hold, MAX_DATA numbers each. */
typedef struct {
  const Law *law;
  double     parameter[MAX_PARAMETERS], state[MAX_STATE], F[DIM2], data[MAX_PARAMETERS][MAX_DATA];
} Point;

typedef void (*Constructor)(MpmLawInfo *info);

/* Makes this law, by its constructors for the instances, the only one under test. */
void       LawUse(const Constructor own[INSTANCES]);
int        LawCount(void);
const Law *LawGet(int i);
const Law *LawFind(const char *name);

/* Number of doubles of a law's history; index of a parameter by name or -1; offset of a state by name or -1 */
int LawStateSize(const Law *law);
int LawParameter(const Law *law, const char *name);
int LawState(const Law *law, const char *name);

/* Uniform in [lower, upper), from a generator that is the same everywhere */
void   RandomSeed(unsigned seed);
double RandomUniform(double lower, double upper);
void   RandomMatrix(double amplitude, double *A); /* I + amplitude times entries in (-1, 1) */
void   RandomRotation(double *R);

/* Valid parameters for any law; with `degenerate`, parameters are now and then put on an accepted bound */
void PointCreate(const Law *law, int degenerate, Point *point);
/* Virgin state, F = I */
void PointReset(Point *point);
/* One committed step; returns the law's status */
int PointStep(Point *point, const double *dF, double *tau);
/* A path of random steps of this size */
void PointRandomPath(Point *point, int steps, double amplitude);
/* What the law is given at the point, with room for tables, one a parameter; it borrows from both */
MpmLawInput PointInput(const Point *point, const double *dF, MpmLawTable table[MAX_PARAMETERS]);
/* tau and perhaps dtau, nothing committed */
int    PointEvaluate(const Point *point, int instance, const double *dF, double *tau, double *dtau);
double PointStiffness(const Point *point);              /* at rest */
double PointStiffnessAt(const Point *point);            /* at the point's state */
double PointShearModulus(const Point *point, int rest); /* at rest or at the point's state */
/* The largest of that at rest, at the state, and after a step from there: what derivatives of the stress are measured by */
double PointStiffnessAround(const Point *point, const double *dF);
/* What a history value is measured in: PointStiffness() for a pressure, otherwise 1 */
double PointStateUnit(const Point *point, int i);
void   PointSet(Point *point, const char *parameter, double value);
/* Of a law of Hencky's elasticity: sets the elastic strain to that of principal Kirchhoff stresses along x, y, z */
void PointSetPrincipal(Point *point, const double *stress);

void   Identity(double *A);
void   Multiply(const double *A, const double *B, double *C);
double Determinant(const double *A);
double MaxDifference(int n, const double *a, const double *b);
/* |tau(dF + h V) - tau(dF) - h dtau V|, the largest component; NaN, which passes no comparison, where the law has no answer */
double TaylorRemainder(const Point *point, const double *dF, const double *V, double h);
double MaxNorm(int n, const double *a);
int    SymAt(int i, int j);
/* R b R^T of a Sym; zz as it is in plane strain */
void SymRotate(const double *R, const double *b, double *result);
/* Hooke's law for eps = sym(H) */
void Hooke(double E, double nu, const double *H, double *sigma);
/* Solves A x = b by elimination with pivoting, n <= 9; both are overwritten, x in b */
void Solve(int n, double *A, double *b);
