/*
  Depths of a body's columns.
*/
#include "options/options.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "release/body_depth.h"

struct _p_MpmBodyDepth {
  const MpmBed *bed;
  MpmShapeType  shape;
  MpmEdgeType   edge;
  PetscReal     depth, level;
  PetscBool     to_level;
  MpmMap        map; /* of depths, or without pixels */
};

/* A number, or else a map of depths. */
static PetscErrorCode ReadMap(const MpmOptions *block, const char text[], MpmBodyDepth depth)
{
  const MpmMapAsk ask                      = {.project = depth->bed->project};
  char            message[MPM_MAP_MESSAGE] = "";
  char           *end, *file;

  PetscFunctionBeginUser;
  depth->depth = strtod(text, &end);
  if (end != text && !*end) {
    MpmCheckInput(depth->depth > 0. && !PetscIsInfOrNanReal(depth->depth), "-%sdepth %s: must be > 0", block->prefix,
                  text);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrallocpy(text, &file));
  PetscCall(MpmOptionsResolve(block, "depth", &file));
  PetscCall(MpmMapRead(file, &ask, &depth->map, message));
  MpmCheckInput(!message[0], "-%sdepth %s: %s", block->prefix, file, message);
  PetscCall(PetscFree(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyDepthCreate(const MpmOptions *block, const MpmBed *bed, MpmShapeType shape, MpmEdgeType edge,
                                  MpmBodyDepth *handle)
{
  MpmBodyDepth depth;
  char        *text;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&depth));
  *handle      = depth;
  depth->bed   = bed;
  depth->shape = shape;
  depth->edge  = edge;
  PetscCall(MpmOptionsText(block, "depth",
                           "with -mpm_physics depth_averaged: vertical depth, m: a number, or a map of it", NULL,
                           MPM_OPTIONAL, &text));
  PetscCall(MpmOptionsReal(block, "level", "m", "instead of the depth: the ground is filled up to this height",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &depth->level, &depth->to_level));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  MpmCheckInput(text || depth->to_level, "-%sdepth is missing: or a level", block->prefix);
  MpmCheckInput(!text || !depth->to_level, "-%slevel: the depth is given, too", block->prefix);
  if (text) PetscCall(ReadMap(block, text, depth));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyDepthDestroy(MpmBodyDepth *depth)
{
  PetscFunctionBeginUser;
  if (!*depth) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMapDestroy(&(*depth)->map));
  PetscCall(PetscFree(*depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weights of a point on one axis. */
typedef struct {
  PetscReal weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH];
} Room;

/* Height of the bed as the weights of a point have it. */
static PetscReal Height(MpmBodyDepth depth, const MpmGrid *grid, const PetscReal x[], const PetscReal half[])
{
  MpmShapeLine line[2];
  Room         room[2];
  PetscReal    height = 0.;

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal xi = (x[a] - grid->lower[a]) / grid->h[a];
    const PetscReal in = PetscMin(xi, (PetscReal)grid->cells[a] - xi);

    line[a] = (MpmShapeLine){.weight = room[a].weight, .gradient = room[a].gradient};
    MpmShapeEvaluate(depth->shape, depth->edge, xi, PetscMax(PetscMin(half[a] / grid->h[a], in), 0.), 0, grid->cells[a],
                     &line[a]);
  }
  for (PetscInt j = 0; j < line[1].count; j++) {
    for (PetscInt i = 0; i < line[0].count; i++) {
      const PetscInt node[MPM_MAX_DIM] = {line[0].first + i, line[1].first + j, 0};
      PetscReal      at[MPM_MAX_DIM];

      MpmGridNodeAtStart(grid, node, at);
      height += line[0].weight[i] * line[1].weight[j] * MpmBedHeight(depth->bed, at);
    }
  }
  return height;
}

#define ROUNDING 1e-9 /* of a cell: depths from maps that are none */

PetscReal MpmBodyDepthAt(MpmBodyDepth depth, const MpmGrid *grid, const PetscReal x[], const PetscReal half[])
{
  PetscReal from_map;

  if (depth->to_level) return depth->level - Height(depth, grid, x, half);
  if (!depth->map.value) return depth->depth;
  from_map = MpmMapAt(&depth->map, x);
  return from_map > ROUNDING * grid->h[0] ? from_map : 0.;
}
