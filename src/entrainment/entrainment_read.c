/*
  Options of erosion and deposition.
*/
#include "talus/point/basal.h"
#include "base/rows.h"
#include "options/options.h"
#include "handover/handover.h"
#include "particles/body.h"
#include "point/basal_map.h"
#include "entrainment/entrainment_impl.h"

/* A number or a map; `given`: there is one. */
static PetscErrorCode ReadByPlace(const MpmOptions *block, const MpmParameter *row, MpmByPlace *of)
{
  PetscBool is;

  PetscFunctionBeginUser;
  PetscCall(MpmBasalMapRead(block, row, &of->map, &is));
  if (is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsReal(block, row->name, row->unit, row->help, ((MpmRange){0., PETSC_INFINITY, PETSC_FALSE}),
                           MPM_OPTIONAL, &of->number, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where an option of a block is given. */
static PetscErrorCode HasAny(const MpmOptions *block, PetscInt count, const char *const names[], PetscBool *any)
{
  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  for (PetscInt k = 0; k < count; k++) {
    PetscBool given;

    PetscCall(MpmOptionsHas(block, names[k], &given));
    *any = (PetscBool)(*any || given);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadErosion(const MpmOptions *options, MpmEntrainment *of)
{
  static const char *const  names[] = {"rate", "by", "depth", "strength", "density"};
  static const char *const  ways[]  = {"shear", "distance", NULL};
  static const MpmParameter depth   = {
      MPM_NUMBER,     "depth", "m",
      PETSC_INFINITY, 0,       0.,
      HUGE_VAL,       0,       "vertical depth of the ground that may be eroded, or a map of it; default: all",
      NULL,           1.,      NULL};
  static const MpmParameter strength = {
    MPM_NUMBER, "strength", "Pa",
    0.,         0,          0.,
    HUGE_VAL,   0,          "shear stress on the bed from which on it is eroded, or a map of it",
    NULL,       1000.,      NULL};
  const MpmOptions block = {options->comm, "mpm_erosion_", options->record};
  PetscInt         way   = 0;

  PetscFunctionBeginUser;
  PetscCall(HasAny(&block, PETSC_STATIC_ARRAY_LENGTH(names), names, &of->erodes));
  if (!of->erodes && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHeading(&block, "Erosion (-mpm_physics depth_averaged)"));
  PetscCall(MpmOptionsReal(&block, "rate", "m/(s Pa) or 1/m",
                           "depth eroded in a time by a stress beyond the strength; by distance: growth of the mass "
                           "along the path, part of it a metre",
                           ((MpmRange){0., PETSC_INFINITY, PETSC_TRUE}), MPM_REQUIRED, &of->erosion.rate, NULL));
  PetscCall(MpmOptionsWord(&block, "by",
                           "shear: by the stress on the bed beyond the strength; distance: along the path", ways,
                           MPM_OPTIONAL, &way, NULL));
  of->erosion.distance        = (PetscBool)way;
  of->erosion.depth.number    = PETSC_MAX_REAL;
  of->erosion.strength.number = 0.;
  PetscCall(ReadByPlace(&block, &depth, &of->erosion.depth));
  PetscCall(ReadByPlace(&block, &strength, &of->erosion.strength));
  PetscCall(MpmOptionsReal(&block, "density", "kg/m3", "of the ground, in deposits too; default: that of the flow",
                           ((MpmRange){0., PETSC_INFINITY, PETSC_TRUE}), MPM_OPTIONAL, &of->density, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadDeposition(const MpmOptions *options, MpmEntrainment *of)
{
  static const char *const names[] = {"speed", "rate"};
  const MpmOptions         block   = {options->comm, "mpm_deposition_", options->record};
  const MpmRange           range   = {0., PETSC_INFINITY, PETSC_TRUE};

  PetscFunctionBeginUser;
  PetscCall(HasAny(&block, PETSC_STATIC_ARRAY_LENGTH(names), names, &of->deposits));
  if (!of->deposits && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHeading(&block, "Deposition (-mpm_physics depth_averaged)"));
  PetscCall(MpmOptionsReal(&block, "speed", "m/s", "critical speed, below which material becomes bed", range,
                           MPM_REQUIRED, &of->deposition.speed, NULL));
  PetscCall(MpmOptionsReal(&block, "rate", "m/s", "depth that material at rest loses to the bed in a time", range,
                           MPM_REQUIRED, &of->deposition.rate, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of checkpoints. */
static PetscErrorCode AddRows(MpmModel model)
{
  MpmEntrainmentAccount *of     = &model->entrainment->account;
  const MpmRow           rows[] = {{"in", MPM_ROW_REAL, MPM_ROW_STATE, &of->in, 0, 0},
                                   {"out", MPM_ROW_REAL, MPM_ROW_STATE, &of->out, 0, 0},
                                   {"eroded", MPM_ROW_REAL, MPM_ROW_STATE, &of->eroded, 0, 0},
                                   {"deposited", MPM_ROW_REAL, MPM_ROW_STATE, &of->deposited, 0, 0},
                                   {"energy", MPM_ROW_REAL, MPM_ROW_STATE, &of->energy, 0, 0},
                                   {"mixed", MPM_ROW_REAL, MPM_ROW_STATE, &of->mixed, 0, 0},
                                   {"nodes", MPM_ROW_REAL, MPM_ROW_STATE, &of->nodes, 0, 0},
                                   {"bed", MPM_ROW_REAL, MPM_ROW_STATE, of->bed, 2, 0},
                                   {"friction", MPM_ROW_REAL, MPM_ROW_STATE, of->friction, 2, 0},
                                   {"carried", MPM_ROW_REAL, MPM_ROW_STATE, of->carried, 2, 0}};

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, "entrainment_", PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Those of the bodies. */
static PetscErrorCode FindInlets(const MpmBodies *bodies, MpmEntrainment *of)
{
  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < bodies->count; b++) {
    const struct MpmHandover *from = MpmBodyHandover(bodies->at[b]);

    if (!from || !from->inlet) continue;
    PetscCall(PetscRealloc(sizeof(*of->inlet) * (size_t)(of->inlets + 1), &of->inlet));
    of->inlet[of->inlets++] = from->inlet;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentRead(MpmModel model, const MpmOptions *options)
{
  MpmBed         *bed = model->scene.deformation.bed;
  MpmEntrainment *of;

  PetscFunctionBeginUser;
  if (!bed && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&of));
  model->entrainment = of;
  of->bed            = bed;
  PetscCall(ReadErosion(options, of));
  PetscCall(ReadDeposition(options, of));
  PetscCall(FindInlets(model->scene.bodies, of));
  if (MpmOptionsHelp() || !(of->erodes || of->deposits || of->inlets)) {
    PetscCall(MpmEntrainmentDestroy(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  of->flow              = model->disc.context.bed;
  of->dissipated        = &model->state.scheme.energy.dissipated;
  of->time              = &model->state.time;
  of->flow->mixed.apart = &of->account.mixed;
  if (of->erodes || of->deposits) {
    PetscCall(MpmBedChangeCreate(model->disc.grid, bed));
    PetscCall(PetscMalloc1(1, &of->flow->on_bed.shear));
  }
  PetscCall(AddRows(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentDestroy(MpmModel model)
{
  MpmEntrainment *of = model->entrainment;

  PetscFunctionBeginUser;
  if (!of) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMapDestroy(&of->erosion.depth.map));
  PetscCall(MpmMapDestroy(&of->erosion.strength.map));
  PetscCall(PetscFree(of->inlet));
  PetscCall(PetscFree(of->push));
  PetscCall(PetscFree(model->entrainment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentAddTerm(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->entrainment) PetscCall(MpmTermsAdd(&model->disc.terms, &MpmTermEntrainment, model->entrainment));
  PetscFunctionReturn(PETSC_SUCCESS);
}
