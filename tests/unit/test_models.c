/*
  Models side by side in one process: each is as it is alone, options, presets and all, and leaves nothing behind.

  Ranks: 1 2
*/
#include "talus/talus.h"
#include "unit.h"

#include <stdio.h>
#include <unistd.h>

#define CALL(call) PetscCallAbort(PETSC_COMM_WORLD, call)

/* A block on a floor, pressed down and to the side. */
#define BLOCK_2D \
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 6,4 -mpm_grid_cells 12,8 -mpm_bodies b -mpm_body_b_material m " \
  "-mpm_body_b_region box -mpm_body_b_lower 1,0 -mpm_body_b_upper 5,3 -mpm_materials m -mpm_material_m_E 1e6 " \
  "-mpm_material_m_nu 0.3 -mpm_material_m_density 1000 -mpm_bcs floor -mpm_bc_floor_region box " \
  "-mpm_bc_floor_lower 0,0 -mpm_bc_floor_upper 6,0 -mpm_bc_floor_components x,y -mpm_loads push " \
  "-mpm_load_push_type traction -mpm_load_push_region box -mpm_load_push_lower 2,3 -mpm_load_push_upper 4,3 " \
  "-mpm_load_push_value 2e3,-2e4 -mpm_time_step 0.2 "
#define BLOCK_3D \
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 4,4,4 -mpm_grid_cells 4,4,4 -mpm_bodies b -mpm_body_b_material m " \
  "-mpm_body_b_region box -mpm_body_b_lower 1,1,0 -mpm_body_b_upper 3,3,3 -mpm_materials m -mpm_material_m_E 1e6 " \
  "-mpm_material_m_nu 0.3 -mpm_material_m_density 1000 -mpm_bcs floor -mpm_bc_floor_region box " \
  "-mpm_bc_floor_lower 0,0,0 -mpm_bc_floor_upper 4,4,0 -mpm_bc_floor_components x,y,z -mpm_loads push " \
  "-mpm_load_push_type gravity -mpm_load_push_value 1,0,-10 -mpm_time_step 0.2 "

static const char *const scenes[] = {
  BLOCK_2D "-mpm_material_m_type hencky",
  BLOCK_2D "-mpm_material_m_type drucker_prager -mpm_material_m_cohesion 4e3 -mpm_material_m_friction 30 "
           "-mpm_material_m_dilation 10",
  BLOCK_3D "-mpm_material_m_type neo_hookean -mpm_solver amg -mpm_shape linear",
  BLOCK_2D "-mpm_material_m_type j2 -mpm_material_m_yield_stress 1e4 -mpm_material_m_hardening 1e5 -mpm_solver direct "
           "-snes_rtol 1e-6 -ksp_type gmres -pc_type lu -mpm_jacobian coloring",
};
#define SCENES ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(scenes))
#define STEPS  5

/*
  On several ranks MUMPS adds in the order in which messages come: even one model alone is not reproducible. All direct
  solutions are therefore made on each rank there.
*/
static PetscErrorCode Create(PetscInt scene, MpmModel *model)
{
  char        options[2048];
  PetscMPIInt ranks;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(PetscSNPrintf(options, sizeof(options), "%s%s", scenes[scene],
                          ranks > 1 && !strstr(scenes[scene], "amg") ? " -pc_type redundant" : ""));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, model));
  PetscCall(MpmModelSetOptions(*model, options));
  PetscCall(MpmModelSetFromOptions(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Positions and stresses of this rank's points. */
typedef struct {
  PetscInt   count;
  PetscReal *values;
} Outcome;

static PetscErrorCode Append(MpmModel model, const char *field, PetscInt points, Outcome *outcome)
{
  PetscInt   components;
  PetscReal *array;

  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPoints(model, field, &components, &array));
  PetscCall(PetscRealloc((size_t)(outcome->count + points * components) * sizeof(PetscReal), &outcome->values));
  PetscCall(PetscArraycpy(outcome->values + outcome->count, array, points * components));
  outcome->count += points * components;
  PetscCall(MpmModelRestorePoints(model, field, NULL, &array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Look(MpmModel model, Outcome *outcome)
{
  PetscInt points;

  PetscFunctionBeginUser;
  *outcome = (Outcome){0, NULL};
  PetscCall(PetscMalloc1(1, &outcome->values));
  PetscCall(MpmModelGetPointCount(model, &points, NULL));
  PetscCall(Append(model, "position", points, outcome));
  PetscCall(Append(model, "stress", points, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* To the last bit. */
static PetscBool IsSame(const Outcome *a, const Outcome *b)
{
  PetscBool same = (PetscBool)(a->count == b->count);

  for (PetscInt k = 0; same && k < a->count; k++) same = (PetscBool)(a->values[k] == b->values[k]);
  return same;
}

/* The scene alone in the process; what it leaves in the database in force would be seen by the next. */
static PetscErrorCode RunAlone(PetscInt scene, Outcome *outcome)
{
  MpmModel  model;
  MpmStatus status = MPM_RUNNING;

  PetscFunctionBeginUser;
  PetscCall(Create(scene, &model));
  while (status == MPM_RUNNING) PetscCall(MpmModelStep(model, &status));
  PetscCheck(status == MPM_COMPLETED, PETSC_COMM_SELF, PETSC_ERR_NOT_CONVERGED, "scene %" PetscInt_FMT " gave up",
             scene);
  PetscCall(Look(model, outcome));
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All of them in turn, step by step. */
START_TEST(interleaved)
{
  MpmModel model[SCENES];
  Outcome  alone[SCENES], together;
  char    *left;

  for (PetscInt s = 0; s < SCENES; s++) CALL(RunAlone(s, &alone[s]));
  for (PetscInt s = 0; s < SCENES; s++) CALL(Create(s, &model[s]));
  for (PetscInt k = 0; k < STEPS; k++) {
    for (PetscInt s = 0; s < SCENES; s++) {
      MpmStatus status;

      CALL(MpmModelStep(model[s], &status));
      ck_assert_msg(status == (k + 1 < STEPS ? MPM_RUNNING : MPM_COMPLETED), "scene %d, step %d: status %d", (int)s,
                    (int)k, (int)status);
    }
  }
  for (PetscInt s = 0; s < SCENES; s++) {
    CALL(Look(model[s], &together));
    ck_assert_int_eq((int)together.count, (int)alone[s].count);
    ck_assert_msg(IsSame(&together, &alone[s]), "scene %d is not what it is alone", (int)s);
    CALL(PetscFree(together.values));
    CALL(PetscFree(alone[s].values));
    CALL(MpmModelDestroy(&model[s]));
  }
  CALL(PetscOptionsGetAll(NULL, &left));
  ck_assert_msg(!strstr(left, "pc_type") && !strstr(left, "mumps"), "a preset has reached the database in force: %s",
                left);
  CALL(PetscFree(left));
}
END_TEST

/* Options of the database in force: copied, with a prefix or without, and marked where they were used. */
START_TEST(databases)
{
  MpmModel    plain, left;
  MpmStatus   status;
  PetscBool   used;
  PetscInt    step;
  const char *why;

  CALL(PetscOptionsInsertString(NULL, BLOCK_2D "-mpm_material_m_type hencky -snes_max_it 20 -nobody_asks 1"));
  CALL(PetscOptionsInsertString(NULL, "-prefix_push left_ " BLOCK_2D "-mpm_material_m_type hencky -snes_max_it 1 "
                                      "-mpm_time_step_min 0.2 -prefix_pop"));
  CALL(MpmModelCreate(PETSC_COMM_WORLD, &left));
  CALL(MpmModelSetOptionsPrefix(left, "left_"));
  CALL(MpmModelSetFromOptions(left));
  CALL(MpmModelCreate(PETSC_COMM_WORLD, &plain));
  CALL(MpmModelSetFromOptions(plain));
  CALL(PetscOptionsUsed(NULL, "snes_max_it", &used));
  ck_assert(!used);
  CALL(MpmModelStep(plain, &status));
  ck_assert_int_eq(status, MPM_RUNNING);
  CALL(PetscOptionsUsed(NULL, "snes_max_it", &used));
  ck_assert_msg(used, "an option that the model has used counts as left over");
  CALL(PetscOptionsUsed(NULL, "left_snes_max_it", &used));
  ck_assert(!used);
  CALL(MpmModelStep(left, &status));
  ck_assert_int_eq(status, MPM_GAVE_UP); /* one iteration is not enough */
  CALL(MpmModelGetReason(left, &why));
  ck_assert_msg(strstr(why, "Newton reached its iteration limit, with ") == why &&
                  strstr(why, "; if there is a state of rest elsewhere, a stage of type relaxation may find it, or "
                              "-mpm_time_rescue relaxation in this one"),
                "%s", why);
  CALL(MpmModelGetTime(left, NULL, &step));
  ck_assert_int_eq((int)step, 0);
  CALL(PetscOptionsUsed(NULL, "left_snes_max_it", &used));
  ck_assert(used);
  CALL(PetscOptionsUsed(NULL, "nobody_asks", &used));
  ck_assert(!used);
  CALL(MpmModelDestroy(&plain));
  CALL(MpmModelDestroy(&left));
  CALL(PetscOptionsClear(NULL));
}
END_TEST

/* An error leaves the database that was in force before. */
START_TEST(errors)
{
  MpmModel    model;
  PetscInt    components;
  PetscReal  *array;
  const char *first = "-mpm_dim 2 -mpm_grid_lower 0,0";
  PetscBool   given;

  CALL(MpmModelCreate(PETSC_COMM_WORLD, &model));
  CALL(MpmModelSetOptions(model, first));
  UNIT_FAILS(MpmModelSetFromOptions(model), MPM_ERR_INPUT, "-mpm_grid_upper is missing: upper corner (m), 2 values");
  CALL(PetscOptionsHasName(NULL, NULL, "-mpm_dim", &given));
  ck_assert_msg(!given, "the failed model's options are still in force");
  UNIT_FAILS(MpmModelGetPoints(model, "stress", &components, &array), PETSC_ERR_ARG_WRONGSTATE,
             "MpmModelSetUp() comes first");
  UNIT_FAILS(MpmModelSetOptions(model, "-options_file no_such_file"), MPM_ERR_INPUT,
             "-options_file no_such_file: the file cannot be read");
  UNIT_FAILS(MpmModelSetOptions(model, "dim 2"), MPM_ERR_INPUT,
             "dim: the name of an option, with its dash, was expected");
  CALL(MpmModelDestroy(&model));
}
END_TEST

/* A stress point is stepped like a model; it has no grid and no points to lend, and says so. */
START_TEST(laboratory)
{
  MpmModel         model;
  MpmStatus        status;
  MpmJacobianCheck check;
  PetscInt         count;

  CALL(MpmModelCreate(PETSC_COMM_WORLD, &model));
  CALL(MpmModelSetOptions(model,
                          "-mpm_dim 3 -mpm_physics stress_point -mpm_materials m -mpm_material_m_type hencky "
                          "-mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 -mpm_point_material m "
                          "-mpm_point_path oedometer -mpm_point_end -0.1 -mpm_point_stress -1e3,-2e3,-1e3,0,0,0"));
  CALL(MpmModelSetFromOptions(model));
  UNIT_FAILS(MpmModelSetOptions(model, "-mpm_point_end 1"), PETSC_ERR_ARG_WRONGSTATE, "the scene has been read");
  CALL(MpmModelSetUp(model));
  CALL(MpmModelSetUp(model));
  CALL(MpmModelStep(model, &status));
  ck_assert_int_eq(status, MPM_RUNNING);
  UNIT_FAILS(MpmModelCheckJacobian(model, 0.01, &check), PETSC_ERR_SUP, "a stress point has no grid's Jacobian");
  UNIT_FAILS(MpmModelGetPointCount(model, &count, NULL), PETSC_ERR_SUP, "a stress point has no points of a grid");
  CALL(MpmModelDestroy(&model));
}
END_TEST

/* ---- hooks and loads ---- */

typedef struct {
  PetscInt       before, after, stop_after;
  PetscReal      factor, time;
  PetscErrorCode again; /* of stepping the model from within */
} Watch;

static PetscErrorCode Before(MpmModel model, void *ctx)
{
  Watch *watch = (Watch *)ctx;

  PetscFunctionBeginUser;
  watch->before++;
  PetscCall(MpmModelSetLoadFactor(model, "push", watch->factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode After(MpmModel model, void *ctx)
{
  Watch    *watch = (Watch *)ctx;
  MpmStatus status;
  UnitError error;

  PetscFunctionBeginUser;
  watch->after++;
  PetscCall(MpmModelGetTime(model, &watch->time, NULL));
  if (watch->after == watch->stop_after) PetscCall(MpmModelStop(model));
  UNIT_TRY(error, MpmModelStep(model, &status));
  watch->again = error.code;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The reaction is the load that a hook has set, whatever the ramp says. */
START_TEST(hooks)
{
  Watch     watch = {.stop_after = 2, .factor = 0.25};
  MpmModel  model;
  MpmStatus status;
  PetscReal reaction[2], value[2] = {0., -1e4};

  CALL(Create(0, &model));
  CALL(MpmModelSetBeforeStep(model, Before, &watch));
  CALL(MpmModelSetAfterStep(model, After, &watch));
  CALL(MpmModelStep(model, &status));
  ck_assert_int_eq(status, MPM_RUNNING);
  ck_assert_int_eq((int)watch.again, PETSC_ERR_ARG_WRONGSTATE);
  CALL(MpmModelGetReaction(model, "floor", reaction));
  ck_assert_double_eq_tol(reaction[0], -0.25 * 2e3 * 2., 1e-4); /* two metres of the top are loaded */
  ck_assert_double_eq_tol(reaction[1], 0.25 * 2e4 * 2., 1e-4);
  CALL(MpmModelSetLoadValue(model, "push", value));
  watch.factor = 1.;
  CALL(MpmModelStep(model, &status));
  ck_assert_int_eq(status, MPM_STOPPED);
  CALL(MpmModelGetReaction(model, "floor", reaction));
  ck_assert_double_eq_tol(reaction[0], 0., 1e-4);
  ck_assert_double_eq_tol(reaction[1], 2e4, 1e-4);
  ck_assert_int_eq((int)watch.before, 2);
  ck_assert_int_eq((int)watch.after, 2);
  ck_assert_double_eq_tol(watch.time, 0.4, 1e-12);
  UNIT_FAILS(MpmModelSetLoadFactor(model, "pull", 1.), PETSC_ERR_ARG_OUTOFRANGE, "there is no load pull");
  UNIT_FAILS(MpmModelGetReaction(model, "roof", reaction), PETSC_ERR_ARG_OUTOFRANGE,
             "there is no condition, motion, boundary or contact roof");
  CALL(MpmModelDestroy(&model));
}
END_TEST

/* Values written into the points are the start of the next step. */
START_TEST(points)
{
  MpmModel   model;
  MpmStatus  status;
  PetscInt   count, total, sum, first, components;
  PetscReal *array, before = 0., after = 0.;

  CALL(Create(3, &model));
  CALL(MpmModelSetUp(model));
  CALL(MpmModelGetPointCount(model, &count, &total));
  CALL(MPI_Allreduce(&count, &sum, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  ck_assert_int_eq((int)sum, (int)total);
  CALL(MpmModelFindState(model, "m", "equivalent_plastic_strain", &first, &components));
  ck_assert_int_eq((int)components, 1);
  CALL(MpmModelGetPoints(model, "state", &components, &array));
  for (PetscInt p = 0; p < count; p++) array[p * components + first] = 0.5;
  CALL(MpmModelRestorePoints(model, "state", NULL, &array));
  ck_assert_ptr_null(array);
  CALL(MpmModelStep(model, &status));
  CALL(MpmModelGetPointCount(model, &count, NULL));
  CALL(MpmModelGetPoints(model, "state", &components, &array));
  before = count ? array[first] : 0.5;
  for (PetscInt p = 0; p < count; p++) after = PetscMax(after, PetscAbsReal(array[p * components + first] - 0.5));
  CALL(MpmModelRestorePoints(model, "state", NULL, &array));
  ck_assert_double_ge(before, 0.5);
  ck_assert_double_lt(after, 0.1);
  UNIT_FAILS(MpmModelGetPoints(model, "increment", &components, &array), PETSC_ERR_ARG_OUTOFRANGE,
             "the points have no field increment");
  CALL(MpmModelDestroy(&model));
}
END_TEST

/* ---- memory ---- */

#define MODELS 100
#define WARM   20 /* models until PETSc, MPI and the C library have what they keep */

/* Bytes of the process that are in memory. */
static PetscLogDouble Resident(void)
{
  PetscLogDouble bytes = 0.;

  CALL(PetscMemoryGetCurrentUsage(&bytes));
  return bytes;
}

#if defined(__SANITIZE_ADDRESS__)
#define MOST_GROWTH 1e12 /* bytes: it keeps what has been freed */
#else
#define MOST_GROWTH 2e6
#endif

START_TEST(memory)
{
  PetscLogDouble allocated = 0., resident = 0., now = 0.;

  for (PetscInt k = 0; k < MODELS; k++) {
    Outcome outcome;

    if (k == WARM) {
      CALL(PetscMallocGetCurrentUsage(&allocated));
      resident = Resident();
    }
    CALL(RunAlone(k % 2, &outcome));
    CALL(PetscFree(outcome.values));
  }
  CALL(PetscMallocGetCurrentUsage(&now));
  ck_assert_msg(now <= allocated, "%g bytes are left by %d models", now - allocated, MODELS - WARM);
  ck_assert_msg(Resident() - resident < MOST_GROWTH, "the process has grown by %g bytes", Resident() - resident);
}
END_TEST

/*
  PETSc reports memory that is not freed at its end on stdout, with the function and the line that allocated it.
  Therefore the tests run with stdout in a file, which is shown and searched.
*/
static int RunCaptured(int count, char **words, const TTest *const tests[], size_t test_count)
{
  FILE     *shown = tmpfile();
  const int saved = dup(STDOUT_FILENO);
  char      line[512];
  int       result;

  if (!shown || saved < 0 || fflush(stdout) || dup2(fileno(shown), STDOUT_FILENO) < 0) return EXIT_FAILURE;
  result = UnitRun(&count, &words, "models", test_count, tests);
  (void)fflush(stdout);
  (void)dup2(saved, STDOUT_FILENO);
  rewind(shown);
  while (fgets(line, sizeof(line), shown)) {
    (void)fputs(line, stdout);
    if (line[0] == '[' && strstr(line, "bytes")) result = EXIT_FAILURE;
  }
  (void)fclose(shown);
  return result;
}

int main(int argc, char **argv)
{
  const TTest *const tests[] = {interleaved, databases, errors, laboratory, hooks, points, memory};
  static char        dump[]  = "-malloc_dump";
  char             **words   = (char **)calloc((size_t)argc + 2, sizeof(char *));
  int                result;

  for (int k = 0; k < argc; k++) words[k] = argv[k];
  words[argc] = dump;
  result      = RunCaptured(argc + 1, words, tests, sizeof(tests) / sizeof(tests[0]));
  free(words);
  return result;
}
