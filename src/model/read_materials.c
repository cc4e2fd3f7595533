/*
  The scene's materials, of blocks and of a table, and fields of their numbers.
*/
#include "options/options.h"
#include "ground/ground.h"
#include "point/air.h"
#include "point/material.h"
#include "point/registry.h"
#include "grid/grid.h"
#include "query/model.h"
#include "query/query.h"
#include "model/build.h"
#include "model/material_table.h"

/* Fields of the materials' numbers; before the materials. */
static PetscErrorCode ReadGrounds(MpmModel model, const MpmOptions *options)
{
  const MpmGrid *grid = model->disc.grid;
  MpmGroundGrid  cells;

  PetscFunctionBeginUser;
  cells.dim = grid->dim;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    cells.lower[a] = grid->lower[a];
    cells.h[a]     = grid->h[a];
    cells.cells[a] = grid->cells[a];
  }
  PetscCall(MpmGroundsRead(options, &cells, &model->scene.materials->grounds));
  PetscCall(MpmGroundsCheckMaterials(model->scene.materials->grounds, model->scene.materials->count,
                                     model->scene.materials->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterial(MpmModel model, const MpmOptions *options, const char name[], MpmMaterial *material)
{
  const MpmGrounds *grounds = model->scene.materials->grounds;

  PetscFunctionBeginUser;
  if (model->scene.deformation.bed) PetscCall(MpmMaterialCreateColumn(options, name, grounds, material));
  else PetscCall(MpmMaterialCreate(options, name, (PetscInt)model->scene.deformation.kinematics, grounds, material));
  PetscCall(MpmMaterialReadPhysics(options, &model->scene.physics, model->disc.dim, grounds, material));
  PetscCall(MpmMaterialReadAir(options, material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReadMaterials(MpmModel model, const MpmOptions *options)
{
  MpmMaterials    *materials = model->scene.materials;
  MpmMaterialTable table     = {NULL};
  PetscReal        stiffest  = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmMaterialTableRead(options, &materials->count, &materials->names, &table));
  PetscCall(PetscCalloc1(materials->count, &materials->at));
  PetscCall(ReadGrounds(model, options));
  model->solver.definite.symmetric = PETSC_TRUE;
  for (PetscInt m = 0; m < materials->count; m++) {
    const MpmOptions *read;

    PetscCall(MpmMaterialTableEnter(options, materials->names[m], m, &table, &read));
    PetscCall(
      MpmMaterialTableLeave(options, ReadMaterial(model, read, materials->names[m], &materials->at[m]), &table));
    if (!(materials->at[m].info.traits & MPM_LAW_SYMMETRIC)) model->solver.definite.symmetric = PETSC_FALSE;
    stiffest = PetscMax(stiffest, materials->at[m].moduli.stiffness);
  }
  model->disc.matrix.diagonal = MpmNodeStiffness(&model->disc, stiffest);
  PetscCall(MpmMaterialTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}
