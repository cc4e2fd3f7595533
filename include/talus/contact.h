#pragma once
/*
  Bodies in contact with the material from outside the tree: a rigid body of any shape, given by the distance from its
  surface.

  A scene's boundary is one with -mpm_boundary_NAME_type; the parameters of the type stand in the boundary's block. All
  else of a boundary, its motion, friction, penalty, unknowns and loads, the scene says as of those that are built in.
*/
#include <petscsys.h>
#include "talus/compat.h"
#include "talus/point/tables.h"

/* A body as the functions of its type find it. */
typedef struct {
  MPI_Comm           comm;
  PetscInt           dim;
  const char        *name;      /* of the boundary in the scene */
  const double      *parameter; /* in the order of the type's table; of words the index */
  const MpmLawTable *table;     /* of tables and data; empty for numbers */
  void              *ctx;       /* set by create() */
} MpmContactBody;

/* Distance from a surface, m, positive where the material is, its gradient and its second derivative, 1/m. */
typedef struct {
  PetscReal distance, normal[3], second[3][3];
} MpmContactDistance;

/*
  A type of body: -mpm_boundary_NAME_type. Functions but `distance` may be NULL.

  create    data of a body, after its options have been read; may refuse with MPM_ERR_INPUT. Collective
  destroy   frees them, sets NULL
  distance  at a place x, m, of the body at rest where the scene begins; all components are 0 before. The gradient has
            the length 1, as that of a distance has, also inside the body. Not collective
  middle    the point about which it turns unless the scene says another, and a length of the body's order, m; by
            default the origin, and 1 m
*/
typedef struct {
  const char         *name;
  const char         *summary; /* one line for -help */
  PetscInt            parameter_count;
  const MpmParameter *parameters;
  PetscErrorCode (*create)(MpmContactBody *body);
  PetscErrorCode (*destroy)(MpmContactBody *body);
  void (*distance)(const MpmContactBody *body, const PetscReal x[], MpmContactDistance *distance);
  void (*middle)(const MpmContactBody *body, PetscReal middle[3], PetscReal *size);
} MpmContactBodyType;

#pragma GCC visibility push(default)

/*@
  MpmContactBodyRegister - offers a type of body to the boundaries of this process, under -mpm_boundary_NAME_type

  Not collective, but all ranks must register the same; before MpmModelSetFromOptions() of those who use it

  Input Parameter:
. type - copied; names, tables and functions are borrowed until PetscFinalize()

  Notes:
  The registry is the process', and stays: registering the same type again does nothing. Fails with MPM_ERR_INPUT where
  another type, or one that is built in, has the name.
@*/
PetscErrorCode MpmContactBodyRegister(const MpmContactBodyType *type);

#pragma GCC visibility pop
