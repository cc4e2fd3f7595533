/*
  Loads on the material. Points are picked in the initial state, and each point's share is kept in a field of the
  particles, so that shares travel with the points.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "selection/air_points.h"
#include "selection/selection.h"
#include "space/point_shape.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "loads/load.h"
#include "loads/load_weights.h"

/*
  The face of the domains that a traction acts on: an axis and a side, like +y; by default the axis along which the
  region has no extent.
*/
static PetscErrorCode ReadFace(const MpmOptions *block, const MpmGrid *grid, MpmLoad *load)
{
  static const char *const faces[] = {"-x", "+x", "-y", "+y", "-z", "+z", NULL};
  PetscReal                lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], thinnest = PETSC_INFINITY;
  PetscInt                 face = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "face",
                           "face of the points' domains under traction (default: across the region's thinnest axis)",
                           faces, MPM_OPTIONAL, &face, &load->face_given));
  load->face_axis = face / 2;
  load->face_side = face % 2 ? 1 : -1;
  if (load->face_given || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = grid->lower[a];
    upper[a] = grid->upper[a];
  }
  PetscCall(MpmRegionGetBounds(load->where.region, lower, upper));
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal extent = (upper[a] - lower[a]) / grid->h[a];

    if (extent >= thinnest) continue;
    thinnest        = extent;
    load->face_axis = a;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmLoad *load)
{
  static const char *const types[] = {"force", "gravity", "traction", "flux", NULL};
  char                     prefix[256], field[256];
  MpmOptions               block    = {options->comm, prefix, options->record};
  static const char *const places[] = {"point", "face", NULL};
  PetscInt                 place    = 1;
  PetscInt                 type     = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(load, sizeof(*load)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_load_%s_", name));
  PetscCall(PetscSNPrintf(field, sizeof(field), "load_%s", name));
  PetscCall(PetscStrallocpy(name, &load->name));
  PetscCall(MpmOptionsHeading(&block, "Load"));
  PetscCall(MpmOptionsWord(&block, "type", "force (N in total), gravity (m/s2), traction (Pa), flux (m3/s in total)",
                           types, MPM_REQUIRED, &type, NULL));
  load->type = (MpmLoadType)type;
  PetscCall(MpmOptionsReals(&block, "value", "N, m/s2, Pa or m3/s",
                            "the load's vector; of a flux one number, of water that goes into the ground",
                            MPM_RANGE_ANY, MPM_REQUIRED, load->type == MPM_LOAD_FLUX ? 1 : grid->dim, load->value,
                            NULL));
  PetscCall(MpmRampCreate(&block, "ramp", "0:0,1:1", &load->ramp));
  PetscCall(MpmOptionsHas(&block, "ramp", &load->ramped));
  if (load->type == MPM_LOAD_GRAVITY && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrallocpy(field, &load->share_field));
  PetscCall(MpmSelectionRead(&block, grid, &load->where));
  if (load->type == MPM_LOAD_TRACTION || MpmOptionsHelp()) {
    MpmCheckInput(load->where.region, "-%sregion is missing: a traction acts on the points at a region's face", prefix);
    PetscCall(ReadFace(&block, grid, load));
    PetscCall(MpmOptionsWord(
      &block, "place",
      "where a traction acts with shapes without a domain: face (the default), at the centres of the points' "
      "faces, as it does with the others; point, at the points' own places",
      places, MPM_OPTIONAL, &place, NULL));
    load->at_face = (PetscBool)(place == 1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadDestroy(MpmLoad *load)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(load->name));
  PetscCall(PetscFree(load->share_field));
  PetscCall(MpmRegionDestroy(&load->where.region));
  PetscCall(MpmRampDestroy(&load->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- selection ---- */

/* Where the domain's face stands that a traction acts on. */
static PetscReal FacePosition(const MpmLoad *load, PetscInt dim, PetscInt side, const MpmPoints *points, PetscInt p)
{
  const PetscInt k = p * dim + load->face_axis;

  return points->x0[k] + (PetscReal)side * points->domain.half_length[k];
}

/* Region of a traction: its box, and whether it is a face itself or a layer of material behind one. */
typedef struct {
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscBool thin;
} FaceRegion;

/* True where the point's face lies in the region; in a layer, the point. */
static PetscBool FaceSelected(const MpmLoad *load, const FaceRegion *region, PetscInt dim, PetscInt side,
                              const MpmPoints *points, PetscInt p)
{
  PetscReal x[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) x[a] = points->x0[p * dim + a];
  if (region->thin) x[load->face_axis] = FacePosition(load, dim, side, points, p);
  return MpmRegionContains(load->where.region, x);
}

/*
  The outermost face of the selected points on each side, below (0) and above (1), times the side; and whether the
  material ends there: no point beside the region's extent along the other axes reaches further.
*/
static PetscErrorCode FindOutermost(const MpmLoad *load, const FaceRegion *region, const MpmGrid *grid,
                                    const MpmPoints *points, const MpmMaterial *materials, PetscReal outermost[2],
                                    PetscBool ends[2])
{
  const PetscInt dim      = grid->dim;
  PetscReal      reach[4] = {PETSC_NINFINITY, PETSC_NINFINITY, PETSC_NINFINITY, PETSC_NINFINITY};

  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < 2; s++) {
    for (PetscInt p = 0; p < points->count; p++) {
      const PetscInt  side   = s ? 1 : -1;
      const PetscReal face   = (PetscReal)side * FacePosition(load, dim, side, points, p);
      PetscBool       beside = PETSC_TRUE;

      if (MpmPointIsAir(materials, points, p)) continue;
      for (PetscInt a = 0; a < dim; a++) {
        const PetscReal x = points->x0[p * dim + a];

        if (a != load->face_axis && (x < region->lower[a] || x > region->upper[a])) beside = PETSC_FALSE;
      }
      if (FaceSelected(load, region, dim, side, points, p)) reach[s] = PetscMax(reach[s], face);
      if (beside) reach[2 + s] = PetscMax(reach[2 + s], face);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 4, MPIU_REAL, MPIU_MAX, grid->comm));
  for (PetscInt s = 0; s < 2; s++) {
    outermost[s] = reach[s];
    ends[s] =
      (PetscBool)(reach[s] > PETSC_NINFINITY && reach[s] >= reach[2 + s] - MPM_TOLERANCE * grid->h[load->face_axis]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  share = the area of the domain's face where it lies in the region, 0 elsewhere. A region without extent along the
  face's axis is the face itself; in a thicker one it is the outermost face of the points inside, on the side where the
  material ends.
*/
static PetscErrorCode SelectFace(MpmLoad *load, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmMaterial *materials, PetscReal share[])
{
  const PetscInt  dim = grid->dim, axis = load->face_axis;
  const PetscReal slack        = MPM_TOLERANCE * grid->h[axis];
  PetscReal       outermost[2] = {0., 0.}, area = 0.;
  PetscBool       ends[2] = {PETSC_FALSE, PETSC_FALSE};
  FaceRegion      region;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    region.lower[a] = PETSC_NINFINITY;
    region.upper[a] = PETSC_INFINITY;
  }
  PetscCall(MpmRegionGetBounds(load->where.region, region.lower, region.upper));
  region.thin = (PetscBool)(region.upper[axis] - region.lower[axis] <= 4. * slack);
  PetscCall(FindOutermost(load, &region, grid, points, materials, outermost, ends));
  if (!load->face_given) {
    MpmCheckInput(region.thin || ends[0] != ends[1],
                  "-mpm_load_%s_face is missing: the material %s on axis %c of the region", load->name,
                  ends[0] ? "ends on both sides" : "ends on neither side", "xyz"[axis]);
    load->face_side = region.thin ? (outermost[1] > PETSC_NINFINITY ? 1 : -1) : (ends[1] ? 1 : -1);
  }
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal face = (PetscReal)load->face_side * FacePosition(load, dim, load->face_side, points, p);

    share[p] = 0.;
    if (MpmPointIsAir(materials, points, p)) continue;
    if (!FaceSelected(load, &region, dim, load->face_side, points, p)) continue;
    if (face < outermost[load->face_side > 0] - slack) continue;
    share[p] = 1.;
    for (PetscInt a = 0; a < dim; a++)
      if (a != axis) share[p] *= 2. * points->domain.half_length[p * dim + a];
    share[p] *= MpmTurn(points->F_size, axis ? points->x[p * dim] : (PetscReal)load->face_side * face);
    area += share[p];
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &area, 1, MPIU_REAL, MPIU_SUM, grid->comm));
  MpmCheckInput(area > 0., "-mpm_load_%s_region: no point has its face there", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadSelect(MpmLoad *load, const MpmGrid *grid, const MpmMaterials *materials, MpmParticles *particles)
{
  MpmPoints  points;
  PetscReal *share;

  PetscFunctionBeginUser;
  if (load->type == MPM_LOAD_GRAVITY) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmParticlesGetField(particles, load->share_field, &share));
  if (load->type == MPM_LOAD_TRACTION) PetscCall(SelectFace(load, grid, &points, materials->at, share));
  else PetscCall(MpmSelectionShare(&load->where, grid, &points, materials, "load", load->name, share));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- application ---- */

/* The unknown of a node that takes the load's k-th number, and the number's factor: the water's equation is negated. */
static PetscInt Unknown(const MpmLoad *load, const MpmSum *sum, PetscInt k)
{
  return load->type == MPM_LOAD_FLUX ? MpmPressureComponent(sum->layout) : k;
}
static PetscReal Sign(const MpmLoad *load, const MpmSum *sum)
{
  return load->type == MPM_LOAD_FLUX ? -sum->step.dt : 1.;
}

void MpmLoadsGetVertical(const MpmLoads *loads, PetscInt dim, PetscInt *axis, PetscInt *up)
{
  PetscReal most = 0.;

  *axis = dim - 1;
  *up   = 1;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal gravity = 0.;

    for (PetscInt l = 0; l < loads->count; l++)
      if (loads->at[l].type == MPM_LOAD_GRAVITY) gravity += loads->at[l].value[a];
    if (PetscAbsReal(gravity) <= most) continue;
    most  = PetscAbsReal(gravity);
    *axis = a;
    *up   = gravity < 0. ? 1 : -1;
  }
}

PetscErrorCode MpmLoadApply(const MpmLoad *load, PetscReal factor, const MpmRules *rules, const MpmSum *sum,
                            MpmParticles *particles, PetscReal force[])
{
  const MpmSpace  *space   = sum->space;
  const MpmPoints *points  = sum->points;
  const PetscInt   numbers = load->type == MPM_LOAD_FLUX ? 1 : space->dim;
  PetscReal       *share   = NULL, *weight;
  MpmBasis         basis;

  PetscFunctionBeginUser;
  if (factor == 0.) PetscFunctionReturn(PETSC_SUCCESS);
  if (load->share_field) PetscCall(MpmParticlesGetField(particles, load->share_field, &share));
  PetscCall(MpmBasisCreate(space, &basis));
  weight = MpmBasisWeights(&basis);
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt *nodes = &space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt   p  = space->order[s];
      const MpmTouched at = {rules, space, points, group, p};
      const PetscReal  amount =
        Sign(load, sum) * factor * (share ? share[p] : MpmPointMassStart(points, sum->materials, p));

      if (amount == 0. || (!share && MpmPointIsAir(sum->materials, points, p))) continue;
      if (load->type == MPM_LOAD_TRACTION) PetscCall(MpmLoadFaceWeights(load, &at, weight));
      else if (MpmLoadActsAtEnds(load, rules)) PetscCall(MpmLoadEndWeights(load, &at, weight));
      else MpmSpaceEvaluate(space, group, p, &basis);
      for (PetscInt i = 0; i < group->node_count; i++)
        for (PetscInt a = 0; a < numbers; a++)
          force[nodes[i] * sum->block + Unknown(load, sum, a)] += amount * weight[i] * load->value[a];
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  if (share) PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyForceApply(MpmBodyForce function, void *ctx, PetscReal time, const MpmSum *sum, PetscReal force[])
{
  const MpmSpace  *space              = sum->space;
  const MpmPoints *points             = sum->points;
  PetscReal        value[MPM_MAX_DIM] = {0.};
  MpmBasis         basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];

      PetscCall((*function)(space->dim, time, &points->x0[p * space->dim], value, ctx));
      MpmSpaceEvaluate(space, group, p, &basis);
      MpmWeightsAdd(MpmBasisWeights(&basis), group, sum, points->volume0[p], value, force);
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadApplyPoints(const MpmSum *sum, PetscReal part, const PetscReal mass[],
                                  const PetscReal *const stress[], PetscReal force[])
{
  const MpmSpace  *space  = sum->space;
  const MpmPoints *points = sum->points;
  const PetscInt   dim = space->dim, components = MpmSpaceIsAxial(space) ? 4 : dim * (dim + 1) / 2;
  MpmBasis         basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p   = space->order[s];
      MpmPointForce  own = {.volume = part * points->volume0[p] * MpmPointJ(points, p)};

      for (PetscInt a = 0; a < dim; a++) own.body[a] = part * mass[p] * points->mass[p] * sum->step.gravity[a];
      for (PetscInt c = 0; c < components; c++) own.stress[c] = stress[c][p];
      MpmSpaceEvaluate(space, group, p, &basis);
      MpmPointAddForce(sum, &basis, group, p, &own, force);
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}
