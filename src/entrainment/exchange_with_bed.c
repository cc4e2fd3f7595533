/*
  Exchange of mass between the points and the bed, at a step's end: parts of their mass at the nodes, in the shear
  stress and speed of the step, and from there to the points. Sums over points and over nodes agree to rounding:

    m_p += m_p sum_i w_ip x_i ,   sum_p m_p sum_i w_ip x_i = sum_i x_i m_i
*/
#include "talus/point/basal.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "entrainment/entrainment_impl.h"

#define EMPTY 1e-12 /* of a point's mass: with less the point is removed */

/* Gain and loss at a node and at a point, parts of its mass. */
enum { GAIN, LOSS, PARTS };

static PetscReal ByPlace(const MpmByPlace *of, const PetscReal x[])
{
  return of->map.value ? MpmMapAt(&of->map, x) : of->number;
}

/* Place of a node on the grid's lattice, and its area, m2. */
static PetscInt Place(const MpmSum *sum, PetscInt i, PetscReal *area)
{
  const MpmGrid *grid = sum->grid;
  PetscInt       at[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, &sum->space->node[i * 2], at);
  *area = grid->h[0] * grid->h[1];
  for (PetscInt a = 0; a < 2; a++)
    if (at[a] == 0 || at[a] == grid->cells[a]) *area *= 0.5;
  return at[0] + grid->nodes[0] * at[1];
}

/* A node where material is: its mass, kg, m; the area that it covers over the cosine of the bed's slope, m2; and the
   density of the ground there, kg/m3. */
typedef struct {
  PetscReal mass, area, ground;
} Node;

static Node Look(const MpmEntrainment *of, PetscInt i)
{
  const PetscReal *sums = &of->flow->sums[i * MPM_BED_SUMS];
  Node             node = {.mass = sums[MPM_BED_MASS], .area = sums[MPM_BED_AREA]};
  PetscReal        slope[2];

  if (!(node.mass > 0.)) return node;
  for (PetscInt a = 0; a < 2; a++) slope[a] = sums[MPM_BED_SLOPE + a] / node.mass;
  node.area /= PetscSqrtReal(MpmBedCosine2(of->bed, slope));
  node.ground = of->density > 0. ? of->density : node.mass / sums[MPM_BED_VOLUME];
  return node;
}

/* Mass that is eroded at a node in a step, kg; `left`: ground that may be, m3. */
static PetscReal Eroded(const MpmEntrainment *of, const Node *node, const MpmBedShear *shear, const PetscReal x[],
                        PetscReal dt, PetscReal left)
{
  const PetscReal excess = shear->stress - ByPlace(&of->erosion.strength, x);
  PetscReal       mass;

  if (!(shear->speed > 0.) || excess < 0. || !(left > 0.)) return 0.;
  mass = of->erosion.distance ? node->mass * PetscExpReal(of->erosion.rate * shear->speed * dt) - node->mass
                              : node->ground * node->area * of->erosion.rate * excess * dt;
  return PetscMin(mass, node->ground * left);
}

/* Mass that is left at a node in a step, kg. */
static PetscReal Deposited(const MpmEntrainment *of, const Node *node, const MpmBedShear *shear, PetscReal dt)
{
  const PetscReal part = shear->speed / of->deposition.speed;

  if (part >= 1.) return 0.;
  return PetscMin(node->ground * node->area * of->deposition.rate * (1. - part * part) * dt, node->mass);
}

/* Parts at the local nodes; the bed's steps and the masses at the owned ones. */
static PetscErrorCode FindParts(const MpmEntrainment *of, const MpmSum *sum, PetscReal parts[], MpmBedSteps *steps,
                                PetscReal mass[PARTS])
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < sum->space->local; i++) {
    const MpmBedShear *shear = &of->flow->on_bed.shear[i];
    const Node         node  = Look(of, i);
    PetscReal          x[MPM_MAX_DIM], area, gain = 0., loss = 0.;
    PetscInt           place;

    if (!(node.mass > 0.)) continue;
    place = Place(sum, i, &area);
    MpmGridNodeAtStart(sum->grid, &sum->space->node[i * 2], x);
    if (of->erodes)
      gain = Eroded(of, &node, shear, x, sum->step.dt,
                    area * (ByPlace(&of->erosion.depth, x) + of->bed->change.value[place]));
    if (of->deposits) loss = Deposited(of, &node, shear, sum->step.dt);
    parts[PARTS * i + GAIN] = gain / node.mass;
    parts[PARTS * i + LOSS] = loss / node.mass;
    if (i >= sum->space->owned || gain + loss == 0.) continue;
    mass[GAIN] += gain;
    mass[LOSS] += loss;
    steps->place[steps->count]    = place;
    steps->height[steps->count++] = (loss - gain) / (node.ground * area);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A point takes its part: momentum of the eroded mass is zero, that of the left mass goes with it. */
static void TakePart(const MpmSum *sum, PetscInt p, const PetscReal part[PARTS], MpmEntrainmentAccount *account)
{
  const MpmPoints *points = sum->points;
  const PetscReal  grown = 1. + part[GAIN] - part[LOSS], slower = (1. - part[LOSS]) / grown;
  const PetscReal  mass =
    points->mass ? points->mass[p] : points->volume0[p] * sum->materials[points->material[p]].density;
  PetscReal *v = &points->motion.velocity[2 * p], square = 0.;

  if (part[GAIN] == 0. && part[LOSS] == 0.) return;
  for (PetscInt a = 0; a < 2; a++) {
    square += v[a] * v[a];
    account->carried[a] -= part[LOSS] * mass * v[a];
  }
  if (grown < EMPTY) {
    points->volume0[p] = 0.;
    account->energy += 0.5 * mass * square;
    return;
  }
  account->energy += 0.5 * mass * square * (1. - grown * slower * slower);
  points->volume0[p] *= grown;
  if (points->mass) points->mass[p] *= grown;
  points->state[p * sum->kept.state] *= grown;
  for (PetscInt a = 0; a < 2; a++) v[a] *= slower;
  for (PetscInt k = 0; points->motion.affine && k < 4; k++) points->motion.affine[4 * p + k] *= slower;
}

static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmEntrainment       *of    = ctx;
  const PetscInt        count = sum->points->count, local = sum->space->local;
  MpmEntrainmentAccount step  = {0};
  MpmBedSteps           steps = {0};
  PetscReal            *parts, *part, mass[PARTS] = {0.}, sums[3 + PARTS];

  (void)u, (void)particles;
  PetscFunctionBeginUser;
  if (!of->erodes && !of->deposits) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((size_t)(PARTS * local), &parts));
  PetscCall(PetscMalloc1((size_t)(PARTS * count), &part));
  PetscCall(PetscMalloc2(local, &steps.place, local, &steps.height));
  PetscCall(FindParts(of, sum, parts, &steps, mass));
  PetscCall(MpmDisplacementsAtPoints(sum, parts, part));
  for (PetscInt p = 0; p < count; p++) TakePart(sum, p, &part[PARTS * p], &step);
  PetscCall(MpmBedChangeAdd(sum->grid->comm, &steps, of->bed));
  sums[GAIN] = mass[GAIN];
  sums[LOSS] = mass[LOSS];
  sums[2]    = step.energy;
  for (PetscInt a = 0; a < 2; a++) sums[3 + a] = step.carried[a];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 3 + PARTS, MPIU_REAL, MPIU_SUM, sum->grid->comm));
  of->account.eroded += sums[GAIN];
  of->account.deposited += sums[LOSS];
  of->account.energy += sums[2];
  *of->dissipated += sums[2];
  for (PetscInt a = 0; a < 2; a++) of->account.carried[a] += sums[3 + a];
  PetscCall(PetscFree2(steps.place, steps.height));
  PetscCall(PetscFree(parts));
  PetscCall(PetscFree(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Momentum by the bed in an increment. */
static PetscErrorCode Resist(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal kick, PetscReal velocity[])
{
  MpmEntrainment *of      = ctx;
  PetscReal       sums[6] = {0.};

  PetscFunctionBeginUser;
  if (of->inlets) PetscCall(MpmInletsHold(of, sum, mass, kick, velocity));
  for (PetscInt i = 0; i < sum->space->owned; i++) {
    for (PetscInt a = 0; a < 2; a++) {
      sums[a] += kick * of->flow->force[i * sum->block + a];
      sums[2 + a] += kick * of->flow->friction[i * sum->block + a];
      if (of->inlets) sums[4 + a] += kick * of->push[2 * i + a];
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 6, MPIU_REAL, MPIU_SUM, sum->grid->comm));
  for (PetscInt a = 0; a < 2; a++) {
    of->account.bed[a] += sums[a];
    of->account.friction[a] += sums[2 + a];
    of->account.carried[a] += sums[4 + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work of the inlets. */
static PetscErrorCode Work(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                           MpmTermWork *work)
{
  const MpmEntrainment *of = ctx;

  (void)at;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; of->inlets && k < 2 * sum->space->owned; k++) work->external += of->push[k] * u[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermEntrainment = {
  .name = "entrainment", .energy.work = Work, .motion.resist = Resist, .step.commit = Commit};
