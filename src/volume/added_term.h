#pragma once
/*
  Terms of types that were registered from outside the tree (talus/term.h).
*/
#include "base/base.h"
#include "base/types.h"
#include "assembly/terms.h"
#include "talus/term.h"

/* A term of the scene. */
typedef struct {
  MpmTerm            term; /* its entry in the list of terms; ctx: the MpmAddedTerm */
  const MpmTermType *type;
  MpmRegion          region; /* of the initial places of its points */
  double            *parameter;
  MpmLawTable       *table; /* by parameter */
  void              *ctx;   /* the type's own */
  PetscReal          time;  /* end of the step, s */
  PetscBool         *acts;  /* of each point, in the step */
} MpmAddedTerm;

/* The added terms of a scene, with the names of their blocks. */
struct MpmAddedTerms {
  PetscInt               count;
  char                 **names;
  MpmAddedTerm          *at;
  struct MpmBackgrounds *backgrounds; /* of the program's own; NULL: none */
  struct MpmHeldField   *held;        /* bounds of a field with a rate; NULL: none */
};

/* Reads -mpm_terms and its blocks. Collective. */
PetscErrorCode MpmAddedTermsRead(const MpmOptions *options, const MpmGrid *grid, MpmAddedTerms *added);
PetscErrorCode MpmAddedTermsDestroy(MpmAddedTerms *added);
/* True where the blocks of all are symmetric. */
PetscBool MpmAddedTermsAreSymmetric(const MpmAddedTerms *added);
