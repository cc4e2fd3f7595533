/*
  Terms of types that were registered from outside the tree: sums over the elements at the points,

    E = sum_p e_p(u) ,   r_ic = d E / d u_ic ,   K_icjd = d r_ic / d u_jd ,

  where the type has an energy; otherwise it gives r and K alone. The elements of a group make one block, from which the
  engine makes the action, that of the transpose and the diagonal (assembly/element_action.c).
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/parameter.h"
#include "point/term_types.h"
#include "grid/grid.h"
#include "space/point_loop.h"
#include "space/rules.h"
#include "assembly/sparsity.h"
#include "volume/added_term.h"
#include "volume/background.h"
#include "volume/irreversible.h"

/* ---- sums over the elements ---- */

/* Wanted sums, each may be NULL; `matrix`: room for a group's block, with a pattern. */
typedef struct {
  PetscReal  *energy, *residual, *matrix;
  MpmPattern *pattern;
} Wanted;

/* The element of point p, but for its nodes. */
static MpmTermElement Element(const MpmAddedTerm *added, const MpmSum *sum, PetscInt p)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = sum->layout->dim;

  return (MpmTermElement){.dim       = dim,
                          .block     = sum->block,
                          .x         = &points->x[p * dim],
                          .origin    = &points->origin[p * dim],
                          .volume0   = points->volume0[p],
                          .time      = added->time,
                          .dt        = sum->step.span,
                          .id        = points->id[p],
                          .parameter = added->parameter,
                          .table     = added->table,
                          .ctx       = added->ctx};
}

/* Sums of one group's elements. */
static void SumGroup(const MpmAddedTerm *added, const MpmSum *sum, const MpmGroup *group, const PetscReal u[],
                     MpmWorkspace *work, const Wanted *wanted, PetscInt *failed)
{
  const MpmKnown known  = KnownGeneral(sum->layout, group);
  PetscReal     *matrix = wanted->matrix;
  PetscInt       count  = 0;
  MpmBases       bases;

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p       = sum->space->order[s];
    MpmTermElement element = Element(added, sum, p);

    if (!added->acts[p]) continue;
    if (!count++) {
      MpmSumGather(known, sum, group, u, work->values);
      for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
      for (PetscInt k = 0; matrix && k < known.n * known.n * known.block * known.block; k++) matrix[k] = 0.;
    }
    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    MpmBasisList(sum->layout, &work->basis, bases);
    element.nodes = known.n;
    element.basis = bases;
    element.u     = work->values;
    if (added->type->evaluate(&element, wanted->energy, wanted->residual ? work->force : NULL, matrix)) (*failed)++;
  }
  if (count && wanted->residual) MpmSumScatter(known, sum, group, work->force, wanted->residual);
  if (count && matrix) MpmPatternAddBlock(wanted->pattern, sum->space, group, matrix);
}

static PetscErrorCode SumElements(const MpmAddedTerm *added, const MpmSum *sum, const PetscReal u[], Wanted wanted,
                                  PetscInt *failed)
{
  const PetscInt most = PetscPowInt(sum->space->width, sum->space->dim) * sum->block;
  MpmWorkspace   work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  if (wanted.pattern) PetscCall(PetscMalloc1((most * most), &wanted.matrix));
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    SumGroup(added, sum, &sum->space->groups[g], u, &work, &wanted, failed);
  PetscCall(PetscFree(wanted.matrix));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term ---- */

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmAddedTerm    *added  = (MpmAddedTerm *)ctx;
  const MpmPoints *points = step->sum->points;

  PetscFunctionBeginUser;
  added->time = step->rules->time.end;
  PetscCall(PetscFree(added->acts));
  PetscCall(PetscMalloc1((points->count + 1), &added->acts));
  for (PetscInt p = 0; p < points->count; p++)
    added->acts[p] = MpmRegionContains(added->region, &points->origin[p * step->sum->layout->dim]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const Wanted wanted = {.residual = residual};

  PetscFunctionBeginUser;
  PetscCall(SumElements((const MpmAddedTerm *)ctx, sum, u, wanted, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const Wanted wanted = {.residual = residual, .pattern = pattern};

  PetscFunctionBeginUser;
  PetscCall(SumElements((const MpmAddedTerm *)ctx, sum, u, wanted, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddEnergy(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *energy,
                                PetscInt *failed)
{
  const Wanted wanted = {.energy = energy};

  PetscFunctionBeginUser;
  PetscCall(SumElements((const MpmAddedTerm *)ctx, sum, u, wanted, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work of the forces in u, by their mean of the step's start and of `at`. */
static PetscErrorCode MeanWork(const MpmAddedTerm *added, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                               PetscReal *taken)
{
  const PetscInt bs = sum->block, count = sum->space->local * bs;
  PetscReal     *force, *start;
  Wanted         wanted = {.residual = NULL};
  PetscInt       failed = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(count, &force, count, &start));
  wanted.residual = force;
  PetscCall(SumElements(added, sum, at, wanted, &failed));
  PetscCall(SumElements(added, sum, start, wanted, &failed));
  for (PetscInt k = 0; k < count; k++)
    if (k % bs < sum->layout->dim) *taken += 0.5 * force[k] * u[k];
  PetscCall(PetscFree2(force, start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Energy at `at` less that of the step's start. */
static PetscErrorCode EnergyGain(const MpmAddedTerm *added, const MpmSum *sum, const PetscReal at[], PetscReal *taken)
{
  PetscReal    before = 0., *start;
  const Wanted then = {.energy = &before}, now = {.energy = taken};
  PetscInt     failed = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((sum->space->local * sum->block), &start));
  PetscCall(SumElements(added, sum, start, then, &failed));
  PetscCall(SumElements(added, sum, at, now, &failed));
  *taken -= before;
  PetscCall(PetscFree(start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddWork(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                              MpmTermWork *work)
{
  const MpmAddedTerm *added = (const MpmAddedTerm *)ctx;
  PetscReal           taken = 0.;

  PetscFunctionBeginUser;
  if (added->type->traits & MPM_ELEMENT_ENERGY) PetscCall(EnergyGain(added, sum, at, &taken));
  else PetscCall(MeanWork(added, sum, at, u, &taken));
  if (added->type->traits & MPM_ELEMENT_DISSIPATES) work->dissipated += taken;
  else work->external -= taken;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- reading ---- */

/* For -help: every type with its parameters. */
static PetscErrorCode PrintTypes(const MpmOptions *block)
{
  const MpmTermType *type;
  char               title[256];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; (type = MpmTermTypeAt(k)); k++) {
    PetscCall(PetscSNPrintf(title, sizeof(title), "Term of type %s: %s", type->name, type->summary));
    PetscCall(MpmOptionsHeading(block, title));
    PetscCall(MpmParametersPrint(block, type->parameter_count, type->parameters));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadType(const MpmOptions *block, const MpmTermType **type)
{
  char *word, *names = NULL;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsText(block, "type", "a type of term that a plugin or the caller brings", NULL, MPM_REQUIRED, &word));
  if (MpmOptionsHelp()) {
    PetscCall(PetscFree(word));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *type = MpmTermTypeFind(word);
  for (PetscInt k = 0; !*type && MpmTermTypeAt(k); k++)
    PetscCall(MpmTextAppend(&names, "%s%s", k ? ", " : "", MpmTermTypeAt(k)->name));
  MpmCheckInput(*type, "-%stype %s: is no type of term; there is %s", block->prefix, word, names ? names : "none");
  PetscCall(PetscFree(word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmTerm Entry(const MpmTermType *type)
{
  return (MpmTerm){.name          = type->name,
                   .prepare       = Prepare,
                   .residual      = Residual,
                   .tangent       = Tangent,
                   .energy.stored = type->traits & MPM_ELEMENT_ENERGY ? AddEnergy : NULL,
                   .energy.work   = AddWork};
}

static PetscErrorCode TermRead(const MpmOptions *options, const char name[], const MpmGrid *grid, MpmAddedTerm *added)
{
  char           *prefix = NULL;
  MpmOptions      block  = {options->comm, NULL, options->record};
  PetscReal       tolerance[MPM_MAX_DIM];
  MpmTermSettings settings = {options->comm, grid->dim, name, NULL, NULL};

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(&prefix, "mpm_term_%s_", name));
  block.prefix = prefix;
  PetscCall(MpmOptionsHeading(&block, "Term from outside the program"));
  PetscCall(ReadType(&block, &added->type));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &added->region));
  if (MpmOptionsHelp()) PetscCall(PrintTypes(&block));
  else {
    PetscCall(MpmParametersRead(&block, added->type->parameter_count, added->type->parameters, &added->parameter,
                                &added->table));
    settings.parameter = added->parameter;
    settings.table     = added->table;
    if (added->type->create) PetscCall(added->type->create(&settings, &added->ctx));
    added->term = Entry(added->type);
  }
  PetscCall(PetscFree(prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAddedTermsRead(const MpmOptions *options, const MpmGrid *grid, MpmAddedTerms *added)
{
  PetscFunctionBeginUser;
  PetscCall(MpmBackgroundsRead(options, grid, &added->backgrounds));
  PetscCall(MpmOptionsBlocks(options, "terms", "names of the terms of types that a plugin or the caller brings",
                             MPM_OPTIONAL, &added->count, &added->names));
  PetscCall(PetscCalloc1(added->count, &added->at));
  for (PetscInt k = 0; k < added->count; k++) PetscCall(TermRead(options, added->names[k], grid, &added->at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAddedTermsDestroy(MpmAddedTerms *added)
{
  PetscFunctionBeginUser;
  PetscCall(MpmBackgroundsDestroy(&added->backgrounds));
  PetscCall(MpmHeldFieldDestroy(&added->held));
  for (PetscInt k = 0; added->at && k < added->count; k++) {
    MpmAddedTerm *one = &added->at[k];

    if (one->ctx && one->type->destroy) PetscCall(one->type->destroy(&one->ctx));
    PetscCall(MpmRegionDestroy(&one->region));
    if (one->type) PetscCall(MpmTablesDestroy((size_t)one->type->parameter_count, &one->table));
    PetscCall(PetscFree(one->parameter));
    PetscCall(PetscFree(one->acts));
  }
  PetscCall(PetscFree(added->at));
  PetscCall(MpmNamesDestroy(added->count, &added->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmAddedTermsAreSymmetric(const MpmAddedTerms *added)
{
  for (PetscInt k = 0; k < added->count; k++)
    if (added->at[k].type && !(added->at[k].type->traits & MPM_ELEMENT_SYMMETRIC)) return PETSC_FALSE;
  return PETSC_TRUE;
}
