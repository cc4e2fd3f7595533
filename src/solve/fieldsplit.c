/*
  Preconditioners by blocks, for a displacement and one unknown beside it.

  poro-fieldsplit, for a pressure that keeps the volume. The Jacobian is [A, B; C, -D]: A the solid's stiffness, D flow
  and storage of the pressure's own gradient and value in the step. PETSc's PCFIELDSPLIT factors it by blocks, with
  multigrid for A, which gets the rigid body modes, and for

    S = -(D + M) ,   M_ij = sum_p V_0 phi_i phi_j / (lambda + 2 mu)

  in place of the Schur complement -(D + C A^{-1} B). A pressure that varies like a wave is resisted by the modulus of
  compression along the wave, so that M, by the material at each point, is C A^{-1} B in the inside of uniform ground. M
  counts where little drains in the step, and D, with mobility times the step, storage and the stabilisation, where much
  does. Where permeability changes by orders of magnitude from layer to layer each dominates in its layers.

  Source of the idea: the fixed-stress splitting as a preconditioner, White, Castelletto and Tchelepi (2016),
  doi:10.1016/j.cma.2015.12.010.

  damage-fieldsplit, for the damage of a solid: the Jacobian is [A, B; C, D], with definite A and D. The damage is
  solved for first, then the displacement with B times the new damage. This block Gauss-Seidel is exact in iterations
  in turn, where C = 0 (alternate.c). Source: Farrell and Maurini (2017), doi:10.1002/nme.5300.
*/
#include "options/database.h"
#include "particles/point_mass.h"
#include "space/point_loop.h"
#include "bc/bc.h"
#include "problem/discretization.h"
#include "solve/solve.h"

PetscBool MpmFieldsplitServes(const MpmLayout *layout)
{
  return (PetscBool)(layout->block == layout->dim + 1 && layout->field_count == 2);
}

PetscBool MpmFieldsplitServesDamage(const MpmLayout *layout)
{
  return (PetscBool)(MpmFieldsplitServes(layout) && layout->traits.alternate);
}

#define PREFIX "fieldsplit_u_"

/*
  The displacement's multigrid: that on coarser lattices (src/levels), with one step of ILU(0) for saturated ground, and
  with SOR under damage, since broken material under pressure is almost incompressible and has no stable incomplete
  factors (docs/solver.md has tables). Contacts' stiff couplings of many nodes disturb both: GAMG there, with ILU(0),
  and a shift in N/m, far below a node's stiffness, over singular blocks.
*/
PetscErrorCode MpmFieldsplitTune(MpmSolver *solver, PetscBool contacts)
{
  const PetscBool lattices = (PetscBool)(!contacts && !strcmp(solver->jacobian.mat_type, MATAIJ));
  char            type[64] = "";
  PetscBool       chosen;

  PetscFunctionBeginUser;
  if (lattices) PetscCall(MpmDatabaseDefault("-" PREFIX "pc_type", "levels"));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-" PREFIX "pc_type", type, sizeof(type), &chosen));
  if (!strcmp(type, "levels")) {
    if (!solver->disc->layout->traits.saddle && !solver->multigrid.smoother)
      PetscCall(MpmDatabaseDefault("-" PREFIX "mg_levels_pc_type", PCSOR));
    PetscCall(MpmMultigridApply(solver, PREFIX, contacts));
  }
  if (chosen || !contacts) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmDatabaseHas(PREFIX "mg_levels_pc_type", &chosen));
  if (chosen) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmDatabaseDefault("-" PREFIX "mg_levels_pc_type", "bjacobi"));
  PetscCall(MpmDatabaseDefault("-" PREFIX "mg_levels_sub_pc_type", "ilu"));
  PetscCall(MpmDatabaseDefault("-" PREFIX "mg_levels_sub_pc_factor_shift_type", "inblocks"));
  PetscCall(MpmDatabaseDefault("-" PREFIX "mg_levels_sub_pc_factor_shift_amount", "1"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsplitReset(MpmFieldsplit *split)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < 2; f++) PetscCall(ISDestroy(&split->is[f]));
  PetscCall(MatDestroy(&split->schur));
  PetscCall(MatDestroy(&split->mass));
  split->modes = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The unknowns of the displacement, by nodes, and those of the other field. */
static PetscErrorCode CreateSets(MpmSolver *solver)
{
  const MpmSpace *space = solver->disc->space;
  const PetscInt  bs = solver->disc->block, dim = solver->disc->dim, begin = space->number.begin * bs;
  MPI_Comm        comm = solver->disc->comm;
  PetscInt       *row;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((space->owned * dim), &row));
  for (PetscInt k = 0; k < space->owned * dim; k++) row[k] = begin + k / dim * bs + k % dim;
  PetscCall(ISCreateGeneral(comm, space->owned * dim, row, PETSC_OWN_POINTER, &solver->split.is[0]));
  PetscCall(ISSetBlockSize(solver->split.is[0], dim));
  PetscCall(ISCreateStride(comm, space->owned, begin + dim, bs, &solver->split.is[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsplitAttach(MpmSolver *solver)
{
  KSP       ksp;
  PC        pc;
  PetscBool is;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCFIELDSPLIT, &is));
  solver->split.on =
    (PetscBool)(is && MpmFieldsplitServes(solver->disc->layout) &&
                (solver->disc->layout->traits.saddle || MpmFieldsplitServesDamage(solver->disc->layout)));
  if (!solver->split.on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmFieldsplitReset(&solver->split));
  PetscCall(CreateSets(solver));
  if (MpmFieldsplitServesDamage(solver->disc->layout)) PetscCall(PCFieldSplitSetIS(pc, "d", solver->split.is[1]));
  PetscCall(PCFieldSplitSetIS(pc, "u", solver->split.is[0]));
  if (solver->disc->layout->traits.saddle) PetscCall(PCFieldSplitSetIS(pc, "p", solver->split.is[1]));
  solver->split.levels = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rigid body modes of the whole, without the other field, for the displacement's multigrid. */
static PetscErrorCode TakeModes(MpmSolver *solver)
{
  MatNullSpace  all, own;
  const Vec    *mode;
  Vec          *part;
  PetscInt      count, kept = 0;
  PetscObjectId id;

  PetscFunctionBeginUser;
  PetscCall(MatGetNearNullSpace(solver->jacobian.assembled, &all));
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectGetId((PetscObject)all, &id));
  if (id == solver->split.modes) PetscFunctionReturn(PETSC_SUCCESS);
  solver->split.modes = id;
  PetscCall(MatNullSpaceGetVecs(all, NULL, &count, &mode));
  PetscCall(PetscMalloc1(count, &part));
  for (PetscInt k = 0; k < count; k++) {
    PetscReal norm;
    Vec       sub;

    PetscCall(VecGetSubVector(mode[k], solver->split.is[0], &sub));
    PetscCall(VecDuplicate(sub, &part[kept]));
    PetscCall(VecCopy(sub, part[kept]));
    PetscCall(VecRestoreSubVector(mode[k], solver->split.is[0], &sub));
    PetscCall(VecNormalize(part[kept], &norm)); /* a mode is one of either field */
    if (norm > 0.5) kept++;
    else PetscCall(VecDestroy(&part[kept]));
  }
  PetscCall(MatNullSpaceCreate(solver->disc->comm, PETSC_FALSE, kept, part, &own));
  PetscCall(PetscObjectCompose((PetscObject)solver->split.is[0], "nearnullspace", (PetscObject)own));
  PetscCall(MatNullSpaceDestroy(&own));
  for (PetscInt k = 0; k < kept; k++) PetscCall(VecDestroy(&part[k]));
  PetscCall(PetscFree(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One group's part of M, in the solver's units: element[i*n + j]. */
static PetscErrorCode GroupMass(const MpmSum *sum, const MpmGroup *group, PetscReal unit, MpmWorkspace *work,
                                PetscReal element[])
{
  const MpmPoints *points = sum->points;
  const MpmKnown   known  = KnownGeneral(sum->layout, group);
  const PetscInt   dim = known.dim, n = known.n;
  const PetscInt   basis = sum->layout->component[dim].shape * MPM_BASES;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(element, n * n));
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt     p        = sum->space->order[s];
    const PetscReal   *state    = points->state ? &points->state[p * sum->kept.state] : NULL;
    const MpmMaterial *material = &sum->materials[points->material[p]];
    const PetscReal M = MpmMaterialStiffness(material, MpmPointOwn(points, material, p), state, MpmPointF(points, p));

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal factor = unit * unit * points->volume0[p] / M * MpmBasisAt(&work->basis, basis, i);

      for (PetscInt j = 0; j < n; j++) element[i * n + j] += factor * MpmBasisAt(&work->basis, basis, j);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* M, on the sparsity of `mat`, without rows and columns that are prescribed. */
static PetscErrorCode MakeMass(const MpmSolver *solver, Mat mat)
{
  const MpmSum         *sum         = solver->disc->sum;
  const MpmSpace       *space       = sum->space;
  const MpmConstraints *constraints = solver->disc->constraints;
  const PetscInt        bs = solver->disc->block, dim = solver->disc->dim, most = PetscPowInt(space->width, dim);
  PetscInt             *row;
  PetscReal            *element;
  MpmWorkspace          work;

  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(mat));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc2((most * most), &element, most, &row));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (group->point_begin == group->point_end) continue;
    PetscCall(GroupMass(sum, group, constraints->unit[dim], &work, element));
    for (PetscInt i = 0; i < group->node_count; i++) {
      const PetscInt node = space->group_nodes[group->node_offset + i];

      row[i] = MpmConstraintsFree(constraints, node * bs + dim) ? space->number.global[node] : -1;
    }
    PetscCall(MatSetValues(mat, group->node_count, row, group->node_count, row, element, ADD_VALUES));
  }
  PetscCall(MatAssemblyBegin(mat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(mat, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscFree2(element, row));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step's nodes for the displacement's preconditioner, which PETSc makes when it sets up the blocks. */
static PetscErrorCode AttachLevels(MpmSolver *solver, PC pc)
{
  char     type[64] = "";
  KSP     *block;
  PC       own;
  PetscInt count;

  PetscFunctionBeginUser;
  solver->split.levels = PETSC_FALSE;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-" PREFIX "pc_type", type, sizeof(type), NULL));
  if (strcmp(type, "levels")) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCSetOperators(pc, solver->jacobian.shell ? solver->jacobian.shell : solver->jacobian.assembled,
                           solver->jacobian.assembled));
  PetscCall(PCSetUp(pc));
  PetscCall(PCFieldSplitGetSubKSP(pc, &count, &block));
  PetscCall(KSPGetPC(block[solver->disc->layout->traits.saddle ? 0 : count - 1], &own));
  PetscCall(MpmMultigridAttach(solver, own, solver->disc->dim));
  PetscCall(PetscFree(block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrix in place of the Schur complement. */
static PetscErrorCode UpdateSchur(MpmSolver *solver, PC pc)
{
  MpmFieldsplit *split = &solver->split;
  const MatReuse reuse = split->schur ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX;

  PetscFunctionBeginUser;
  PetscCall(MatCreateSubMatrix(solver->jacobian.assembled, split->is[1], split->is[1], reuse, &split->schur));
  if (!split->mass) PetscCall(MatDuplicate(split->schur, MAT_DO_NOT_COPY_VALUES, &split->mass));
  PetscCall(MakeMass(solver, split->mass));
  PetscCall(MatAXPY(split->schur, -1., split->mass, SAME_NONZERO_PATTERN));
  PetscCall(PCFieldSplitSetSchurPre(pc, PC_FIELDSPLIT_SCHUR_PRE_USER, split->schur));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsplitUpdate(MpmSolver *solver)
{
  KSP ksp;
  PC  pc;

  PetscFunctionBeginUser;
  if (!solver->split.on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(TakeModes(solver));
  if (solver->disc->layout->traits.saddle) PetscCall(UpdateSchur(solver, pc));
  if (solver->split.levels) PetscCall(AttachLevels(solver, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}
