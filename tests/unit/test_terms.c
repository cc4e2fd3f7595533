/*
  Every term of the residual by itself, against the matrix of its own element blocks: its action, its transposed action
  and its diagonal; and the gradient of a quadratic term's energy against its residual. The scenes together have all
  terms. The action of all terms together, and its transpose, are those of the whole Jacobian's matrix.

  Ranks: 1 2 3
*/
#include "space/unit.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "loads/body_surface.h"
#include "points/action.h"
#include "points/point_terms.h"
#include "problem/discretization.h"
#include "scene.h"
#include "volume/damping.h"
#include "volume/inertia.h"
#include "step/integrator.h"
#include "volume/volume.h"

static const MpmTerm *const all[] = {&MpmTermPoints,  &MpmTermCellMeans,   &MpmTermWaterWeight, &MpmTermGhost,
                                     &MpmTermContact, &MpmTermBodyContact, &MpmTermRigidBodies, &MpmTermInertia,
                                     &MpmTermDamping, &MpmTermSurfaces,    &MpmTermSurfaceFlow};
#define TERMS PETSC_STATIC_ARRAY_LENGTH(all)

#define BLOCKS_2D \
  "-mpm_dim 2 -mpm_load_g_value 0,-9.81 -mpm_grid_lower 0,0 -mpm_grid_upper 3,3 -mpm_grid_cells 6,6 " \
  "-mpm_body_low_region box " \
  "-mpm_body_low_lower 0.5,0.5 -mpm_body_low_upper 2.5,1.25 -mpm_body_high_region box -mpm_body_high_lower 0.9,1.25 " \
  "-mpm_body_high_upper 2.15,2 -mpm_boundary_floor_point 0.5,0.5 -mpm_boundary_floor_normal 0.1,1 " \
  "-mpm_boundary_lid_type polygon -mpm_boundary_lid_vertices 0.8,2,2.3,2,2.3,2.2,0.8,2.2 -mpm_boundary_lid_free " \
  "x,y,rz " \
  "-mpm_boundary_lid_load 100,-2000 -mpm_boundary_lid_moment 300 "
#define BLOCKS_3D \
  "-mpm_dim 3 -mpm_load_g_value 0,0,-9.81 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,2 -mpm_grid_cells 4,4,4 " \
  "-mpm_body_low_region box " \
  "-mpm_body_low_lower 0.5,0.5,0.5 -mpm_body_low_upper 1.5,1.5,1 -mpm_body_high_region box -mpm_body_high_lower " \
  "0.7,0.6,1 -mpm_body_high_upper 1.4,1.3,1.5 -mpm_boundary_floor_point 0.5,0.5,0.5 -mpm_boundary_floor_normal " \
  "0.1,0,1 " \
  "-mpm_boundary_lid_type plane -mpm_boundary_lid_point 1,1,1.5 -mpm_boundary_lid_normal 0,0,-1 " \
  "-mpm_boundary_lid_free " \
  "x,z,rx,ry,rz -mpm_boundary_lid_load 50,0,-900 -mpm_boundary_lid_moment 40,-70,0 "
#define COMMON \
  "-mpm_bodies low,high -mpm_materials m -mpm_body_low_material m -mpm_body_high_material m -mpm_material_m_density " \
  "1000 -mpm_contacts ab -mpm_contact_ab_bodies low,high -mpm_contact_ab_friction 0.3 -mpm_boundaries floor,lid " \
  "-mpm_boundary_floor_type plane -mpm_boundary_floor_friction 0.2 -mpm_boundary_lid_friction 0.3 " \
  "-mpm_surfaces side -mpm_surface_side_body low -mpm_surface_side_side +x -mpm_time_step 0.1 -mpm_time_end 1 " \
  "-mpm_shape gimp -mpm_stabilization_ghost 0.05 -mpm_loads g -mpm_load_g_type gravity -mpm_quiet -pc_type jacobi "
#define DRY \
  "-mpm_material_m_type neo_hookean -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 -mpm_surface_side_normal -1e4 "
#define MOVES "-mpm_time_integrator newmark -mpm_time_damping_mass 2 -mpm_time_damping_stiffness 0.01 "
#define WET \
  "-mpm_physics poro -mpm_material_m_type neo_hookean -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 " \
  "-mpm_material_m_porosity 0.4 -mpm_material_m_permeability 1e-9 -mpm_surface_side_drained true " \
  "-mpm_contact_ab_water open "

static const char *const scenes[] = {BLOCKS_2D COMMON DRY "-mpm_stabilization_fbar false " MOVES,
                                     BLOCKS_3D COMMON DRY "-mpm_stabilization_fbar false " MOVES,
                                     BLOCKS_2D COMMON DRY "-mpm_stabilization_fbar true ", BLOCKS_2D COMMON WET,
                                     BLOCKS_3D COMMON WET};

/* A step with the scene's integrator, up to Newton; local unknowns at random in disc.nodal.u. */
static PetscErrorCode Begin(MpmModel model)
{
  PetscReal  amplitude[MPM_MAX_BLOCK];
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscCall(model->state.scheme.integrator->begin(model, model->state.time + 0.1, 0.1, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "%s", outcome.text);
  for (PetscInt c = 0; c < model->disc.block; c++) amplitude[c] = c < model->disc.dim ? 0.02 : 1e3;
  PetscCall(SceneFill(model, 1, amplitude, PETSC_FALSE, model->solver.x));
  PetscCall(MpmGatherSolution(&model->solver, model->solver.x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The term's matrix, without the scale of unknowns. */
static PetscErrorCode Assemble(MpmModel model, PetscInt k, Mat *mat)
{
  const MpmDiscretization *disc   = &model->disc;
  MpmConstraints           plain  = *disc->constraints;
  PetscInt                 failed = 0;

  PetscFunctionBeginUser;
  plain.scaled = PETSC_FALSE;
  PetscCall(MatDuplicate(model->solver.jacobian.assembled, MAT_DO_NOT_COPY_VALUES, mat));
  PetscCall(MpmPatternBegin(disc->matrix.pattern, disc->space, &plain, *mat));
  PetscCall(
    disc->terms->term[k]->tangent(disc->terms->ctx[k], disc->sum, disc->nodal.u, disc->matrix.pattern, NULL, &failed));
  PetscCall(MpmPatternEnd(disc->matrix.pattern, disc->space, *mat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Random values at the owned and at all local nodes. */
static PetscErrorCode Random(MpmModel model, PetscInt seed, Vec owned, PetscReal local[])
{
  const PetscInt     bs          = model->disc.block;
  const PetscReal    amplitude[] = {1., 1., 1., 1., 1., 1.};
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(SceneFill(model, seed, amplitude, PETSC_TRUE, owned));
  PetscCall(VecGetArrayRead(owned, &values));
  PetscCall(PetscArraycpy(local, values, model->disc.space->owned * bs));
  PetscCall(VecRestoreArrayRead(owned, &values));
  PetscCall(MpmSpaceToGhosts(model->disc.space, bs, local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |y - z| over |z|, y at the local nodes in parts. */
static PetscErrorCode Off(MpmModel model, PetscReal y[], Vec z, PetscReal *off)
{
  const PetscInt bs = model->disc.block;
  PetscScalar   *values;
  PetscReal      norm;

  PetscFunctionBeginUser;
  PetscCall(MpmSpaceAddToOwners(model->disc.space, bs, y));
  PetscCall(VecNorm(z, NORM_2, &norm));
  PetscCall(VecGetArray(z, &values));
  for (PetscInt i = 0; i < model->disc.space->owned * bs; i++) values[i] -= y[i];
  PetscCall(VecRestoreArray(z, &values));
  PetscCall(VecNorm(z, NORM_2, off));
  *off = norm > 0. ? *off / norm : *off;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += K v, of the points by their own form. */
static PetscErrorCode Apply(MpmModel model, PetscInt k, const PetscReal v[], PetscReal y[])
{
  const MpmDiscretization *disc = &model->disc;
  MpmAction                action;
  PetscInt                 failed = 0;

  PetscFunctionBeginUser;
  if (!disc->terms->term[k]->points) {
    PetscCall(MpmTermsApplyOne(disc->terms, k, disc->sum, disc->nodal.u, v, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmActionCreate(disc->terms, disc->sum, PETSC_FALSE, PETSC_FALSE, &action));
  PetscCall(MpmActionSetState(&action, disc->nodal.u, &failed));
  for (PetscInt unit = 0; unit < MpmUnitCount(disc->sum); unit++)
    PetscCall(MpmActionApplyUnit(&action, unit, v, y, &failed));
  PetscCall(MpmActionDestroy(&action));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest difference of diagonal blocks from the matrix's, over its largest entry on the diagonal. */
static PetscErrorCode Diagonal(MpmModel model, PetscInt k, Mat mat, PetscReal *off)
{
  const MpmDiscretization *disc = &model->disc;
  const PetscInt           bs   = disc->block;
  PetscReal               *blocks, sums[2] = {0., 0.};
  PetscInt                 failed = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((disc->space->local * bs * bs), &blocks));
  PetscCall(MpmTermsDiagonalOne(disc->terms, k, disc->sum, disc->nodal.u, blocks, &failed));
  PetscCall(MpmSpaceAddToOwners(disc->space, bs * bs, blocks));
  for (PetscInt i = 0; i < disc->space->owned; i++) {
    PetscInt    rows[MPM_MAX_BLOCK];
    PetscScalar block[MPM_MAX_BLOCK * MPM_MAX_BLOCK];

    for (PetscInt c = 0; c < bs; c++) rows[c] = (disc->space->number.begin + i) * bs + c;
    PetscCall(MatGetValues(mat, bs, rows, bs, rows, block));
    for (PetscInt cd = 0; cd < bs * bs; cd++) {
      if (!MpmConstraintsFree(disc->constraints, i * bs + cd / bs) ||
          !MpmConstraintsFree(disc->constraints, i * bs + cd % bs))
        continue;
      sums[0] = PetscMax(sums[0], PetscAbsScalar(block[cd] - blocks[i * bs * bs + cd]));
      sums[1] = PetscMax(sums[1], PetscAbsScalar(block[cd]));
    }
  }
  PetscCall(PetscFree(blocks));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_MAX, model->comm));
  *off = sums[1] > 0. ? sums[0] / sums[1] : sums[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 1/2 u . (r(u) + r(0)) at disc.nodal.u + part v. */
static PetscErrorCode Energy(MpmModel model, PetscInt k, PetscReal part, const PetscReal v[], PetscReal *energy)
{
  const MpmDiscretization *disc   = &model->disc;
  const PetscInt           count  = disc->space->local * disc->block;
  PetscInt                 failed = 0;
  PetscReal               *u, *force;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(count, &u, count, &force));
  PetscCall(disc->terms->term[k]->residual(disc->terms->ctx[k], disc->sum, u, force, &failed));
  for (PetscInt i = 0; i < count; i++) u[i] = disc->nodal.u[i] + part * v[i];
  PetscCall(disc->terms->term[k]->residual(disc->terms->ctx[k], disc->sum, u, force, &failed));
  *energy = 0.;
  for (PetscInt i = 0; i < count; i++) *energy += 0.5 * u[i] * force[i];
  PetscCall(PetscFree2(u, force));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The energy's slope along v by a difference, which is exact, against the work of the residual, over the latter. */
static PetscErrorCode Gradient(MpmModel model, PetscInt k, const PetscReal v[], PetscReal *off)
{
  const MpmDiscretization *disc   = &model->disc;
  const PetscInt           count  = disc->space->local * disc->block;
  PetscInt                 failed = 0;
  PetscReal               *force, energy[2], sums[2] = {0., 0.};

  PetscFunctionBeginUser;
  PetscCall(Energy(model, k, -1., v, &energy[0]));
  PetscCall(Energy(model, k, 1., v, &energy[1]));
  PetscCall(PetscCalloc1(count, &force));
  PetscCall(disc->terms->term[k]->residual(disc->terms->ctx[k], disc->sum, disc->nodal.u, force, &failed));
  for (PetscInt i = 0; i < count; i++) {
    sums[0] += force[i] * v[i];
    sums[1] += PetscAbsReal(force[i] * v[i]);
  }
  PetscCall(PetscFree(force));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *off = PetscAbsReal(0.5 * (energy[1] - energy[0]) - sums[0]) /
         PetscMax(PetscMax(PetscAbsReal(energy[0]), PetscAbsReal(energy[1])), sums[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The term's forms against its matrix; `acts`: the matrix is not 0. */
static PetscErrorCode Look(MpmModel model, PetscInt k, PetscInt scene, PetscBool *acts)
{
  const MpmDiscretization *disc  = &model->disc;
  const MpmTerm           *term  = disc->terms->term[k];
  const PetscInt           count = disc->space->local * disc->block;
  PetscReal               *v, *y, norm, off[3], gradient = 0.;
  Mat                      mat;
  Vec                      x, z;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &v, count, &y));
  PetscCall(Assemble(model, k, &mat));
  PetscCall(MatNorm(mat, NORM_FROBENIUS, &norm));
  *acts = (PetscBool)(norm > 0.);
  PetscCall(VecDuplicate(model->solver.x, &x));
  PetscCall(VecDuplicate(x, &z));
  PetscCall(Random(model, 5, x, v));
  PetscCall(PetscArrayzero(y, count));
  PetscCall(Apply(model, k, v, y));
  PetscCall(MatMult(mat, x, z));
  PetscCall(Off(model, y, z, &off[0]));
  PetscCall(PetscArrayzero(y, count));
  PetscCall(MpmTermsTransposeOne(disc->terms, k, disc->sum, disc->nodal.u, v, y));
  PetscCall(MatMultTranspose(mat, x, z));
  PetscCall(Off(model, y, z, &off[1]));
  PetscCall(Diagonal(model, k, mat, &off[2]));
  if (term->energy.quadratic && term->energy.quadratic(disc->terms->ctx[k]))
    PetscCall(Gradient(model, k, v, &gradient));
  ck_assert_msg(SceneAll((PetscBool)(off[0] <= 1e-13)), "scene %d, %s: action and matrix differ by %g", (int)scene,
                term->name, (double)off[0]);
  ck_assert_msg(SceneAll((PetscBool)(off[1] <= 1e-14)), "scene %d, %s: transposed action and matrix differ by %g",
                (int)scene, term->name, (double)off[1]);
  ck_assert_msg(SceneAll((PetscBool)(off[2] <= 1e-13)), "scene %d, %s: diagonals differ by %g", (int)scene, term->name,
                (double)off[2]);
  ck_assert_msg(SceneAll((PetscBool)(gradient <= 1e-12)), "scene %d, %s: energy and residual differ by %g", (int)scene,
                term->name, (double)gradient);
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&z));
  PetscCall(MatDestroy(&mat));
  PetscCall(PetscFree2(v, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The whole Jacobian's action and transposed action against its matrix, constraints and units included. */
static PetscErrorCode LookWhole(MpmModel model, PetscInt scene)
{
  const PetscReal amplitude[] = {1., 1., 1., 1., 1., 1.};
  PetscReal       off;
  Mat             local;
  Vec             v;

  PetscFunctionBeginUser;
  model->solver.preset.factorises = PETSC_FALSE; /* no raised diagonals */
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_LOCAL, model->solver.x, &local));
  PetscCall(VecDuplicate(model->solver.x, &v));
  PetscCall(SceneFill(model, 6, amplitude, PETSC_TRUE, v));
  for (PetscInt stored = 0; stored < 2; stored++) {
    PetscCall(SceneAction(model, local, model->solver.x, v, (PetscBool)stored, &off));
    ck_assert_msg(SceneAll((PetscBool)(off <= 1e-13)), "scene %d: the Jacobian's action %s tangents is off by %g",
                  (int)scene, stored ? "with" : "without", (double)off);
  }
  PetscCall(VecDestroy(&v));
  PetscCall(MatDestroy(&local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(forms)
{
  PetscBool seen[TERMS] = {PETSC_FALSE};

  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(scenes); s++) {
    MpmModel model;

    SCENE_CALL(SceneCreate(PETSC_COMM_WORLD, NULL, scenes[s], &model));
    SCENE_CALL(Begin(model));
    for (PetscInt k = 0; k < model->disc.terms->count; k++) {
      PetscBool acts;

      SCENE_CALL(Look(model, k, (PetscInt)s, &acts));
      for (size_t t = 0; t < TERMS; t++)
        if (all[t] == model->disc.terms->term[k]) seen[t] = (PetscBool)(seen[t] || acts);
    }
    SCENE_CALL(LookWhole(model, (PetscInt)s));
    SCENE_CALL(SceneDestroy(&model));
  }
  for (size_t t = 0; t < TERMS; t++) ck_assert_msg(seen[t], "%s acts in no scene", all[t]->name);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {forms};

  return UnitRun(&argc, &argv, "terms", sizeof(tests) / sizeof(tests[0]), tests);
}
