/*
  Flow at a node in a state. Depth is the volume about it over the node's own area: a map has the volume of the points,

    h_i = sum_p w_ip V_p / integral of w_i .
*/
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"
#include "integrators/dynamics.h"
#include "runout/runout_impl.h"

PetscInt MpmRunoutLatticeNode(const MpmModel model, PetscInt i)
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(model->disc.space, &model->disc.space->node[i * model->disc.dim], at);
  return at[0] + model->disc.grid->nodes[0] * at[1];
}

/* Area of a node in the grid, m2. */
static PetscReal Area(const MpmGrid *grid, const PetscInt at[])
{
  PetscReal area = grid->h[0] * grid->h[1];

  for (PetscInt a = 0; a < 2; a++)
    if (at[a] == 0 || at[a] == grid->cells[a]) area *= 0.5;
  return area;
}

void MpmRunoutNode(const MpmModel model, PetscInt i, MpmNodeFlow *flow)
{
  const PetscReal *sums = &model->disc.context.bed->sums[i * MPM_BED_SUMS];
  const PetscReal *v    = &model->state.scheme.dynamics->v_new[i * model->disc.block];
  const PetscInt  *node = &model->disc.space->node[i * model->disc.dim];
  PetscReal        square, rise = 0.;

  *flow = (MpmNodeFlow){.depth = 0.};
  if (!(sums[MPM_BED_MASS] > 0.)) return;
  flow->depth = sums[MPM_BED_VOLUME] / Area(model->disc.grid, node);
  for (PetscInt a = 0; a < 2; a++) flow->velocity[a] = v[a];
  if (model->runout->along) rise = (v[0] * sums[MPM_BED_SLOPE] + v[1] * sums[MPM_BED_SLOPE + 1]) / sums[MPM_BED_MASS];
  square         = v[0] * v[0] + v[1] * v[1] + rise * rise;
  flow->speed    = PetscSqrtReal(square);
  flow->pressure = sums[MPM_BED_MASS] / sums[MPM_BED_VOLUME] * square;
}
