#pragma once
/*
  Derivatives of a point of a solid by the deformation gradient F_n at the step's start.

  F_n acts through F' = dF F_n and through the law alone: fluxes V_0 tau dF^{-T} refer to the step's start. Two kinds of
  laws need no direction for each component. With L = Fbar : F' + zbar . z' - q : K,

    elastic ones at finite strain, tau(F'), without a mean over cells: a change of F_n by D is one of dF by dF D F_n^-1
    in F' and tau,

      dL/dF_n = (dF^T dL/ddF - K^T q) F_n^{-T}

    ones with MPM_LAW_VOLUME, which know det F_n alone: with c the derivative along F_n itself, in n dimensions,

      dL/dF_n = F_n^{-T} (F'^T Fbar + (c - Fbar : F')/n I)
*/
#include "space/sum.h"

typedef enum { MPM_START_COMPONENTS, MPM_START_ELASTIC, MPM_START_VOLUME } MpmStartKind;

/* The kind of a material's points. */
MpmStartKind MpmStartKindOf(const MpmSum *sum, PetscInt material);
/* Adds dL/dF_n: from dL/ddF and K, where inputs have dF - I and fluxes q; or from c, F' and its bars. */
void MpmStartPullElastic(const MpmSum *sum, PetscInt p, const PetscReal input[], const PetscReal flux[],
                         const PetscReal by_input[], const PetscReal K[], PetscReal by_F[]);
void MpmStartPullVolume(const MpmSum *sum, PetscInt p, PetscReal along, const PetscReal F[], const PetscReal bars[],
                        PetscReal by_F[]);
