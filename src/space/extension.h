#pragma once
/*
  Small-cut nodes follow well supported ones: aggregated unknowns.
*/
#include "base/base.h"
#include "base/types.h"

/*
  Nodes whose values follow from others': u_s = sum_k e_sk u_k. Local nodes; masters of a rank's local nodes are local.
*/
typedef struct MpmExtension {
  PetscInt   count;    /* of followers */
  PetscInt  *follower; /* local node of each */
  PetscInt  *offset;   /* count + 1, into the next two */
  PetscInt  *master;   /* local nodes */
  PetscReal *weight;   /* e_sk */
  PetscInt  *of;       /* per local node: its place among the followers, or -1; NULL: there are none on this rank */
} MpmExtension;

/*
  Boxes: finds the followers of this rank's nodes and appends boxes that make their masters local. Behind the boxes of all terms, before
  the nodes are numbered. Number: the local numbers, afterwards. Collective.
*/
PetscErrorCode MpmExtensionBoxes(const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
PetscErrorCode MpmExtensionNumber(MpmSpace *space);
PetscErrorCode MpmExtensionReset(MpmExtension *extension);
