#pragma once
/*
  A contact of the step by itself: what it says at a displacement of its face (rigid_contact.c, rigid_body.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "terms/rigid.h"

/* What a contact does at a displacement of its face. */
typedef struct {
  PetscBool active;
  PetscReal depth, force[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* force on the material */
  PetscReal stiffness[MPM_MAX_DIM][MPM_MAX_DIM];          /* minus the force's derivative */
} MpmContactAnswer;

/* u: displacement of the face; that which its body sees where it has one that is free. */
void MpmContactEvaluate(const MpmContacts *contacts, const MpmContact *contact, PetscInt dim, const PetscReal u[],
                        MpmContactAnswer *answer);
/* sum_i w_i u_i at the local nodes */
void MpmContactFaceValue(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact, const PetscReal u[],
                         PetscReal value[]);
/* y_i += factor w_i force */
void MpmContactAddForce(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact, PetscReal factor,
                        const PetscReal force[], PetscReal y[]);
