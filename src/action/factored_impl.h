#pragma once
/*
  Data of the sum-factorised action, which factored.c makes and factored_apply.c takes.

  A batch has a point in each lane; lanes that are left over have weights and tangents of zero. Batches of one stack
  have boxes of nodes of one size. Either all of its lanes share a box, whose values are gathered and whose forces are
  scattered once a stack; or each lane has its own.
*/
#include "action/factored.h"

/* Numbers of a tangent at the most. */
#define MPM_TANGENT_MOST 81

/* A lane for each number of a vector register of 512 bits, or of two and more registers. */
#if defined(__AVX512F__)
#define MPM_LANES 8
#else
#define MPM_LANES 4
#endif
typedef PetscReal Lane __attribute__((vector_size(MPM_LANES * sizeof(PetscReal))));

typedef float LaneSingle __attribute__((vector_size(MPM_LANES * sizeof(float))));

/* No vector crosses a call: functions that take one are inlined. Without AVX gcc warns of its place in one. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

typedef struct {
  PetscInt  count[MPM_MAX_DIM]; /* nodes an axis */
  PetscBool shared;             /* one box */
  PetscInt  begin, end;         /* batches */
  size_t    lines;              /* of its first batch, into `lines` */
} MpmStack;

struct MpmFactored {
  const MpmSum *sum;
  PetscBool     half, gradient; /* gradient: inputs are gradients, c * dim + axis; otherwise values */
  PetscInt      block, inputs;  /* unknowns a node, inputs of the kernel */
  PetscInt      size;           /* numbers kept of a tangent */
  PetscBool     single;         /* in single precision */
  PetscInt      stack_count, batch_count;
  MpmStack     *stack;
  PetscInt     *group;   /* of each lane: its group, or -1; MPM_LANES a batch */
  PetscInt     *place;   /* lane of the point at each place of the order */
  Lane         *lines;   /* of each batch and axis: weights, then gradients */
  void         *tangent; /* `size` vectors a batch, Lane or LaneSingle */
  Lane         *work;    /* values and forces at the nodes of a stack */
  size_t        bytes;
};

/* The tangents of a batch, in `room` for them where they are kept in single precision. */
MPM_INLINE const Lane *MpmTangentsOf(const MpmFactored *factored, PetscInt batch, Lane room[])
{
  const LaneSingle *from = (const LaneSingle *)factored->tangent + batch * factored->size;

  if (!factored->single) return (const Lane *)factored->tangent + batch * factored->size;
  for (PetscInt k = 0; k < factored->size; k++) room[k] = __builtin_convertvector(from[k], Lane);
  return room;
}

/* Place of the entry k <= l in the upper triangle by rows of an N x N matrix. */
MPM_INLINE PetscInt MpmTriangleAt(PetscInt N, PetscInt k, PetscInt l)
{
  return k * N - k * (k - 1) / 2 + l - k;
}
