/*
  Damping of the material, by the velocity v = factor u + rest of a step:

    Rayleigh          a M v, M the lumped mass (elements of order 2 and more: the consistent one), and b times the
                      stress of the law's elastic moduli for the strain rate,
                      tau = b (lambda tr(d) I + 2 mu d), d = sym(grad v)
    bulk viscosity    the pressure q = rho l (c_2^2 l D^2 - c_1 c D) where D = tr(d) < 0, l the smallest size of a cell
                      and c the speed of waves, which spreads shocks over a few cells
    dashpots          at the nodes of absorbing conditions, spread over their plane where the mass is consistent

  Moduli are those of the step's start, and gradients are taken at its places: the forces are linear in u but for q.

  Sources: von Neumann, Richtmyer (1950), J. Appl. Phys. 21, 232-237, doi:10.1063/1.1699639; Landshoff (1955), Los
  Alamos report LA-1930, for the linear term.
*/
#include "particles/point_mass.h"
#include "space/element_block.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/damping.h"
#include "volume/inertia.h"

PetscErrorCode MpmDampingReset(MpmDamping *damping)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(damping->rest, damping->dashpot));
  PetscCall(PetscFree(damping->viscosity));
  PetscCall(PetscFree(damping->spread));
  damping->active = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsViscous(const MpmDamping *damping)
{
  return (PetscBool)(damping->stiffness > 0. || damping->linear > 0. || damping->quadratic > 0.);
}

static PetscBool Absorbs(const MpmDamping *damping)
{
  for (PetscInt b = 0; damping->conditions && b < damping->conditions->count; b++)
    if (damping->conditions->at[b].absorbing && damping->acting[b].active) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmDampingAny(const MpmDamping *damping)
{
  return (PetscBool)(damping->mass > 0. || IsViscous(damping) || Absorbs(damping));
}

/* The viscosities of the points, by the state of the step's start. */
static PetscErrorCode FindViscosities(MpmDamping *damping, const MpmSum *sum)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = sum->space->dim;
  PetscReal        length = sum->cell[0];

  PetscFunctionBeginUser;
  for (PetscInt a = 1; a < dim; a++) length = PetscMin(length, sum->cell[a]);
  PetscCall(PetscMalloc1((points->count * MPM_VISCOSITIES + 1), &damping->viscosity));
  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &sum->materials[points->material[p]];
    const double      *own      = MpmPointOwn(points, material, p);
    const PetscReal   *state = points->state ? &points->state[p * sum->kept.state] : NULL, *F = MpmPointF(points, p);
    const PetscReal    mass = MpmPointMass(points, sum->materials, p), volume = points->volume0[p];
    const PetscReal    stiffness = PetscMax(MpmMaterialStiffness(material, own, state, F), 0.);
    PetscReal         *viscosity = &damping->viscosity[p * MPM_VISCOSITIES];
    const PetscReal    shear     = MpmMaterialShearModulus(material, own, state, F);

    viscosity[0] = damping->stiffness * volume * (stiffness - 2. * shear);
    viscosity[1] = damping->stiffness * volume * shear;
    viscosity[2] = damping->linear * length * PetscSqrtReal(stiffness * mass * volume);
    viscosity[3] = PetscSqr(damping->quadratic * length) * mass;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmDamping    *damping = (MpmDamping *)ctx;
  const PetscInt local   = step->sum->space->local;

  PetscFunctionBeginUser;
  PetscCall(MpmDampingReset(damping));
  if (!MpmDampingAny(damping)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2((local * step->sum->space->dim), &damping->rest, (local * step->sum->space->dim + 1),
                         &damping->dashpot));
  if (IsViscous(damping)) PetscCall(FindViscosities(damping, step->sum));
  if (Absorbs(damping)) PetscCall(MpmAbsorbingDashpots(damping, step->sum, damping->dashpot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rayleigh's damping by the consistent mass, where lumped masses may be negative. */
static PetscErrorCode SpreadMass(MpmDamping *damping, const MpmSpace *space, const MpmMassMatrix *mass)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((space->local * space->dim + 1), &damping->spread));
  for (PetscInt k = 0; k < space->local * space->dim; k++) damping->spread[k] = damping->mass;
  damping->mass_matrix = mass;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDampingSet(MpmDamping *damping, const MpmSpace *space, const MpmInertia *inertia, PetscReal factor,
                             const PetscReal rest[])
{
  const PetscInt dim = space->dim;

  PetscFunctionBeginUser;
  if (!damping->dashpot) PetscFunctionReturn(PETSC_SUCCESS);
  damping->active = PETSC_TRUE;
  damping->factor = factor;
  PetscCall(PetscArraycpy(damping->rest, rest, space->local * dim));
  if (inertia->consistent && Absorbs(damping)) PetscCall(MpmAbsorbingSpread(damping, space, &inertia->matrix));
  if (damping->mass > 0. && inertia->solved) PetscCall(SpreadMass(damping, space, &inertia->matrix));
  else
    for (PetscInt k = 0; damping->mass > 0. && k < space->local * dim; k++)
      damping->dashpot[k] += damping->mass * inertia->mass[k / dim];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- at the points ---- */

/* G_ab = d v_a / d x_b at a point, from the nodes' values [c][i]. */
static void Gradient(const MpmKnown known, const MpmBasis *basis, const PetscReal values[], PetscReal G[])
{
  for (PetscInt k = 0; k < known.dim * known.dim; k++)
    G[k] = MpmBasisDerivative(basis, known.n, k % known.dim, &values[k / known.dim * known.n]);
}

static PetscReal Trace(PetscInt dim, const PetscReal G[])
{
  PetscReal sum = 0.;

  for (PetscInt a = 0; a < dim; a++) sum += G[a * dim + a];
  return sum;
}

/* Factor on a change of D: of lambda and of the bulk viscosity at D. */
static PetscReal BulkSlope(const PetscReal viscosity[], PetscReal D)
{
  return viscosity[0] + (D < 0. ? viscosity[2] - 2. * viscosity[3] * D : 0.);
}

/*
  y += the points' forces at the velocities `v` of the local nodes; where `at` is not NULL their change by `v` from
  there, instead.
*/
static PetscErrorCode AddViscous(const MpmDamping *damping, const MpmSum *sum, const PetscReal v[], const PetscReal *at,
                                 PetscReal y[])
{
  const PetscInt dim = sum->space->dim;
  PetscReal     *values;
  MpmWorkspace   work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc1((PetscPowInt(sum->space->width, dim) * sum->block), &values));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);

    MpmSumGather(known, sum, group, v, work.values);
    if (at) MpmSumGather(known, sum, group, at, values);
    for (PetscInt k = 0; k < known.n * known.block; k++) work.force[k] = 0.;
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt   p         = sum->space->order[s];
      const PetscReal *viscosity = &damping->viscosity[p * MPM_VISCOSITIES];
      PetscReal        G[MPM_MAX_DIM * MPM_MAX_DIM], base[MPM_MAX_DIM * MPM_MAX_DIM], D, pressure;

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work.basis);
      Gradient(known, &work.basis, work.values, G);
      D = Trace(dim, G);
      if (at) {
        Gradient(known, &work.basis, values, base);
        pressure = BulkSlope(viscosity, Trace(dim, base)) * D;
      } else pressure = viscosity[0] * D + (D < 0. ? viscosity[2] * D - viscosity[3] * D * D : 0.);
      for (PetscInt a = 0; a < dim; a++)
        for (PetscInt b = 0; b < dim; b++)
          MpmBasisAddFlux(&work.basis, known.n, b,
                          viscosity[1] * (G[a * dim + b] + G[b * dim + a]) + (a == b ? pressure : 0.),
                          &work.force[a * known.n]);
    }
    MpmSumScatter(known, sum, group, work.force, y);
  }
  PetscCall(PetscFree(values));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term ---- */

/* Velocities at the local nodes, `block` a node. */
static PetscErrorCode Velocities(const MpmDamping *damping, const MpmSum *sum, const PetscReal u[], PetscBool rest,
                                 PetscReal **v)
{
  const PetscInt dim = sum->space->dim, bs = sum->block;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((sum->space->local * bs), v));
  for (PetscInt k = 0; k < sum->space->local * dim; k++) {
    const PetscInt at = k / dim * bs + k % dim;

    (*v)[at] = damping->factor * u[at] + (rest ? damping->rest[k] : 0.);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* c_ij of a component, i and j the local unknowns of a pair of nodes with this entry of the mass. */
static PetscReal SpreadDashpot(const MpmDamping *damping, PetscInt i, PetscInt j, PetscReal mass)
{
  const PetscReal *spread = damping->spread;

  return spread[i] > 0. && spread[j] > 0. ? 0.5 * (spread[i] + spread[j]) * mass : 0.;
}

static void AddSpread(const MpmDamping *damping, PetscInt dim, PetscInt bs, const PetscReal v[], PetscReal y[])
{
  const MpmMassMatrix *mass = damping->mass_matrix;

  for (PetscInt i = 0; i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0, j = mass->column[k]; c < dim; c++)
        y[i * bs + c] += SpreadDashpot(damping, i * dim + c, j * dim + c, mass->value[k]) * v[j * bs + c];
}

static void AddDashpots(const MpmDamping *damping, const MpmSum *sum, const PetscReal v[], PetscReal y[])
{
  const PetscInt dim = sum->space->dim, bs = sum->block;

  for (PetscInt k = 0; k < sum->space->owned * dim; k++)
    y[k / dim * bs + k % dim] += damping->dashpot[k] * v[k / dim * bs + k % dim];
  if (damping->spread) AddSpread(damping, dim, bs, v, y);
}

/* The dashpots of a pair of nodes, to the Jacobian. */
static void AddPair(const MpmDamping *damping, const MpmSpace *space, const PetscInt nodes[2], PetscReal mass,
                    MpmPattern *pattern)
{
  const PetscInt bs = pattern->block, dim = space->dim, n = nodes[0] == nodes[1] ? 1 : 2;
  PetscReal      element[4 * MPM_MAX_BLOCK * MPM_MAX_BLOCK] = {0.};
  PetscBool      any                                        = PETSC_FALSE;

  for (PetscInt c = 0; c < dim; c++) {
    const PetscReal value = SpreadDashpot(damping, nodes[0] * dim + c, nodes[1] * dim + c, mass);

    element[(c * bs + c) * n + n - 1] = damping->factor * value;
    any                               = (PetscBool)(any || value > 0.);
  }
  if (any) MpmPatternAddNodes(pattern, space, n, nodes, element);
}

static void AddDashpotsTangent(const MpmDamping *damping, const MpmSum *sum, MpmPattern *pattern)
{
  const PetscInt       bs = sum->block, dim = sum->space->dim;
  const MpmMassMatrix *mass = damping->mass_matrix;

  for (PetscInt i = 0; i < sum->space->owned; i++) {
    PetscReal block[MPM_MAX_BLOCK * MPM_MAX_BLOCK] = {0.};
    PetscBool any                                  = PETSC_FALSE;

    for (PetscInt c = 0; c < dim; c++) {
      block[c * bs + c] = damping->factor * damping->dashpot[i * dim + c];
      any               = (PetscBool)(any || block[c * bs + c] != 0.);
    }
    if (any) MpmPatternAddNodes(pattern, sum->space, 1, &i, block);
  }
  for (PetscInt i = 0; damping->spread && i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      AddPair(damping, sum->space, (const PetscInt[]){i, mass->column[k]}, mass->value[k], pattern);
}

static void AddDashpotsDiagonal(const MpmDamping *damping, const MpmSum *sum, PetscReal blocks[])
{
  const PetscInt       bs = sum->block, dim = sum->space->dim;
  const MpmMassMatrix *mass = damping->mass_matrix;

  for (PetscInt k = 0; k < sum->space->owned * dim; k++)
    blocks[(k / dim * bs + k % dim) * bs + k % dim] += damping->factor * damping->dashpot[k];
  for (PetscInt i = 0; damping->spread && i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0, at = i * dim; c < dim && mass->column[k] == i; c++)
        blocks[(i * bs + c) * bs + c] += damping->factor * SpreadDashpot(damping, at + c, at + c, mass->value[k]);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmDamping *damping = (const MpmDamping *)ctx;
  PetscReal        *v;

  PetscFunctionBeginUser;
  (void)failed;
  if (!damping->active) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Velocities(damping, sum, u, PETSC_TRUE, &v));
  AddDashpots(damping, sum, v, residual);
  if (damping->viscosity) PetscCall(AddViscous(damping, sum, v, NULL, residual));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmDamping *damping = (const MpmDamping *)ctx;
  PetscReal        *v, *dv;

  PetscFunctionBeginUser;
  if (!damping->active) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Velocities(damping, sum, u, PETSC_TRUE, &v));
  PetscCall(Velocities(damping, sum, du, PETSC_FALSE, &dv));
  AddDashpots(damping, sum, dv, y);
  if (damping->viscosity) PetscCall(AddViscous(damping, sum, dv, v, y));
  PetscCall(PetscFree(v));
  PetscCall(PetscFree(dv));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of a point's fluxes by the inputs of the kernel, the components of the gradient: with axial symmetry the
   hoop strain, last, has no part. */
static void FluxSlope(PetscInt dim, PetscInt inputs, PetscReal bulk, PetscReal shear, PetscReal D[])
{
  for (PetscInt k = 0; k < inputs * inputs; k++) D[k] = 0.;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      D[(a * dim + a) * inputs + b * dim + b] += bulk;
      D[(a * dim + b) * inputs + a * dim + b] += shear;
      D[(a * dim + b) * inputs + b * dim + a] += shear;
    }
  }
}

/* The element block of a group, at velocities of the local nodes; `rows`: room for MpmSumAddBlock(). */
static void Element(const MpmDamping *damping, const MpmSum *sum, const MpmGroup *group, const PetscReal v[],
                    MpmWorkspace *work, PetscReal element[], PetscReal rows[])
{
  const MpmKnown known = KnownGeneral(sum->layout, group);

  for (PetscInt k = 0; k < known.n * known.n * known.block * known.block; k++) element[k] = 0.;
  MpmSumGather(known, sum, group, v, work->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt   p         = sum->space->order[s];
    const PetscReal *viscosity = &damping->viscosity[p * MPM_VISCOSITIES];
    PetscReal        G[MPM_MAX_DIM * MPM_MAX_DIM], D[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    Gradient(known, &work->basis, work->values, G);
    FluxSlope(known.dim, known.inputs, damping->factor * BulkSlope(viscosity, Trace(known.dim, G)),
              damping->factor * viscosity[1], D);
    MpmSumAddBlock(known, sum->layout, &work->basis, D, rows, element);
  }
}

/* Room for the block of any group, and for MpmSumAddBlock(). */
static PetscErrorCode ElementCreate(const MpmSum *sum, MpmWorkspace *work, PetscReal **element, PetscReal **rows)
{
  const PetscInt most = PetscPowInt(sum->space->width, sum->space->dim) * sum->block;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, work));
  PetscCall(PetscMalloc2((most * most), element, (most * sum->layout->input.count), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmDamping *damping = (const MpmDamping *)ctx;
  PetscReal        *v, *element, *rows;
  MpmWorkspace      work;

  PetscFunctionBeginUser;
  if (!damping->active) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  AddDashpotsTangent(damping, sum, pattern);
  if (!damping->viscosity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Velocities(damping, sum, u, PETSC_TRUE, &v));
  PetscCall(ElementCreate(sum, &work, &element, &rows));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    Element(damping, sum, &sum->space->groups[g], v, &work, element, rows);
    MpmPatternAddBlock(pattern, sum->space, &sum->space->groups[g], element);
  }
  PetscCall(PetscFree2(element, rows));
  PetscCall(PetscFree(work.storage));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmDamping *damping = (const MpmDamping *)ctx;
  const PetscInt    bs      = sum->block;
  PetscReal        *v, *element, *rows;
  MpmWorkspace      work;

  PetscFunctionBeginUser;
  (void)failed;
  if (!damping->active) PetscFunctionReturn(PETSC_SUCCESS);
  AddDashpotsDiagonal(damping, sum, blocks);
  if (!damping->viscosity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Velocities(damping, sum, u, PETSC_TRUE, &v));
  PetscCall(ElementCreate(sum, &work, &element, &rows));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], n = group->node_count;

    Element(damping, sum, group, v, &work, element, rows);
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt ab = 0; ab < bs * bs; ab++)
        blocks[(nodes[i] * bs + ab / bs) * bs + ab % bs] += element[((i * bs + ab / bs) * bs + ab % bs) * n + i];
  }
  PetscCall(PetscFree2(element, rows));
  PetscCall(PetscFree(work.storage));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmDamping *)ctx)->active;
}

const MpmTerm MpmTermDamping = {.name             = "damping",
                                .idle             = Idle,
                                .prepare          = Prepare,
                                .residual         = Residual,
                                .tangent          = Tangent,
                                .apply            = Apply,
                                .diagonal         = Diagonal,
                                .energy.account   = MPM_ACCOUNT_DISSIPATED,
                                .energy.quadratic = MpmTermIsQuadratic};
