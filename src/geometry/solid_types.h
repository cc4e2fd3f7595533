#pragma once
/*
  Types of bodies in contact that callers and plugins have registered, and a body of one.
*/
#include "talus/contact.h"

/* The k-th type, in the order of registration; NULL behind the last. */
const MpmContactBodyType *MpmContactBodyTypeAt(PetscInt k);

/* A body of such a type; made and destroyed by its boundary (added_body.c). */
typedef struct MpmAddedBody {
  const MpmContactBodyType *type;
  MpmContactBody            body;
  double                   *parameter;
  MpmLawTable              *table;
} MpmAddedBody;
