/*
  Reading of sections and profiles.
*/
#include "base/axes.h"
#include "options/options.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "selection/selection.h"
#include "problem/section.h"
#include "query/model.h"
#include "observe/lines.h"
#include "observe/profile.h"
#include "observe/results.h"

/* The grid's extent along n, between its corners. */
static void ExtentAlong(const MpmGrid *grid, const PetscReal n[], PetscReal *lower, PetscReal *upper)
{
  *lower = *upper = 0.;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal room = MPM_TOLERANCE * grid->h[a];

    *lower += PetscMin(n[a] * (grid->lower[a] - room), n[a] * (grid->upper[a] + room));
    *upper += PetscMax(n[a] * (grid->lower[a] - room), n[a] * (grid->upper[a] + room));
  }
}

/* True where all places, `count` from first to last, are beyond the grid; with their normal `across`, the planes
   there. */
static PetscBool IsOutside(const MpmGrid *grid, const PetscReal first[], const PetscReal last[], PetscInt count,
                           const PetscReal *across)
{
  for (PetscInt k = 0; k < count; k++) {
    const PetscReal part    = count > 1 ? (PetscReal)k / (PetscReal)(count - 1) : 0.;
    PetscBool       outside = PETSC_FALSE;
    PetscReal       d       = 0., lower, upper;

    for (PetscInt a = 0; a < grid->dim; a++) {
      const PetscReal x = (1. - part) * first[a] + part * last[a], room = MPM_TOLERANCE * grid->h[a];

      if (x < grid->lower[a] - room || x > grid->upper[a] + room) outside = PETSC_TRUE;
      if (across) d += across[a] * x;
    }
    if (across) {
      ExtentAlong(grid, across, &lower, &upper);
      outside = (PetscBool)(d < lower || d > upper);
    }
    if (!outside) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

static PetscErrorCode ReadPlanes(const MpmOptions *block, PetscInt dim, MpmSection *section)
{
  const PetscBool help = MpmOptionsHelp();
  PetscBool       row, has_normal;
  PetscReal       span = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "point", "m", "a place on the plane, or on the first one of a row", MPM_RANGE_ANY,
                            MPM_REQUIRED, dim, section->first, NULL));
  PetscCall(MpmOptionsReals(block, "end", "m", "a place on the last plane of a row", MPM_RANGE_ANY, MPM_OPTIONAL, dim,
                            section->last, &row));
  section->count = row || help ? 21 : 1;
  if (row || help)
    PetscCall(
      MpmOptionsInt(block, "count", "planes of a row, evenly spaced", 2, 100000, MPM_OPTIONAL, &section->count, NULL));
  PetscCall(MpmOptionsReals(block, "normal", "-", "of the planes; default: from point to end", MPM_RANGE_ANY,
                            MPM_OPTIONAL, dim, section->axis[0], &has_normal));
  for (PetscInt a = 0; a < dim && row; a++) span += PetscAbsReal(section->last[a] - section->first[a]);
  MpmCheckInput(!row || span > 0. || help, "-%send: must not be -%spoint", block->prefix, block->prefix);
  MpmCheckInput(row || has_normal || help, "-%snormal is missing: a single plane needs it", block->prefix);
  for (PetscInt a = 0; a < dim; a++) {
    if (!row) section->last[a] = section->first[a];
    if (!has_normal) section->axis[0][a] = section->last[a] - section->first[a];
  }
  MpmCheckInput(MpmAxesComplete(dim, section->axis) || help, "-%snormal: must not be zero", block->prefix);
  if (row || help)
    PetscCall(MpmOptionsBool(block, "follow",
                             "the row moves along its normal with the material that it cuts: its first and last plane "
                             "are at the ends of it",
                             &section->follow, NULL));
  PetscCall(MpmOptionsReals(block, "about", "m", "what moments are about; default: the centroid of each cut",
                            MPM_RANGE_ANY, MPM_OPTIONAL, dim, section->about, &section->has_about));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* `moves`: the grid does. */
static PetscErrorCode CreateSection(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscBool moves,
                                    const MpmBodies *bodies, MpmSection *section)
{
  char       prefix[256], field[256];
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];
  PetscBool  has_region;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(section, sizeof(*section)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_section_%s_", name));
  PetscCall(PetscSNPrintf(field, sizeof(field), "section_%s", name));
  PetscCall(PetscStrallocpy(name, &section->name));
  PetscCall(MpmOptionsHeading(&block, "Section"));
  PetscCall(ReadPlanes(&block, grid->dim, section));
  MpmCheckInput(moves || MpmOptionsHelp() ||
                  !IsOutside(grid, section->first, section->last, section->count, section->axis[0]),
                "-%spoint: no plane of it meets the grid", prefix);
  PetscCall(MpmBodyNameRead(&block, "the body that is cut; default: all", bodies, &section->body));
  PetscCall(MpmOptionsHas(&block, "region", &has_region));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  if (has_region || MpmOptionsHelp()) PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &section->region));
  if (section->body >= 0 || section->region) PetscCall(PetscStrallocpy(field, &section->chosen_field));
  PetscCall(PetscCalloc1(section->count, &section->cuts));
  for (PetscInt k = 0; k < section->count; k++) {
    const PetscReal part = section->count > 1 ? (PetscReal)k / (PetscReal)(section->count - 1) : 0.;
    PetscReal       d2   = 0.;

    for (PetscInt a = 0; a < grid->dim; a++) d2 += PetscSqr(section->last[a] - section->first[a]);
    section->cuts[k].distance = part * PetscSqrtReal(d2);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* `moves`: the grid does. */
static PetscErrorCode CreateProfile(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscBool moves,
                                    const MpmBodies *bodies, MpmProfile *profile)
{
  const PetscInt  dim  = grid->dim;
  const PetscBool help = MpmOptionsHelp();
  char            prefix[256], field[256];
  MpmOptions      block = {options->comm, prefix, options->record};
  PetscReal       span  = 0.;
  PetscBool       has_normal;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(profile, sizeof(*profile)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_profile_%s_", name));
  PetscCall(PetscSNPrintf(field, sizeof(field), "profile_%s", name));
  PetscCall(PetscStrallocpy(name, &profile->name));
  PetscCall(MpmOptionsHeading(&block, "Profile"));
  PetscCall(MpmOptionsReals(&block, "from", "m", "the line's first place", MPM_RANGE_ANY, MPM_REQUIRED, dim,
                            profile->first, NULL));
  PetscCall(
    MpmOptionsReals(&block, "to", "m", "its last place", MPM_RANGE_ANY, MPM_REQUIRED, dim, profile->last, NULL));
  profile->count = 50;
  PetscCall(MpmOptionsInt(&block, "count", "places, evenly spaced", 2, 1000000, MPM_OPTIONAL, &profile->count, NULL));
  PetscCall(MpmOptionsReals(
    &block, "normal", "-", "of the plane on which stress acts; default in 2D: at right angles to the line, to its left",
    MPM_RANGE_ANY, MPM_OPTIONAL, dim, profile->axis[0], &has_normal));
  for (PetscInt a = 0; a < dim; a++) span += PetscAbsReal(profile->last[a] - profile->first[a]);
  MpmCheckInput(span > 0. || help, "-%sto: must not be -%sfrom", prefix, prefix);
  MpmCheckInput(has_normal || dim == 2 || help, "-%snormal is missing: in 3D a line has many", prefix);
  if (!has_normal && dim == 2) {
    profile->axis[0][0] = profile->first[1] - profile->last[1];
    profile->axis[0][1] = profile->last[0] - profile->first[0];
  }
  MpmCheckInput(MpmAxesComplete(dim, profile->axis) || help, "-%snormal: must not be zero", prefix);
  MpmCheckInput(moves || help || !IsOutside(grid, profile->first, profile->last, profile->count, NULL),
                "-%sfrom: no place of the line is in the grid", prefix);
  PetscCall(MpmBodyNameRead(&block, "the body whose stress it is; default: all", bodies, &profile->body));
  if (profile->body >= 0) PetscCall(PetscStrallocpy(field, &profile->chosen_field));
  profile->size = MpmSymSize(dim);
  PetscCall(PetscCalloc1((profile->count * profile->size), &profile->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLinesRead(MpmModel model, const MpmOptions *options)
{
  const PetscBool moves = (PetscBool)(model->scene.follow.what != MPM_FOLLOW_NOTHING);
  MpmLines       *lines = &model->results->lines;
  PetscInt        count;
  char          **names;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsBlocks(options, "sections", "names of the cuts whose forces are wanted", MPM_OPTIONAL, &count, &names));
  if (count) {
    MpmSections *sections;

    PetscCall(PetscNew(&sections));
    model->disc.sections = sections;
    sections->names      = names;
    PetscCall(PetscCalloc1(count, &sections->at));
    for (sections->count = 0; sections->count < count; sections->count++)
      PetscCall(CreateSection(options, names[sections->count], model->disc.grid, moves, model->scene.bodies,
                              &sections->at[sections->count]));
  } else PetscCall(MpmNamesDestroy(count, &names));
  PetscCall(MpmOptionsBlocks(options, "profiles", "names of the lines along which stress is wanted", MPM_OPTIONAL,
                             &count, &lines->profile_names));
  PetscCall(PetscCalloc1(count, &lines->profiles));
  for (lines->profile_count = 0; lines->profile_count < count; lines->profile_count++)
    PetscCall(CreateProfile(options, lines->profile_names[lines->profile_count], model->disc.grid, moves,
                            model->scene.bodies, &lines->profiles[lines->profile_count]));
  MpmCheckInput(!model->scene.deformation.bed || !(model->disc.sections || count) || MpmOptionsHelp(),
                "-mpm_%s: there are none yet with -mpm_physics %s", model->disc.sections ? "sections" : "profiles",
                model->scene.physics.name);
  PetscFunctionReturn(PETSC_SUCCESS);
}
