/*
  Several ranks: ownership, points on the move, node numbers, and results independent of the number of ranks.

  Ranks: 1 2 3 4
*/
#include "scene.h"

static PetscMPIInt my_rank, rank_count;

static const char *const material =
  "-mpm_materials m -mpm_material_m_type hencky -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 "
  "-mpm_material_m_density 1000 -mpm_bodies b -mpm_body_b_material m ";
/* a long bar in a grid that is far larger */
static const char *const bar =
  "-mpm_dim 2 -mpm_grid_lower -10,-5 -mpm_grid_upper 20,6 -mpm_grid_cells 120,44 -mpm_body_b_region box "
  "-mpm_body_b_lower 0,0 -mpm_body_b_upper 6,0.5 -mpm_shape gimp -mpm_time_step 0.25 ";
/* a thick L, for cuts on two axes */
static const char *const angle =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 8,8 -mpm_grid_cells 16,16 -mpm_body_b_region polygon "
  "-mpm_body_b_vertices 1,1,7,1,7,3,3,3,3,7,1,7 -mpm_shape bspline2 -mpm_time_step 0.25 ";
static const char *const block =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 4,3,5 -mpm_grid_cells 8,6,10 -mpm_body_b_region box "
  "-mpm_body_b_lower 1,1,0 -mpm_body_b_upper 3,2,3 -mpm_shape gimp -mpm_time_step 0.25 ";
/* all points in one cell */
static const char *const crumb =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 8,8 -mpm_grid_cells 16,16 -mpm_body_b_region box "
  "-mpm_body_b_lower 4,4 -mpm_body_b_upper 4.5,4.5 -mpm_shape linear -mpm_time_step 0.5 ";

static PetscErrorCode Create(MPI_Comm comm, const char *scene, const char *more, MpmModel *model)
{
  char options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(options, sizeof(options), "%s%s%s", scene, material, more));
  PetscCall(SceneCreate(comm, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ownership ---- */

/* Nodes of the lattice per rank; every rank counts them all. */
static PetscErrorCode CountNodes(const MpmGrid *grid, PetscInt nodes[])
{
  PetscInt node[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(nodes, grid->size));
  for (node[2] = 0; node[2] < grid->nodes[2]; node[2]++)
    for (node[1] = 0; node[1] < grid->nodes[1]; node[1]++)
      for (node[0] = 0; node[0] < grid->nodes[0]; node[0]++) nodes[MpmGridNodeOwner(grid, node)]++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Boxes at random places whose owners are not all found, or not in their order. */
static PetscInt CountWrongBoxes(const MpmGrid *grid)
{
  PetscInt wrong = 0, lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], node[MPM_MAX_DIM];

  for (PetscInt trial = 0; trial < 40; trial++) {
    PetscMPIInt owner[4];
    PetscBool   found[4] = {PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE};
    PetscInt    owners;

    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      lower[a] = (PetscInt)(0.5 * (SceneRandom(7, trial, a) + 1.) * (PetscReal)grid->nodes[a]) - 1;
      upper[a] = lower[a] + trial % 5;
    }
    for (node[2] = lower[2]; node[2] <= upper[2]; node[2]++)
      for (node[1] = lower[1]; node[1] <= upper[1]; node[1]++)
        for (node[0] = lower[0]; node[0] <= upper[0]; node[0]++) found[MpmGridNodeOwner(grid, node)] = PETSC_TRUE;
    owners = MpmGridBoxOwners(grid, lower, upper, owner);
    for (PetscInt k = 0; k < owners; k++) {
      if (k && owner[k] <= owner[k - 1]) wrong++;
      found[owner[k]] = PETSC_FALSE;
    }
    for (PetscInt r = 0; r < 4; r++) wrong += found[r] ? 1 : 0;
  }
  return wrong;
}

/* Points of this rank whose cell another owns. */
static PetscErrorCode CountMisplaced(MpmParticles *particles, const MpmGrid *grid, PetscInt *misplaced)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  *misplaced = 0;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &points.x[p * grid->dim], cell);
    *misplaced += MpmGridNodeOwner(grid, cell) != grid->rank;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(ownership)
{
  const char *const scenes[] = {bar, angle, block, crumb};

  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(scenes); s++) {
    MpmModel       model;
    const MpmGrid *grid;
    PetscInt       misplaced = 0, mine, nodes[4];

    SCENE_CALL(Create(PETSC_COMM_WORLD, scenes[s], "", &model));
    grid = model->disc.grid;
    SCENE_CALL(CountMisplaced(model->state.particles, grid, &misplaced));
    SCENE_CALL(CountNodes(grid, nodes));
    ck_assert_msg(SceneAll((PetscBool)(misplaced == 0)), "scene %d: points on the wrong rank", (int)s);
    for (PetscInt r = 0; r < rank_count; r++)
      ck_assert_msg(nodes[r] > 0 || scenes[s] == crumb, "scene %d: rank %d owns no node", (int)s, (int)r);
    ck_assert_int_eq((int)CountWrongBoxes(grid), 0);
    mine = nodes[my_rank];
    SCENE_CALL(MPI_Bcast(nodes, (PetscMPIInt)rank_count, MPIU_INT, 0, PETSC_COMM_WORLD));
    ck_assert_msg(SceneAll((PetscBool)(nodes[my_rank] == mine)), "scene %d: ranks see different cuts", (int)s);
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* Balanced shapes, and the allowed imbalance: a fraction of a layer of cells, at most half of one a cut. */
static const struct {
  const char *scene;
  PetscReal   most;
} shapes[] = {
  {bar, 1.1},
  {angle, 1.1},
  {block, 1.2},
  /* bodies along the diagonal: no product of cuts per axis shares them out */
  {"-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 40,40 -mpm_grid_cells 40,40 -mpm_body_b_region polygon "
   "-mpm_body_b_vertices 1,1,4,1,39,36,39,39,36,39,1,4 -mpm_shape linear -mpm_time_step 1 ",
   1.1},
  {"-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 40,40 -mpm_grid_cells 40,40 -mpm_body_b_region polygon "
   "-mpm_body_b_vertices 1,1,39,1,1,39 -mpm_shape linear -mpm_time_step 1 ",
   1.1},
  {"-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 30,12,12 -mpm_grid_cells 30,12,12 -mpm_body_b_region cylinder "
   "-mpm_body_b_point 0,0,0 -mpm_body_b_axis 3,1,1 -mpm_body_b_radius 3 -mpm_shape linear -mpm_time_step 1 ",
   1.1},
};

/* The material is shared out: no rank holds much more than its part of a body that can be cut. */
START_TEST(balance)
{
  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(shapes); s++) {
    MpmModel  model;
    PetscInt  count;
    PetscReal share;

    SCENE_CALL(Create(PETSC_COMM_WORLD, shapes[s].scene, "", &model));
    SCENE_CALL(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
    share = (PetscReal)count * (PetscReal)rank_count / (PetscReal)model->state.particles->total;
    SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, &share, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
    ck_assert_msg(share <= shapes[s].most, "scene %d: a rank holds %g times its part", (int)s, (double)share);
    ck_assert_msg(PetscAbsReal(share - model->state.particles->imbalance) < 1e-12, "scene %d: %g is reported", (int)s,
                  (double)model->state.particles->imbalance);
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* ---- migration ---- */

#define POINTS 500
#define STATES 5
#define RATES  2

static const char *const extra_fields[] = {"load_a", "track_b"};

/* Every value of a point can be told from its id. */
static PetscReal Mark(PetscInt id, PetscInt field, PetscInt component)
{
  return SceneRandom(100 + field, id, component);
}

typedef struct {
  PetscReal *values;
  PetscInt   components;
} Column;

/* All real fields but the position. */
static void ListColumns(const MpmParticles *particles, const MpmPoints *points, PetscReal *const extra[],
                        Column columns[])
{
  const PetscInt dim = particles->dim;

  columns[0] = (Column){points->x0, dim};
  columns[1] = (Column){points->F, dim * dim};
  columns[2] = (Column){points->domain.half_length, dim};
  columns[3] = (Column){points->volume0, 1};
  columns[4] = (Column){points->stress, particles->stress_size};
  columns[5] = (Column){points->state, STATES};
  columns[6] = (Column){points->physics.value, RATES};
  columns[7] = (Column){extra[0], 1};
  columns[8] = (Column){extra[1], 1};
}
#define COLUMNS 9

typedef enum { WRITE, COMPARE, PLACE_ANYWHERE, PLACE_MIRRORED, PLACE_TOGETHER } Task;

/* Goes through all points of this rank: writes or compares their marks, or places them. `wrong` counts differences. */
static PetscErrorCode Visit(MpmParticles *particles, const MpmGrid *grid, Task task, PetscInt seed, PetscInt *wrong)
{
  const PetscInt dim = grid->dim;
  MpmPoints      points;
  PetscReal     *extra[2];
  Column         columns[COLUMNS];

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt e = 0; e < 2; e++) PetscCall(MpmParticlesGetField(particles, extra_fields[e], &extra[e]));
  ListColumns(particles, &points, extra, columns);
  *wrong = 0;
  for (PetscInt p = 0; p < points.count; p++) {
    if (task == COMPARE) *wrong += points.material[p] != points.id[p] % 3;
    for (PetscInt f = 0; f < COLUMNS && task <= COMPARE; f++) {
      for (PetscInt c = 0; c < columns[f].components; c++) {
        PetscReal *value = &columns[f].values[p * columns[f].components + c];

        if (task == WRITE) *value = Mark(points.id[p], f, c);
        else *wrong += *value != Mark(points.id[p], f, c);
      }
    }
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal middle = 0.5 * (grid->lower[a] + grid->upper[a]), half = grid->upper[a] - middle;
      PetscReal      *x = &points.x[p * dim + a];

      if (task == PLACE_ANYWHERE) *x = middle + half * SceneRandom(seed, points.id[p], a);
      if (task == PLACE_MIRRORED) *x = 2. * middle - *x;
      if (task == PLACE_TOGETHER) *x = grid->lower[a] + 0.3 * grid->h[a];
    }
  }
  for (PetscInt e = 0; e < 2; e++) PetscCall(MpmParticlesRestoreField(particles, &extra[e]));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points of all fields, distributed over the ranks in turn. */
static PetscErrorCode Deal(MpmGrid *grid, MpmParticles *particles)
{
  PetscInt  count = 0, unused;
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesCreate(
    grid,
    &(MpmParticleFields){
      .state_size = STATES, .rates = RATES, .half_length = PETSC_TRUE, .extra_count = 2, .extra = extra_fields},
    particles));
  for (PetscInt id = grid->rank; id < POINTS; id += grid->size) count++;
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, count, 0));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < count; p++) {
    points.id[p]       = grid->rank + p * grid->size;
    points.material[p] = points.id[p] % 3;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  particles->total = POINTS;
  PetscCall(Visit(particles, grid, WRITE, 0, &unused));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After a migration: every point is where it belongs, whole, and there once. */
static void CheckArrived(MpmParticles *particles, const MpmGrid *grid, const char *when)
{
  PetscInt  misplaced = 0, wrong = 0, id_sum = 0, total = 0;
  MpmPoints points;

  SCENE_CALL(CountMisplaced(particles, grid, &misplaced));
  SCENE_CALL(Visit(particles, grid, COMPARE, 0, &wrong));
  SCENE_CALL(DMSwarmGetSize(particles->swarm, &total));
  SCENE_CALL(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++) id_sum += points.id[p] * points.id[p];
  SCENE_CALL(MpmParticlesRestoreArrays(particles, &points));
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, &id_sum, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  ck_assert_msg(SceneAll((PetscBool)(misplaced == 0)), "%s: points on the wrong rank", when);
  ck_assert_msg(SceneAll((PetscBool)(wrong == 0)), "%s: points have lost values", when);
  ck_assert_int_eq((int)total, POINTS);
  ck_assert_int_eq((int)id_sum, (POINTS - 1) * POINTS * (2 * POINTS - 1) / 6);
}

START_TEST(migration)
{
  const char *const scenes[] = {bar, angle, block};

  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(scenes); s++) {
    MpmModel     model;
    MpmGrid     *grid;
    MpmParticles particles = {0};
    PetscInt     unused;

    SCENE_CALL(Create(PETSC_COMM_WORLD, scenes[s], "", &model));
    grid = model->disc.grid;
    SCENE_CALL(Deal(grid, &particles));
    SCENE_CALL(Visit(&particles, grid, PLACE_ANYWHERE, 1, &unused));
    SCENE_CALL(MpmParticlesMigrate(&particles, grid));
    CheckArrived(&particles, grid, "from everywhere to everywhere");
    SCENE_CALL(MpmParticlesMigrate(&particles, grid));
    CheckArrived(&particles, grid, "nobody moves");
    SCENE_CALL(Visit(&particles, grid, PLACE_MIRRORED, 0, &unused));
    SCENE_CALL(MpmParticlesMigrate(&particles, grid));
    CheckArrived(&particles, grid, "from end to end");
    SCENE_CALL(Visit(&particles, grid, PLACE_TOGETHER, 0, &unused));
    SCENE_CALL(MpmParticlesMigrate(&particles, grid));
    CheckArrived(&particles, grid, "into one cell");
    SCENE_CALL(Visit(&particles, grid, PLACE_ANYWHERE, 2, &unused));
    SCENE_CALL(MpmParticlesMigrate(&particles, grid));
    CheckArrived(&particles, grid, "out of one cell");
    SCENE_CALL(MpmParticlesDestroy(&particles));
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* A thousand times to random places, with and without a new partition: nothing is lost, nothing changes. */
START_TEST(thousand_migrations)
{
  MpmModel     model;
  MpmParticles particles = {0};
  PetscInt     unused;
  PetscBool    moved;

  SCENE_CALL(Create(PETSC_COMM_WORLD, block, "", &model));
  SCENE_CALL(Deal(model->disc.grid, &particles));
  for (PetscInt k = 0; k < 1000; k++) {
    SCENE_CALL(Visit(&particles, model->disc.grid, k % 100 == 99 ? PLACE_TOGETHER : PLACE_ANYWHERE, 1000 + k, &unused));
    SCENE_CALL(MpmParticlesMigrate(&particles, model->disc.grid));
    if (k % 10 == 9) {
      SCENE_CALL(MpmParticlesRebalance(&particles, model->disc.grid, PETSC_TRUE, &moved));
      SCENE_CALL(MpmParticlesMigrate(&particles, model->disc.grid));
    }
    ck_assert_str_eq(particles.lost, "");
    CheckArrived(&particles, model->disc.grid, "one of a thousand");
  }
  SCENE_CALL(MpmParticlesDestroy(&particles));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

typedef enum { NOWHERE, BEYOND, REMOVED, TWICE } Mishap;

/* Something happens to the point of this id, wherever it is. */
static PetscErrorCode Befall(MpmParticles *particles, const MpmGrid *grid, PetscInt id, Mishap mishap)
{
  MpmPoints points;
  PetscInt  at = -1;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++)
    if (points.id[p] == id) at = p;
  if (at >= 0 && mishap == NOWHERE) points.x[at * grid->dim] = (PetscReal)NAN;
  if (at >= 0 && mishap == BEYOND) points.x[at * grid->dim + 1] = grid->upper[1] + 2.;
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MpmParticlesRelease(particles));
  if (at >= 0 && mishap == REMOVED) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, at));
  if (at >= 0 && mishap == TWICE) {
    PetscInt count;

    PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
    PetscCall(DMSwarmAddPoint(particles->swarm));
    PetscCall(DMSwarmCopyPoint(particles->swarm, at, count));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points that are lost are told by id and, where it is known, by place, on every rank. */
START_TEST(lost_points)
{
  static const struct {
    Mishap      mishap;
    const char *text;
  } cases[] = {
    {NOWHERE, "point 123 is not in the grid but at (nan, 1, 1)"},
    {BEYOND, "point 123 is not in the grid but at (1, 5, 1)"},
    {REMOVED, "point 123 is missing; where it was is not known"},
    {TWICE, "point 123 is there twice; where it was is not known"},
  };

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(cases); k++) {
    MpmModel     model;
    MpmParticles particles = {0};
    MpmPoints    points;
    MpmOutcome   outcome;

    SCENE_CALL(Create(PETSC_COMM_WORLD, block, "", &model));
    SCENE_CALL(Deal(model->disc.grid, &particles));
    SCENE_CALL(MpmParticlesGetArrays(&particles, &points));
    for (PetscInt p = 0; p < 3 * points.count; p++) points.x[p] = 1.;
    SCENE_CALL(MpmParticlesRestoreArrays(&particles, &points));
    SCENE_CALL(Befall(&particles, model->disc.grid, 123, cases[k].mishap));
    SCENE_CALL(MpmParticlesDistribute(&particles, model->disc.grid, &outcome));
    ck_assert(outcome.code == MPM_OUTCOME_OUTSIDE);
    ck_assert_str_eq(outcome.text, cases[k].text);
    ck_assert_int_eq((int)particles.gone, cases[k].mishap == REMOVED || cases[k].mishap == TWICE);
    SCENE_CALL(MpmParticlesDestroy(&particles));
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* In the bar the ranks stand in a row: mirroring takes points from the first to the last, over those between. */
START_TEST(far_migration)
{
  MpmModel  model;
  MpmPoints points;
  PetscInt  far = 0, misplaced;

  SCENE_CALL(Create(PETSC_COMM_WORLD, bar, "", &model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    points.x[2 * p] = 6. - points.x[2 * p];
    MpmGridFindCell(model->disc.grid, &points.x[2 * p], cell);
    far = PetscMax(far, PetscAbsInt(MpmGridNodeOwner(model->disc.grid, cell) - my_rank));
  }
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, &far, 1, MPIU_INT, MPI_MAX, PETSC_COMM_WORLD));
  ck_assert_int_eq((int)far, (int)rank_count - 1);
  SCENE_CALL(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  SCENE_CALL(CountMisplaced(model->state.particles, model->disc.grid, &misplaced));
  ck_assert(SceneAll((PetscBool)(misplaced == 0)));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* On one rank nothing is looked at, let alone sent: the ranks that the points were marked for stay what they were. */
START_TEST(one_rank_stays)
{
  MpmModel  model;
  MpmPoints points;
  PetscInt *target, touched = 0;

  SCENE_CALL(Create(PETSC_COMM_SELF, bar, "", &model));
  for (PetscInt pass = 0; pass < 2; pass++) {
    SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
    SCENE_CALL(DMSwarmGetField(model->state.particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&target));
    ck_assert_int_eq((int)points.count, (int)model->state.particles->total);
    for (PetscInt p = 0; p < points.count; p++) {
      if (pass) touched += target[p] != 77 || points.id[p] != p;
      target[p]       = 77;
      points.x[2 * p] = 6. - points.x[2 * p];
    }
    SCENE_CALL(DMSwarmRestoreField(model->state.particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&target));
    SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
    if (!pass) SCENE_CALL(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  }
  ck_assert(SceneAll((PetscBool)(touched == 0)));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

static PetscBool HasField(const MpmModel model, const char *name)
{
  return MpmParticlesHaveField(model->state.particles, name);
}

/* Only what the scene uses is stored with the points and travels with them. */
START_TEST(fields_in_use)
{
  static const char *const spare[] = {"half_length", "state", "value", "load_f", "load_g", "track_t"};
  const char *const        more =
    "-mpm_loads f,g -mpm_load_f_type force -mpm_load_f_value 1,0 -mpm_load_f_at 6,0.5 -mpm_load_g_type gravity "
    "-mpm_load_g_value 0,-1 -mpm_tracks t -mpm_track_t_at 0,0";
  MpmModel model;

  SCENE_CALL(Create(PETSC_COMM_WORLD, crumb, "", &model));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(spare); k++)
    ck_assert_msg(!HasField(model, spare[k]), "a field %s", spare[k]);
  ck_assert(HasField(model, "position") && HasField(model, "F") && HasField(model, "stress"));
  SCENE_CALL(SceneDestroy(&model));
  SCENE_CALL(Create(PETSC_COMM_WORLD, bar, more, &model));
  ck_assert(HasField(model, "half_length") && HasField(model, "load_f") && HasField(model, "track_t"));
  ck_assert(!HasField(model, "state") && !HasField(model, "value") && !HasField(model, "load_g"));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* Fields may be lent several times; while one is, no point comes or goes. */
START_TEST(lent_fields)
{
  MpmModel      model;
  MpmParticles *particles;
  MpmPoints     one, other;
  PetscReal    *x;

  SCENE_CALL(Create(PETSC_COMM_WORLD, bar, "", &model));
  particles = model->state.particles;
  SCENE_CALL(MpmParticlesGetArrays(particles, &one));
  SCENE_CALL(MpmParticlesGetArrays(particles, &other));
  SCENE_CALL(MpmParticlesGetField(particles, "position", &x));
  ck_assert(one.x == x && other.x == x && one.count == other.count);
  SCENE_CALL(MpmParticlesRestoreArrays(particles, &one));
  SCENE_CALL(MpmParticlesRestoreArrays(particles, &one));
  UNIT_FAILS(MpmParticlesRelease(particles), PETSC_ERR_ORDER, "the points' fields are lent 2 times");
  UNIT_FAILS(MpmParticlesRemoveAt(particles, 0, NULL), PETSC_ERR_ORDER, "the points' fields are lent 2 times");
  SCENE_CALL(MpmParticlesRestoreArrays(particles, &other));
  SCENE_CALL(MpmParticlesRestoreField(particles, &x));
  UNIT_FAILS(MpmParticlesGetField(particles, "nothing", &x), PETSC_ERR_ARG_OUTOFRANGE,
             "the points have no field nothing");
  SCENE_CALL(MpmParticlesRelease(particles));
  SCENE_CALL(MpmParticlesGetArrays(particles, &one));
  ck_assert(one.lent && one.x && !one.domain.faces);
  SCENE_CALL(MpmParticlesRestoreArrays(particles, &one));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* ---- node numbers ---- */

static PetscInt Key(const MpmGrid *grid, const MpmSpace *space, PetscInt i)
{
  const PetscInt *node = &space->node[i * grid->dim];

  return node[0] + grid->nodes[0] * (node[1] + grid->nodes[1] * (grid->dim > 2 ? node[2] : 0));
}

/* The places of all active nodes, by number, on every rank. */
static PetscErrorCode GatherKeys(MpmModel model, PetscInt **keys)
{
  const MpmSpace *space = model->disc.space;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->number.count, keys));
  for (PetscInt k = 0; k < space->number.count; k++) (*keys)[k] = -1;
  for (PetscInt i = 0; i < space->owned; i++) (*keys)[space->number.global[i]] = Key(model->disc.grid, space, i);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, *keys, (PetscMPIInt)space->number.count, MPIU_INT, MPI_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void CheckNumbers(MpmModel model, PetscInt *keys)
{
  const MpmSpace *space = model->disc.space;
  PetscBool       fine  = PETSC_TRUE, duplicates;
  PetscInt        total = space->owned;

  for (PetscInt i = 0; i < space->local; i++) {
    if (keys[space->number.global[i]] != Key(model->disc.grid, space, i)) fine = PETSC_FALSE;
    if (i < space->owned && space->number.global[i] != space->number.begin + i) fine = PETSC_FALSE;
    if ((MpmGridNodeOwner(model->disc.grid,
                          (const PetscInt[]){space->node[i * model->disc.dim], space->node[i * model->disc.dim + 1],
                                             model->disc.dim > 2 ? space->node[i * model->disc.dim + 2] : 0}) ==
         my_rank) != (i < space->owned))
      fine = PETSC_FALSE;
  }
  ck_assert_msg(SceneAll(fine), "ghosts and owners number a node differently");
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  ck_assert_int_eq((int)total, (int)space->number.count);
  SCENE_CALL(PetscSortInt(space->number.count, keys));
  SCENE_CALL(PetscSortedCheckDupsInt(space->number.count, keys, &duplicates));
  ck_assert_int_ge((int)keys[0], 0);
  ck_assert_msg(!duplicates, "a node has two numbers");
}

#define VALUES 3

/* Values go from owners to ghosts, and sums from ghosts to owners. */
static void CheckScatter(MpmModel model)
{
  const MpmSpace *space = model->disc.space;
  PetscReal      *local, *sums, far = 0.;
  const PetscInt  size = space->number.count * VALUES;

  SCENE_CALL(PetscMalloc2((space->local * VALUES), &local, size, &sums));
  for (PetscInt k = 0; k < space->local * VALUES; k++) {
    local[k] = k < space->owned * VALUES ? SceneRandom(7, Key(model->disc.grid, space, k / VALUES), k % VALUES) : 1e30;
  }
  SCENE_CALL(MpmSpaceToGhosts(space, VALUES, local));
  for (PetscInt k = 0; k < space->local * VALUES; k++) {
    far = PetscMax(far, PetscAbsReal(local[k] - SceneRandom(7, Key(model->disc.grid, space, k / VALUES), k % VALUES)));
  }
  ck_assert_msg(SceneAll((PetscBool)(far == 0.)), "a ghost does not have its owner's values");
  for (PetscInt k = 0; k < size; k++) sums[k] = 0.;
  for (PetscInt k = 0; k < space->local * VALUES; k++) {
    local[k] = (PetscReal)(1 + my_rank) * SceneRandom(8, Key(model->disc.grid, space, k / VALUES), k % VALUES);
    sums[space->number.global[k / VALUES] * VALUES + k % VALUES] += local[k];
  }
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, sums, (PetscMPIInt)size, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD));
  SCENE_CALL(MpmSpaceAddToOwners(space, VALUES, local));
  for (PetscInt k = 0; k < space->owned * VALUES; k++) {
    far = PetscMax(far, PetscAbsReal(local[k] - sums[space->number.global[k / VALUES] * VALUES + k % VALUES]));
  }
  ck_assert_msg(SceneAll((PetscBool)(far <= 1e-14)), "an owner misses %g of a sum", (double)far);
  SCENE_CALL(PetscFree2(local, sums));
}

START_TEST(numbering)
{
  const char *const scenes[] = {bar, angle, block, crumb};

  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(scenes); s++) {
    MpmModel  model, alone;
    PetscInt *keys, *keys_alone;
    PetscBool same;

    SCENE_CALL(Create(PETSC_COMM_WORLD, scenes[s], "", &model));
    SCENE_CALL(SceneBegin(model, 0.25));
    SCENE_CALL(GatherKeys(model, &keys));
    CheckNumbers(model, keys);
    CheckScatter(model);
    SCENE_CALL(Create(PETSC_COMM_SELF, scenes[s], "", &alone));
    SCENE_CALL(SceneBegin(alone, 0.25));
    SCENE_CALL(GatherKeys(alone, &keys_alone));
    SCENE_CALL(PetscSortInt(alone->disc.space->number.count, keys_alone));
    ck_assert_int_eq((int)model->disc.space->number.count, (int)alone->disc.space->number.count);
    SCENE_CALL(PetscArraycmp(keys, keys_alone, model->disc.space->number.count, &same));
    ck_assert_msg(SceneAll(same), "other nodes are active than on one rank");
    SCENE_CALL(PetscFree(keys));
    SCENE_CALL(PetscFree(keys_alone));
    SCENE_CALL(MpmModelDestroy(&alone));
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* ---- results ---- */

/* The run on these ranks against the same on one, point by point. */
static void CheckSame(MpmModel model, MpmModel alone, const char *name)
{
  const PetscInt dim   = model->disc.dim;
  PetscReal      moved = 0., stress = 0., largest = 0.;
  MpmPoints      points;

  SCENE_CALL(SceneFieldDifference(alone, model, dim, "position", "position0", &moved));
  SCENE_CALL(SceneFieldDifference(alone, model, alone->state.particles->stress_size, "stress", NULL, &stress));
  ck_assert_msg(SceneAll((PetscBool)(moved <= 1e-9)), "%s: displacements differ by %g", name, (double)moved);
  ck_assert_msg(SceneAll((PetscBool)(stress <= 1e-8)), "%s: stresses differ by %g", name, (double)stress);
  ck_assert_int_eq((int)model->solver.iterations.newton_total, (int)alone->solver.iterations.newton_total);
  ck_assert_int_eq((int)model->state.active_dofs_max, (int)alone->state.active_dofs_max);
  for (PetscInt k = 0; k < alone->scene.bcs->count * dim; k++)
    largest = PetscMax(largest, PetscAbsReal(alone->disc.nodal.reaction[k]));
  for (PetscInt k = 0; k < alone->scene.bcs->count * dim; k++)
    ck_assert_double_eq_tol(model->disc.nodal.reaction[k], alone->disc.nodal.reaction[k], 1e-8 * largest);
  SCENE_CALL(MpmParticlesGetArrays(alone->state.particles, &points));
  for (PetscInt k = 0; k < points.count * dim; k++) moved = PetscMax(moved, PetscAbsReal(points.x[k] - points.x0[k]));
  SCENE_CALL(MpmParticlesRestoreArrays(alone->state.particles, &points));
  ck_assert_msg(moved > 0.02 * model->disc.h[0], "%s: nothing has moved", name);
}

/* How many points changed rank during the run. */
static PetscErrorCode CountTravellers(MpmModel model, PetscInt id_count, PetscBool before[], PetscInt *travellers)
{
  PetscInt *id, count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, "id", &id));
  if (!travellers) PetscCall(PetscArrayzero(before, id_count));
  else *travellers = 0;
  for (PetscInt p = 0; p < count; p++) {
    if (!travellers) before[id[p]] = PETSC_TRUE;
    else *travellers += !before[id[p]];
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &id));
  if (travellers) PetscCall(MPIU_Allreduce(MPI_IN_PLACE, travellers, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void RunBoth(const char *name, const char *scene, const char *more, PetscBool travels)
{
  MpmModel   model, alone;
  PetscBool *here;
  PetscInt   travellers;

  SCENE_CALL(Create(PETSC_COMM_WORLD, scene, more, &model));
  SCENE_CALL(PetscMalloc1(model->state.particles->total, &here));
  SCENE_CALL(CountTravellers(model, (PetscInt)model->state.particles->total, here, NULL));
  SCENE_CALL(SceneRun(model));
  SCENE_CALL(CountTravellers(model, (PetscInt)model->state.particles->total, here, &travellers));
  SCENE_CALL(Create(PETSC_COMM_SELF, scene, more, &alone));
  SCENE_CALL(SceneRun(alone));
  CheckSame(model, alone, name);
  if (travels && rank_count > 1) ck_assert_msg(travellers > 0, "%s: no point changed its rank", name);
  SCENE_CALL(PetscFree(here));
  SCENE_CALL(MpmModelDestroy(&alone));
  SCENE_CALL(SceneDestroy(&model));
}

/* A bar that stands on its long side, under its weight, and is pushed along. */
START_TEST(results_bar)
{
  RunBoth("bar", bar,
          "-mpm_bcs floor -mpm_bc_floor_region box -mpm_bc_floor_lower -10,0 -mpm_bc_floor_upper 20,0 "
          "-mpm_bc_floor_components x,y "
          "-mpm_loads w,f -mpm_load_w_type gravity -mpm_load_w_value -40,-40 -mpm_load_f_type force -mpm_load_f_value "
          "-2e3,-1e3 "
          "-mpm_load_f_at 4,0.5 -mpm_load_f_nearest 4 -mpm_shape bspline2",
          PETSC_FALSE);
}
END_TEST

/* The whole bar is carried over half its length while it settles: points cross three cells a step, and the ranks. */
START_TEST(results_moving)
{
  RunBoth("moving", bar,
          "-mpm_bcs carried,floor -mpm_bc_carried_region all -mpm_bc_carried_components x -mpm_bc_carried_value 3 "
          "-mpm_bc_carried_ramp 0:0,1:1 "
          "-mpm_bc_floor_region box -mpm_bc_floor_lower -10,0 -mpm_bc_floor_upper 20,0 -mpm_bc_floor_components y "
          "-mpm_loads w "
          "-mpm_load_w_type gravity -mpm_load_w_value 0,-40",
          PETSC_TRUE);
}
END_TEST

START_TEST(results_angle)
{
  RunBoth("angle", angle,
          "-mpm_material_m_type j2 -mpm_material_m_yield_stress 1.5e4 -mpm_material_m_hardening 3e5 -mpm_bcs floor "
          "-mpm_bc_floor_region box "
          "-mpm_bc_floor_lower 0,1 -mpm_bc_floor_upper 8,1 -mpm_bc_floor_components x,y -mpm_loads w,t "
          "-mpm_load_w_type gravity "
          "-mpm_load_w_value 0.5,-3 -mpm_load_t_type traction -mpm_load_t_value 0,-5e3 -mpm_load_t_region box "
          "-mpm_load_t_lower 1,7 "
          "-mpm_load_t_upper 3,7",
          PETSC_FALSE);
}
END_TEST

START_TEST(results_block)
{
  RunBoth("block", block,
          "-mpm_bcs floor -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0,0 -mpm_bc_floor_upper 4,3,0 "
          "-mpm_bc_floor_components x,y,z "
          "-mpm_loads w -mpm_load_w_type gravity -mpm_load_w_value 2,0.5,-10 -mpm_shape linear",
          PETSC_FALSE);
}
END_TEST

/* A scene so small that all but one rank are without points: a whole run, files included. */
START_TEST(empty_ranks)
{
  char                     directory[64] = "/tmp/talus_XXXXXX", more[1000], path[200];
  MpmModel                 model, alone;
  PetscInt                 count, busy;
  int                      status  = -1;
  static const char *const files[] = {".h5", ".xdmf", ".vtkhdf", "_history.csv", "_options.yaml", "_summary.json"};

  if (!my_rank) ck_assert_ptr_nonnull(mkdtemp(directory));
  SCENE_CALL(MPI_Bcast(directory, sizeof(directory), MPI_CHAR, 0, PETSC_COMM_WORLD));
  snprintf(more, sizeof(more),
           "-mpm_bcs floor -mpm_bc_floor_region box -mpm_bc_floor_lower 0,4 -mpm_bc_floor_upper 8,4 "
           "-mpm_bc_floor_components x,y -mpm_loads w "
           "-mpm_load_w_type gravity -mpm_load_w_value 100,-300 -mpm_tracks t -mpm_track_t_at 4.5,4.5 -mpm_quiet "
           "-mpm_output_prefix %s/crumb",
           directory);
  SCENE_CALL(Create(PETSC_COMM_WORLD, crumb, more, &model));
  SCENE_CALL(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  busy = count > 0;
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, &busy, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  ck_assert_int_eq((int)busy, 1);
  SCENE_CALL(MpmModelRun(model, &status));
  ck_assert_int_eq(status, 0);
  ck_assert_int_eq((int)model->state.step, 2);
  SCENE_CALL(Create(PETSC_COMM_SELF, crumb, more, &alone));
  SCENE_CALL(SceneRun(alone));
  CheckSame(model, alone, "crumb");
  SCENE_CALL(MpmModelDestroy(&alone));
  SCENE_CALL(SceneDestroy(&model));
  for (size_t k = 0; !my_rank && k < PETSC_STATIC_ARRAY_LENGTH(files); k++) {
    snprintf(path, sizeof(path), "%s/crumb%s", directory, files[k]);
    ck_assert_msg(unlink(path) == 0, "the run has not written %s", path);
  }
  if (!my_rank) ck_assert_msg(rmdir(directory) == 0, "the run has left other files in %s", directory);
}
END_TEST

START_TEST(who_am_i)
{
  SCENE_CALL(MPI_Comm_rank(PETSC_COMM_WORLD, &my_rank));
  SCENE_CALL(MPI_Comm_size(PETSC_COMM_WORLD, &rank_count));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {who_am_i,    ownership,     balance,        migration,     thousand_migrations,
                                lost_points, far_migration, one_rank_stays, fields_in_use, lent_fields,
                                numbering,   results_bar,   results_moving, results_angle, results_block,
                                empty_ranks};

  return UnitRun(&argc, &argv, "parallel", sizeof(tests) / sizeof(tests[0]), tests);
}
