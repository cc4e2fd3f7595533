#pragma once
/*
  Terms of the residual from outside the tree: forces on the material that follow from its place and displacement, given
  as elements at the points. From the elements the engine makes residual, Jacobian in all its forms, its action without
  a matrix and that of its transpose, diagonal, potential and account of energy.

  A scene names its added terms in -mpm_terms; each has a block -mpm_term_NAME_ with its type, a region of initial
  places, by default all, and the parameters of the type.
*/
#include <petscsys.h>
#include "talus/compat.h"
#include "talus/point/tables.h"

/*
  An element: a point of the material, with the nodes that it touches. Arrays are borrowed for the call. Unknowns,
  residual and block of a node are those along the axes: the displacement increment in the first `dim` components, then
  the other fields of the physics.
*/
typedef struct {
  PetscInt dim, block; /* directions, unknowns a node */
  PetscInt nodes;
  const PetscReal *const
                    *basis; /* basis[c*(dim + 1)]: weights of component c, a number a node; then derivatives by x */
  const PetscReal   *u;     /* unknowns: component c of node i at u[c*nodes + i] */
  const PetscReal   *x, *origin; /* place of the point at the step's start, and initial place, m */
  PetscReal          volume0;    /* initial volume, m3 (2D: per metre of thickness; axial symmetry: of a full turn) */
  PetscReal          time, dt;   /* the step's end and length, s */
  PetscInt           id;         /* number of the point */
  const double      *parameter;  /* as the scene has them, in the order of the type's table; of words the index */
  const MpmLawTable *table;      /* of tables and data; empty for numbers */
  void              *ctx;        /* made by the type's create() */
} MpmTermElement;

/* A term as create() finds it. */
typedef struct {
  MPI_Comm           comm;
  PetscInt           dim;
  const char        *name; /* of the term in the scene */
  const double      *parameter;
  const MpmLawTable *table;
} MpmTermSettings;

/*
  MPM_ELEMENT_SYMMETRIC   the block is symmetric
  MPM_ELEMENT_ENERGY      the residual is the derivative of the element's energy by the unknowns, the block the second
                          one: a step stays a minimisation where it is one without the term
  MPM_ELEMENT_DISSIPATES  the work that the term takes from the material is dissipated; otherwise it counts as work from
                          outside, with opposite sign
*/
typedef enum { MPM_ELEMENT_SYMMETRIC = 1, MPM_ELEMENT_ENERGY = 2, MPM_ELEMENT_DISSIPATES = 4 } MpmElementTrait;

/*
  A type of term: -mpm_term_NAME_type. Functions but `evaluate` may be NULL.

  create    data of a term, after its options have been read; may refuse with MPM_ERR_INPUT. Collective
  destroy   frees them, sets NULL
  evaluate  adds the element's energy, J, its residual, component c of node i at residual[c*nodes + i], N, and the
            derivative of component c of node i by component d of node j, matrix[((i*block + c)*block + d)*nodes + j].
            Each of the three is NULL where it is not wanted. Non-zero, and nothing added, where there is no answer:
            the step is then tried in another way. Not collective

  The residual is the force that the material exerts on the term: of a spring +k u.
*/
typedef struct {
  const char         *name;
  const char         *summary; /* one line for -help */
  PetscInt            parameter_count;
  const MpmParameter *parameters;
  unsigned            traits; /* MpmElementTrait values, or-ed */
  PetscErrorCode (*create)(const MpmTermSettings *settings, void **ctx);
  PetscErrorCode (*destroy)(void **ctx);
  int (*evaluate)(const MpmTermElement *element, PetscReal *energy, PetscReal residual[], PetscReal matrix[]);
} MpmTermType;

#pragma GCC visibility push(default)

/*@
  MpmTermRegister - offers a type of term to the models of this process, under -mpm_term_NAME_type

  Not collective, but all ranks must register the same; before MpmModelSetFromOptions() of those who use it

  Input Parameter:
. type - copied; names, tables and functions are borrowed until PetscFinalize()

  Notes:
  The registry is the process', and stays: registering the same type again does nothing. Fails with MPM_ERR_INPUT where
  another type has the name. Not for explicit steps.
@*/
PetscErrorCode MpmTermRegister(const MpmTermType *type);

#pragma GCC visibility pop

/*@
  MpmElementValue - value of component c at the point

  MpmElementGradient - its derivative along axis a

  MpmElementAddForce - residual += f w, of a force f at the point in component c, N

  MpmElementAddFlux - residual += q grad w, of the conjugate q of the derivative of component c along axis a, N m

  MpmElementAddStiffness - matrix += k phi psi^T of two basis functions; row p and column q are their places in `basis`,
  c*(dim + 1) of the value of component c, c*(dim + 1) + 1 + a of its derivative along axis a

  Not collective
@*/
static inline PetscReal MpmElementValue(const MpmTermElement *element, PetscInt c)
{
  const PetscReal *w     = element->basis[c * (element->dim + 1)];
  PetscReal        value = 0.;

  for (PetscInt i = 0; i < element->nodes; i++) value += w[i] * element->u[c * element->nodes + i];
  return value;
}

static inline PetscReal MpmElementGradient(const MpmTermElement *element, PetscInt c, PetscInt a)
{
  const PetscReal *g     = element->basis[c * (element->dim + 1) + 1 + a];
  PetscReal        value = 0.;

  for (PetscInt i = 0; i < element->nodes; i++) value += g[i] * element->u[c * element->nodes + i];
  return value;
}

static inline void MpmElementAddForce(const MpmTermElement *element, PetscInt c, PetscReal f, PetscReal residual[])
{
  const PetscReal *w = element->basis[c * (element->dim + 1)];

  for (PetscInt i = 0; i < element->nodes; i++) residual[c * element->nodes + i] += f * w[i];
}

static inline void MpmElementAddFlux(const MpmTermElement *element, PetscInt c, PetscInt a, PetscReal q,
                                     PetscReal residual[])
{
  const PetscReal *g = element->basis[c * (element->dim + 1) + 1 + a];

  for (PetscInt i = 0; i < element->nodes; i++) residual[c * element->nodes + i] += q * g[i];
}

static inline void MpmElementAddStiffness(const MpmTermElement *element, PetscInt p, PetscInt q, PetscReal k,
                                          PetscReal matrix[])
{
  const PetscInt   n = element->nodes, block = element->block, c = p / (element->dim + 1), d = q / (element->dim + 1);
  const PetscReal *phi = element->basis[p], *psi = element->basis[q];

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) matrix[((i * block + c) * block + d) * n + j] += k * phi[i] * psi[j];
}
